"""The command palette (Ctrl+K): a list of all actions that can be searched."""

from collections.abc import Callable

from PySide6.QtCore import QEvent, QModelIndex, QObject, QSize, Qt
from PySide6.QtGui import QKeyEvent, QShowEvent, QStandardItem, QStandardItemModel
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QHeaderView,
    QLineEdit,
    QPushButton,
    QTableView,
    QWidget,
)

from hapkit_studio.gui.shell.action_set import ActionSet, matches, native
from hapkit_studio.gui.widgets import breakpoints
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import theme

_WIDE, _HIGH, _ROW = 560, 420, 28
_COLUMNS = {1: 120, 2: 150}  # px: width of the columns with menu path and keys
_LIST_KEYS = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)
_KEY = Qt.ItemDataRole.UserRole + 1  # UserRole itself is already the default role of setData
_ENABLED = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable


def _listed(actions: ActionSet, parent: QObject) -> QStandardItemModel:
    """Return a model with text, menu path and keys in each row; disabled actions cannot be selected."""
    model = QStandardItemModel(parent)
    for entry in actions.entries:
        action = actions.qt[entry.key]
        text, keys = action.text().partition("\t")[0], ", ".join(map(native, entry.keys))
        row = [QStandardItem(cell) for cell in (text, entry.menu.replace("/", " › "), keys)]
        for item in row:
            item.setData(entry.key)
            item.setFlags(_ENABLED if action.isEnabled() else Qt.ItemFlag.NoItemFlags)
        for item in row[action.isEnabled() :]:
            item.setForeground(theme.color("ink3"))
        model.appendRow(row)
    return model


class FindButton(QPushButton):
    """The button at the right end of the menu bar. It shows a text, and its shortcut as a key cap."""

    def __init__(self, opens: Callable[[], object], parent: QWidget):
        super().__init__(parent)
        self.setProperty("flat", True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setAccessibleName("Find a command")
        hint, cap = label("Find a command", "hint", wrap=False), label(native("Ctrl+K"), "key", wrap=False)
        mark(cap, "ink", "ink3")
        self._row = row = hbox(hint, cap, into=self, margins=(8, 0, 14, 0))
        row.setAlignment(cap, Qt.AlignmentFlag.AlignVCenter)
        self.clicked.connect(opens)

    def sizeHint(self) -> QSize:
        return self._row.sizeHint()


class CommandPalette(QDialog):
    """A popup. A click outside or Esc closes it; Enter or a click on a command runs the command."""

    def __init__(self, actions: ActionSet, window: QWidget):
        super().__init__(window, Qt.WindowType.Popup)
        self.setObjectName("palette")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._window, self._actions = window, actions
        self._actions.refresh()
        self.field, self.list = QLineEdit(), QTableView()
        self.field.setPlaceholderText("Find a command")
        self.field.setAccessibleName("Find a command")
        self.list.setAccessibleName("Commands")
        self.rows = _listed(self._actions, self)
        self.list.setModel(self.rows)
        self._arrange()
        self.field.textChanged.connect(self._search)
        self.field.installEventFilter(self)
        self.list.clicked.connect(self._run)
        self._search("")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """While the user types, pass navigation keys to the list, and run the selected command on Enter."""
        if event.type() != QEvent.Type.KeyPress or not isinstance(event, QKeyEvent):
            return super().eventFilter(watched, event)
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._run(self.list.currentIndex())
        elif event.key() in _LIST_KEYS:
            self.list.keyPressEvent(event)
        else:
            return super().eventFilter(watched, event)
        return True

    def showEvent(self, event: QShowEvent) -> None:
        """Open in the middle of the window below its header, so that the E-stop stays visible."""
        super().showEvent(event)
        parent = self._window
        corner = parent.mapToGlobal(parent.rect().topLeft())
        self.move(
            corner.x() + (parent.width() - self.width()) // 2,
            corner.y() + theme.px(_ROW + breakpoints.HEADER_HEIGHT + 8),
        )
        self.field.setFocus()

    def _arrange(self) -> None:
        table = self.list
        table.setObjectName("rows")
        table.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        table.setShowGrid(False)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.horizontalHeader().hide()
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(theme.px(_ROW))
        for column, wide in _COLUMNS.items():
            table.setColumnWidth(column, theme.px(wide))
        table.horizontalHeader().setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        vbox(self.field, (table, 1), into=self, margins=(12, 12, 12, 8), gap=8)
        self.setFixedSize(theme.px(_WIDE), theme.px(_HIGH))

    def _search(self, text: str) -> None:
        """Show the matching commands and select the first enabled one."""
        first = QModelIndex()
        for row in reversed(range(self.rows.rowCount())):
            index, path = self.rows.index(row, 0), self.rows.item(row, 1).text()
            found = matches(text, f"{index.data()} {path}")
            self.list.setRowHidden(row, not found)
            first = index if found and index.flags() else first
        self.list.setCurrentIndex(first)

    def _run(self, index: QModelIndex) -> None:
        """Close, then run the chosen command."""
        if index.isValid() and index.flags():
            key = index.data(_KEY)
            self.close()
            self._actions.run(key)

"""A table of results: a click on a heading sorts the rows, and Ctrl+C copies the table."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from PySide6.QtCore import (
    QAbstractTableModel,
    QItemSelection,
    QModelIndex,
    QPersistentModelIndex,
    QPointF,
    Qt,
    Signal,
)
from PySide6.QtGui import (
    QFontMetrics,
    QGuiApplication,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPixmap,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import QAbstractItemView, QFrame, QHeaderView, QSizePolicy, QTableView

from hapkit_studio.columns import Column
from hapkit_studio.formatting import printable
from hapkit_studio.gui.widgets.theme import theme

_ROW, _GAP, _MARKER = 28, 8, 12.0  # px: height of a row, gap beside a heading, size of a marker
_PART = 6  # a column of texts takes at most 1/_PART of a list's width; a tooltip shows texts that are cut off
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
Index = QModelIndex | QPersistentModelIndex


def _marker_picture(marker: str, token: str) -> QPixmap:
    """Return a matplotlib marker as a picture in a colour of the theme."""
    from matplotlib.markers import MarkerStyle

    style, ratio = MarkerStyle(marker), 2.0
    picture = QPixmap(round(_MARKER * ratio), round(_MARKER * ratio))
    picture.fill(Qt.GlobalColor.transparent)
    picture.setDevicePixelRatio(ratio)
    painter = QPainter(picture)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.translate(0.5 * _MARKER, 0.5 * _MARKER)
    painter.scale(0.8 * _MARKER, -0.8 * _MARKER)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(theme.color(token))
    for corners in style.get_path().transformed(style.get_transform()).to_polygons():
        painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in np.asarray(corners)]))
    painter.end()
    return picture


class Rows(QAbstractTableModel):
    """The model of the table's rows in their current order."""

    def __init__(self) -> None:
        super().__init__()
        self.columns: tuple[Column, ...] = ()
        self.rows: list[Any] = []

    def show(self, columns: Iterable[Column], rows: Iterable[Any]) -> None:
        """Show these rows with these columns."""
        self.beginResetModel()
        self.columns, self.rows = tuple(columns), list(rows)
        self.endResetModel()

    def rowCount(self, _parent: Index | None = None) -> int:
        return len(self.rows)

    def columnCount(self, _parent: Index | None = None) -> int:
        return len(self.columns)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        column, row = self.columns[index.column()], self.rows[index.row()]
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole):
            return printable(column.text(row))
        if role == Qt.ItemDataRole.ForegroundRole:
            return theme.color(column.token(row))
        if role == Qt.ItemDataRole.BackgroundRole and column.ground is not None:
            return theme.color(column.ground(row))
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if column.right else _LEFT
        if role == Qt.ItemDataRole.DecorationRole and column.mark is not None:
            return _marker_picture(*column.mark(row))
        return None

    def headerData(self, section: int, way: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if way != Qt.Orientation.Horizontal or section >= len(self.columns):
            return None
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _RIGHT if self.columns[section].right else _LEFT
        return self.columns[section].head if role == Qt.ItemDataRole.DisplayRole else None

    def sort(self, column: int, way: Qt.SortOrder = Qt.SortOrder.AscendingOrder) -> None:
        if 0 <= column < len(self.columns):
            chosen = self.columns[column]
            self.layoutAboutToBeChanged.emit()
            self.rows.sort(key=chosen.order or chosen.text, reverse=way == Qt.SortOrder.DescendingOrder)
            self.layoutChanged.emit()


class Table(QTableView):
    """A table whose rows can be selected.

    ``chosen`` is emitted with the selected row, or with None when a second click deselects it. If ``cells``
    is True, the user selects cells instead of rows (``cell_chosen`` is emitted with row and column), and the
    table fills the available height. If ``scrolls`` is True, each row has one line, and the table fills the
    available height.
    """

    chosen = Signal(object)
    cell_chosen = Signal(object, int)

    def __init__(self, name: str, cells: bool = False, scrolls: bool = False) -> None:
        super().__init__()
        self._cells, self._tall, self._lists = cells, cells or scrolls, scrolls
        self.content = Rows()
        self.setModel(self.content)
        self.setAccessibleName(name)
        behavior = QAbstractItemView.SelectionBehavior
        self.setSelectionBehavior(behavior.SelectItems if cells else behavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTabKeyNavigation(False)
        self.setShowGrid(cells)
        self.setWordWrap(not scrolls)
        self.setFrameShape(QFrame.Shape.NoFrame)
        up = QSizePolicy.Policy.Expanding if self._tall else QSizePolicy.Policy.Fixed
        self.setSizePolicy(QSizePolicy.Policy.Expanding, up)
        if not self._tall:  # the table's height is that of its rows
            self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.horizontalHeader().setMinimumSectionSize(_GAP)
        self.horizontalHeader().setHighlightSections(cells)
        self.verticalHeader().hide()
        if cells:
            self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.setObjectName("cells" if cells else "rows")
        theme.changed.connect(self._size_columns)
        self.show_rows((), ())

    def show_rows(self, columns: Iterable[Column], rows: Iterable[Any]) -> None:
        """Show rows in the given order; the first column takes the remaining width."""
        self.setSortingEnabled(False)
        self.content.show(columns, rows)
        head = self.horizontalHeader()
        head.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        for index in range(len(self.content.columns)):
            fixed = bool(index) != self._cells
            mode = QHeaderView.ResizeMode.Fixed if fixed else QHeaderView.ResizeMode.Stretch
            head.setSectionResizeMode(index, mode)
        self._size_columns()
        self.setSortingEnabled(True)

    def _size_columns(self) -> None:
        """Fit the width of each column to its texts."""
        metrics = QFontMetrics(theme.font("hint"))
        for index, column in enumerate(self.content.columns):
            wide = metrics.size(0, column.head).width() + _GAP  # this also leaves space for the sort arrow
            width = max(wide, self.sizeHintForColumn(index))
            cut = self._lists and not column.right
            self.setColumnWidth(index, min(width, self.viewport().width() // _PART) if cut else width)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if self._lists:
            self._size_columns()
        else:
            self._fit()

    def _fit(self) -> None:
        """Fit the table's height to all rows; text is wrapped in narrow columns."""
        lines = self.sizeHintForRow(0) if self._cells and self.content.rows else 0
        self.verticalHeader().setMinimumSectionSize(max(theme.px(_ROW), lines))
        if self._tall:
            return
        self.setVisible(bool(self.content.rows))
        self.resizeRowsToContents()
        tall = self.horizontalHeader().sizeHint().height() + self.verticalHeader().length() + 4
        self.setFixedHeight(tall if self.content.rows else 0)

    def texts(self) -> list[tuple[str, ...]]:
        """Return the headings and the rows in their current order."""
        columns, rows = self.content.columns, self.content.rows
        return [tuple(c.head for c in columns), *(tuple(c.text(row) for c in columns) for row in rows)]

    def copy(self) -> None:
        """Copy the table to the clipboard with one line per row and tabs between the columns."""
        lines = ["\t".join(text.replace("\n", " ") for text in row) for row in self.texts()]
        QGuiApplication.clipboard().setText("\n".join(lines))

    def selectionChanged(self, selected: QItemSelection, deselected: QItemSelection) -> None:
        super().selectionChanged(selected, deselected)
        rows = self.selectionModel().selectedRows() if self.selectionModel() else []
        self.chosen.emit(self.content.rows[rows[0].row()] if rows else None)

    def currentChanged(self, current: Index, previous: Index) -> None:
        super().currentChanged(current, previous)
        if current.isValid():
            self.cell_chosen.emit(self.content.rows[current.row()], current.column())

    def mousePressEvent(self, event: QMouseEvent) -> None:
        index = self.indexAt(event.position().toPoint())
        if not self._cells and index.isValid() and self.selectionModel().isSelected(index):
            self.clearSelection()
        else:
            super().mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            self.copy()
        else:
            super().keyPressEvent(event)

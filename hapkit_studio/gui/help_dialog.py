"""Sheets beside the work: the keys, real-time priority, about. None of them blocks the window."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDialog, QGridLayout, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui.actions import Action
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.theme import theme

HAND_KEYS = (
    ("Hand 1 mm left, right", "← →"),
    ("Hand 0.1 mm left, right", "Shift+← →"),
    ("Hand lets go", "↓"),
    ("Slider, number: one step", "← → ↑ ↓"),
    ("Slider, number: ten steps", "Page Up, Page Down"),
    ("Slider, number: limits", "Home, End"),
)


class Sheet(QDialog):
    """A window of words that stays beside the work; its motor goes on, so it never blocks.

    A second one of the same title takes the place of the first.
    """

    def __init__(self, title: str, parent: QWidget | None = None):
        super().__init__(parent)
        self.setWindowTitle(title)
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._replace_older()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(20, 16, 20, 16)
        self.column.setSpacing(12)
        heading = plain(QLabel(title))
        heading.setFont(theme.font("title"))
        self.column.addWidget(heading)

    def _replace_older(self) -> None:
        parent = self.parent()
        for old in parent.findChildren(Sheet) if parent else ():
            if old is not self and old.isVisible() and old.windowTitle() == self.windowTitle():
                self.move(old.pos())
                old.close()

    def finish(self) -> None:
        """Add the closing button."""
        close = QPushButton("Close")
        close.clicked.connect(self.close)
        self.column.addWidget(close, 0, Qt.AlignmentFlag.AlignRight)


def native(key: str) -> str:
    """Return a key as this system writes it."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


def keys_sheet(actions: tuple[Action, ...], parent: QWidget | None = None) -> Sheet:
    """Return the sheet of all keys, made from the action table."""
    sheet = Sheet("Keys", parent)
    lines = [(a.text, ", ".join(native(k) for k in a.keys)) for a in actions if a.keys]
    body = QWidget()
    grid = QGridLayout(body)
    grid.setContentsMargins(0, 0, 12, 0)
    grid.setHorizontalSpacing(28)
    grid.setVerticalSpacing(4)
    for row, (words, keys) in enumerate([*lines, *HAND_KEYS]):
        grid.addWidget(QLabel(words), row, 0)
        cap = QLabel(keys)
        cap.setProperty("role", "axis")
        grid.addWidget(cap, row, 1)
    scroll = QScrollArea()
    scroll.setWidgetResizable(True)
    scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scroll.setWidget(body)
    scroll.setMinimumWidth(body.sizeHint().width() + 16)
    scroll.setMinimumHeight(min(body.sizeHint().height() + 4, 420))
    sheet.column.addWidget(scroll)
    sheet.finish()
    return sheet


def words_sheet(title: str, paragraphs: list[str], parent: QWidget | None = None) -> Sheet:
    """Return a sheet of paragraphs that can be selected and copied."""
    sheet = Sheet(title, parent)
    for paragraph in paragraphs:
        label = plain(QLabel(paragraph))
        label.setWordWrap(True)
        label.setMinimumWidth(460)
        label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        sheet.column.addWidget(label)
    sheet.finish()
    return sheet

"""A sheet that asks and answers: what it is for, labelled fields, an answer line, buttons."""

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QPoint
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from hapkit_studio.gui import banners, header
from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.help_dialog import Sheet
from hapkit_studio.gui.rich import plain
from hapkit_studio.gui.tabs.bar import PRIMARY
from hapkit_studio.gui.tabs.verdict_line import VerdictLine

_WIDTH = 520
_LINE = 20


class FormSheet(Sheet):
    """Parts are added from top to bottom; ``verdict`` is the answer line."""

    def __init__(self, title: str, about: str, parent: QWidget | None = None):
        super().__init__(title, parent)
        self.verdict = VerdictLine("")
        words = plain(QLabel(about))
        words.setWordWrap(True)
        words.setMinimumWidth(_WIDTH)
        self.column.addWidget(words)

    def showEvent(self, event: QShowEvent) -> None:
        """Open below the window's banners: a fault, and what clears it, stay in sight."""
        super().showEvent(event)
        parent = self.parentWidget()
        if parent is not None and not event.spontaneous():
            top = parent.window().mapToGlobal(QPoint(0, header.HEIGHT + banners.MOST * banners.HEIGHT)).y()
            if self.y() < top:
                self.move(self.x(), top)

    def add_fields(self, fields: Iterable[tuple[str, QWidget, QWidget | None]]) -> None:
        """Add rows of a label, a widget, and what stands behind it."""
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setColumnStretch(1, 1)
        for row, (words, widget, behind) in enumerate(fields):
            label = plain(QLabel(words))
            label.setProperty("role", "axis")
            label.setBuddy(widget)
            widget.setAccessibleName(words)
            grid.addWidget(label, row, 0)
            grid.addWidget(widget, row, 1)
            if behind is not None:
                grid.addWidget(behind, row, 2)
        self.column.addLayout(grid)

    def add_verdict(self, lines: int) -> None:
        """Add the answer line with room for so many lines, so that nothing moves when it comes."""
        self.verdict.setContentsMargins(-16, 0, -16, 0)
        self.verdict.setMinimumHeight(_LINE * lines + 4)
        self.column.addWidget(self.verdict)

    def add_buttons(self, primary: QPushButton, left: Sequence[QPushButton] = ()) -> None:
        """Add the row of buttons, the one that does it and the closing one at the right."""
        dress(primary, PRIMARY)
        row = QHBoxLayout()
        for button in left:
            row.addWidget(button)
        row.addStretch(1)
        self.leave = QPushButton("Close")
        self.leave.clicked.connect(self.close)
        row.addWidget(primary)
        row.addWidget(self.leave)
        self.column.addLayout(row)

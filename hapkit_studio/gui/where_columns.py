"""What each way of rendering comes to, side by side or a line each; the way that renders in the accent."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from hapkit_studio.gui.dress import dress, mark
from hapkit_studio.gui.where_facts import HINTS, ROWS, UNKNOWN

NAMES = "Computer", "Board"
_SHEET = 'QLabel[on="true"] { color: @accent; font-weight: 650; } QLabel { font-size: 12px; }'


class Facts(QWidget):
    """A row for each fact, two columns, the way that renders in the accent."""

    def __init__(self) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 2)
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(0, 1)
        self.heads = [QLabel(name) for name in NAMES]
        self.values = [[QLabel(UNKNOWN) for _ in ROWS] for _ in NAMES]
        for column, (head, values) in enumerate(zip(self.heads, self.values, strict=True), start=1):
            for row, label in enumerate((head, *values)):
                label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                grid.addWidget(label, row, column)
        for row, (name, hint) in enumerate(zip(ROWS, HINTS, strict=True), start=1):
            label = QLabel(name)
            label.setToolTip(hint)
            grid.addWidget(label, row, 0)
        dress(self, _SHEET)

    def show_way(self, column: int, texts: tuple[str, ...], on: bool) -> None:
        """Show one way's texts in the order of ROWS; on: it renders now."""
        for label, text in zip(self.values[column], texts, strict=True):
            label.setText(text)
        for label in (self.heads[column], *self.values[column]):
            mark(label, "on", on)


class Lines(QWidget):
    """A line a way, for where room is short: name, delay and limit; the way that renders in the accent."""

    def __init__(self) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 2, 0, 4)
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(1)
        grid.setColumnStretch(0, 1)
        self.ways = [[QLabel(name), QLabel(), QLabel()] for name in NAMES]
        for row, labels in enumerate(self.ways):
            for column, label in enumerate(labels):
                side = Qt.AlignmentFlag.AlignRight if column else Qt.AlignmentFlag.AlignLeft
                label.setAlignment(side | Qt.AlignmentFlag.AlignVCenter)
                label.setToolTip(("", HINTS[0], HINTS[2])[column])
                grid.addWidget(label, row, column)
        dress(self, _SHEET)

    def show_way(self, row: int, texts: tuple[str, ...], on: bool) -> None:
        """Show a way's delay and limit; on: it renders now."""
        for label, text in zip(self.ways[row][1:], texts, strict=True):
            label.setText(text)
        for label in self.ways[row]:
            mark(label, "on", on)

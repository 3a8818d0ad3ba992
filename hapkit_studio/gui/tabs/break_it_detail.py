"""The chosen failure: its knob, the verdict, a trace on each side of the limit, the curve over the knob."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui.dress import dress
from hapkit_studio.gui.tabs.break_it_curve import CurveCard
from hapkit_studio.gui.tabs.break_it_knob import KnobBar
from hapkit_studio.gui.tabs.break_it_record import ABOVE, BELOW, Record
from hapkit_studio.gui.tabs.break_it_traces import TraceCard
from hapkit_studio.gui.tabs.break_it_verdict import Verdict

_LEAST = (560, 350)
_READABLE = 440  # px: two traces and a chart that can be read


class Sheet(QWidget):
    """Gives what is on it all of its room, and never less than the least: it does not ask for more."""

    def __init__(self, inside: QWidget):
        super().__init__()
        self._inside = inside
        inside.setParent(self)
        self.setMinimumSize(*_LEAST)
        self.setObjectName("sheet")
        dress(self, "#sheet { background: @surface; }")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._inside.setGeometry(self.rect())


class Detail(QScrollArea):
    """Scrolls only where the window is smaller than it was laid out for."""

    def __init__(self, record: Record):
        super().__init__()
        self.knob, self.verdict, self.curve = KnobBar(record), Verdict(), CurveCard()
        self.traces = {side: TraceCard(side) for side in (BELOW, ABOVE)}
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.setContentsMargins(14, 8, 12, 10)
        column.setSpacing(8)
        column.addWidget(self.knob)
        column.addWidget(self.verdict)
        column.addLayout(self._charts(), 1)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self._sheet = Sheet(inside)
        self.setWidget(self._sheet)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Scroll rather than press charts flat where the window is low."""
        super().resizeEvent(event)
        low = self.viewport().height() < _LEAST[1]
        self._sheet.setMinimumHeight(_READABLE if low else _LEAST[1])

    def show_results(self, record: Record) -> None:
        """Show traces and curve as they are known."""
        for card in self.traces.values():
            card.show_record(record)
        self.curve.show_record(record)

    def _charts(self) -> QHBoxLayout:
        left = QVBoxLayout()
        left.setSpacing(6)
        for card in self.traces.values():
            left.addWidget(card, 1)
        charts = QHBoxLayout()
        charts.setSpacing(14)
        charts.addLayout(left, 5)
        charts.addWidget(self.curve, 6)
        return charts

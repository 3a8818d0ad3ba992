"""The chosen failure: its knob, the verdict, a trace on each side of the limit, the curve over the knob."""

from operator import is_
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui.tabs.break_it.knob import KnobBar
from hapkit_studio.gui.tabs.break_it.record import ABOVE, BELOW, CHART, HERE, Record, Try
from hapkit_studio.gui.tabs.break_it.verdict import Verdict
from hapkit_studio.gui.tabs.drawing import Drawing
from hapkit_studio.gui.widgets.style import dress

if TYPE_CHECKING:
    from hapkit_studio.charts.failures import Knob, Picture

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
    """Emits ``picked`` with a share of the limit where a person clicks or drags on the curve.

    It scrolls only where the window is smaller than it was laid out for.
    """

    picked = Signal(float)

    def __init__(self, record: Record):
        super().__init__()
        self.knob, self.verdict = KnobBar(record), Verdict()
        self.chart = Drawing("Traces on both sides of the limit, and the failure over its knob", (200, 120))
        self.chart.clicked.connect(self._pick)
        self.chart.dragged.connect(self._pick)
        self._record = record
        self._parts: tuple = (None,) * 4
        self._state: tuple = ()
        self._picture = picture_of(record)
        self._stands: Knob | None = None
        inside = QWidget()
        column = QVBoxLayout(inside)
        column.setContentsMargins(14, 8, 12, 10)
        column.setSpacing(8)
        column.addWidget(self.knob)
        column.addWidget(self.verdict)
        column.addWidget(self.chart, 1)
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
        """Show traces and curve as they are known; where the knob alone was turned, it alone moves."""
        parts = (record.failure, record.below, record.above, record.chart)
        state = (record.limit, record.old - {HERE})
        same = all(map(is_, parts, self._parts)) and state == self._state
        self._record, self._parts, self._state = record, parts, state
        if same:
            self._place()
            self.chart.follow()
        else:
            self._picture = picture_of(record)
            self.chart.show_drawing(self._paint)

    def _paint(self, figure, colors):
        from hapkit_studio.charts.failures import draw

        self._stands = draw(figure, colors, self._picture)
        self._place()
        return self._stands.artists if self._stands else ()

    def _place(self) -> None:
        """Show where the knob stands, and what it showed there."""
        from hapkit_studio.charts.failures import measured_there

        if self._stands is not None:
            here, chart = self._record.here, self._record.chart
            self._stands.place(self._record.value, measured_there(chart, here.evidence) if here else None)

    def _pick(self, x: float, _y: float) -> None:
        """Turn the knob to a place across, where the chart runs over the knob."""
        scale = self._picture.scale
        if scale is not None and self._record.limit is not None:
            low, high = self._record.failure.span
            self.picked.emit(min(max(x / scale / self._record.limit, low), high))


def picture_of(record: Record) -> "Picture":
    """Return what is drawn of a record."""
    from hapkit_studio.charts.failures import Picture, Tried

    def tried(one: Try | None, side: str) -> Tried | None:
        return Tried(one.value, one.evidence, side in record.old) if one else None

    below, above = tried(record.below, BELOW), tried(record.above, ABOVE)
    return Picture(record.failure, record.limit, below, above, record.chart, CHART in record.old)

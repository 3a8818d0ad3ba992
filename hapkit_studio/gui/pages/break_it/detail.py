"""The chosen failure: its knob, the verdict, a trace on each side of the limit, the curve over the knob."""

from operator import is_
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QScrollArea, QVBoxLayout, QWidget

from hapkit_studio.gui.pages.break_it.knob import KnobBar
from hapkit_studio.gui.pages.break_it.record import ABOVE, BELOW, CHART, HERE, Record, Try, knob_text
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.charts.failures import Knob, Picture


_SIGN = 26
_BOARD = "Only the simulated Hapkit is made to fail on purpose"
_GONE = "Not in the scene any more: the scene or its values were changed by hand."
_FEEL = "Puts scene, values and loop into the window; Take back undoes that"


class Sign(QLabel):
    """A check mark, a cross, or nothing, in the theme's colours."""

    def __init__(self, size: int = _SIGN):
        super().__init__()
        self._size = size
        self._holds: bool | None = None
        self.setFixedSize(size, size)
        theme.changed.connect(self._paint)

    def show_sign(self, holds: bool | None) -> None:
        """Show that it holds, that it fails, or neither."""
        self._holds = holds
        self._paint()

    def _paint(self) -> None:
        if self._holds is None:
            self.clear()
        else:
            name, token = ("check", "ok") if self._holds else ("close", "danger")
            self.setPixmap(icons.pixmap(name, self._size, token, self.devicePixelRatioF()))


class VerdictRow(QWidget):
    """The verdict on the knob's value; emits ``feel_pressed`` and ``back_pressed``."""

    feel_pressed = Signal()
    back_pressed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.sign, self.words, self.more = Sign(_SIGN), QLabel(), QLabel()
        self.words.setWordWrap(True)
        self.more.setWordWrap(True)
        self.feel, self.back = (
            QPushButton("Feel it", autoDefault=True),
            QPushButton("Take back", autoDefault=True),
        )
        icons.bind(self.feel, "hand", "ink", 18)
        icons.bind(self.back, "reset", "ink", 18)
        self.feel.clicked.connect(self.feel_pressed)
        self.back.clicked.connect(self.back_pressed)
        lines = QVBoxLayout()
        lines.setContentsMargins(0, 0, 0, 0)
        lines.setSpacing(1)
        lines.addWidget(self.words)
        lines.addWidget(self.more)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self.sign, 0, Qt.AlignmentFlag.AlignTop)
        row.addLayout(lines, 1)
        for button in (self.back, self.feel):
            row.addWidget(button, 0, Qt.AlignmentFlag.AlignVCenter)

    def show_record(
        self, record: Record, simulated: bool, felt: bool, taken: bool, gone: bool = False
    ) -> None:
        """Show a verdict; felt: it is in the scene; gone: it was; taken: there is something to take back."""
        here = record.here
        holds = here.evidence.holds if here and not record.wrong else None
        fresh = here is not None and HERE not in record.old
        self.sign.show_sign(holds)
        self.words.setFont(theme.font("strong" if record.wrong else "readout"))
        self.words.setText(self._headline(record))
        token = "danger" if record.wrong else "ink3" if not fresh else "ok" if holds else "danger"
        dress(self.words, f"QLabel {{ color: @{token}; }}")
        live = here.live if here else None
        advice = live.advice if felt and live else ""
        more = f"In the scene now. {advice}".strip() if felt else _GONE if gone else self._where(record)
        self.more.setText(more)
        dress(self.more, f"QLabel {{ color: @{'accent' if felt else 'ink2'}; font-size: 12px; }}")
        self.feel.setVisible(record.failure.live is not None and not felt)
        self.feel.setEnabled(simulated and fresh and live is not None and not record.wrong)
        self.feel.setToolTip(_FEEL if simulated else _BOARD)
        self.back.setVisible(taken)

    @staticmethod
    def _headline(record: Record) -> str:
        if record.wrong:
            return record.wrong
        if record.here is not None:
            from hapkit_studio.charts.failures import clauses

            return clauses(record.here.evidence.words)[0]
        return "Not tried yet"

    @staticmethod
    def _where(record: Record) -> str:
        """Return the knob's value as a share of the limit, and what else there is to say."""
        if record.wrong or not record.ready or record.value is None or record.limit is None:
            return f"{record.failure.summary}."
        knob = record.failure.knob
        limit = knob_text(record.limit, knob)
        name = "" if knob.unit else f"{knob.symbol or knob.label} = "
        place = f"{name}{knob_text(record.value, knob)}, {record.share:.2f} of the limit {limit}"
        from hapkit_studio.charts.failures import clauses

        rest = clauses(record.here.evidence.words)[1:] if record.here else []
        return " ".join(f"{part}." for part in [place, *rest])


_LEAST, _LEAST_CHART = (560, 350), (200, 120)
_READABLE = 440  # px: two traces and a chart that can be read


class FixedSheet(QWidget):
    """Gives its child its whole area, never less than a minimum size; it has no size hint of its own."""

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

    def __init__(self, record: Record, chart: Drawing):
        super().__init__()
        self.knob, self.verdict, self.chart = KnobBar(record), VerdictRow(), chart
        chart.setMinimumSize(*_LEAST_CHART)
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
        self._sheet = FixedSheet(inside)
        self.setWidget(self._sheet)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Scroll where the window is too low for readable charts."""
        super().resizeEvent(event)
        low = self.viewport().height() < _LEAST[1]
        self._sheet.setMinimumHeight(_READABLE if low else _LEAST[1])

    def show_results(self, record: Record) -> None:
        """Show traces and curve as far as known; where only the knob was turned, move only its marker."""
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
        """Move the knob's marker, and the dot of what was measured there."""
        from hapkit_studio.charts.failures import measured_there

        if self._stands is not None:
            here, chart = self._record.here, self._record.chart
            self._stands.place(self._record.value, measured_there(chart, here.evidence) if here else None)

    def _pick(self, x: float, _y: float) -> None:
        """Turn the knob to a clicked place, where the chart's x axis is the knob."""
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

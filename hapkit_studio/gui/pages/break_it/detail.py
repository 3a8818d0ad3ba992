"""The chosen failure: its knob, verdict, a trace on each side of the limit, and the curve over the knob."""

from dataclasses import replace
from operator import is_

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QPushButton, QScrollArea, QSizePolicy, QWidget

from hapkit_studio.charts import plane, style
from hapkit_studio.charts.failures import Knob, clauses, draw, measured_there
from hapkit_studio.formatting import on_screen
from hapkit_studio.gui.pages.break_it.record import Record
from hapkit_studio.gui.pages.drawing import Drawing
from hapkit_studio.gui.panel.rows import ParameterRow
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import Sign, hbox, label, vbox
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import mark


class KnobBar(QWidget):
    """A knob that emits ``turned`` with a fraction of the limit.

    It is disabled while the limit is unknown.
    """

    turned = Signal(float)

    def __init__(self, record: Record):
        super().__init__()
        self._record = record
        self.row = ParameterRow(record.failure.knob)
        self._place = vbox(self.row)
        self.inside, self.outside = QPushButton(autoDefault=True), QPushButton(autoDefault=True)
        hbox((self._place, 1), vbox(self.inside, self.outside, gap=4), into=self)
        self.inside.setToolTip("Set a value just inside the limit, where the method works")
        self.outside.setToolTip("Set a value just outside the limit, where the method fails")
        self.inside.clicked.connect(lambda: self.turned.emit(1.0 - self._record.failure.margin))
        self.outside.clicked.connect(lambda: self.turned.emit(1.0 + self._record.failure.margin))
        self.show_record(record)

    def show_record(self, record: Record) -> None:
        """Show a failure's knob with a range around its limit, and set it to the limit."""
        self._record = record
        self.setEnabled(record.ready)
        knob, limit, percent = record.failure.knob, record.limit, f"{100.0 * record.failure.margin:g} %"
        if limit is not None:
            low, high = (min(max(share * limit, knob.low), knob.high) for share in record.failure.span)
            knob = replace(knob, low=low, high=high, default=limit)
        before, self.row = self.row, ParameterRow(knob)
        self._place.replaceWidget(before, self.row)
        before.hide()
        before.deleteLater()
        self.row.changed.connect(lambda _key, value: self.turned.emit(value / self._record.limit))
        self.inside.setText(f"{percent} inside the limit")
        self.outside.setText(f"{percent} outside the limit")
        self.show_value()

    def show_value(self) -> None:
        """Show the knob's value with four digits."""
        value = self._record.value
        if value is not None:
            self.row.show_value(float(f"{value:.4g}"))
            return
        with QSignalBlocker(self.row.box):
            self.row.box.lineEdit().clear()


_BOARD = "For safety, this works only with the simulated Hapkit"
_GONE = "The scene does not show this failure any more, because the scene or its values were changed."
_FEEL = (
    "Set the scene, values and loop that show this failure. The button Restore settings brings back your "
    "previous settings"
)


class VerdictRow(QWidget):
    """Shows the verdict on the knob's value; its buttons put the failure into the scene or remove it."""

    def __init__(self) -> None:
        super().__init__()
        self.sign, self.label, self.more = Sign(26), label(role="readout"), label(role="fact")
        self.feel = QPushButton("Feel this failure", autoDefault=True)
        self.back = QPushButton("Restore settings", autoDefault=True)
        icons.bind(self.feel, "hand", "ink", 18)
        icons.bind(self.back, "reset", "ink", 18)
        hbox(self.sign, (vbox(self.label, self.more), 1), self.back, self.feel, into=self)

    def show_record(
        self, record: Record, harmless: bool, felt: bool, taken: bool, gone: bool = False
    ) -> None:
        """Show the verdict on a failure.

        ``harmless``: the device has no motor. ``felt``: the failure is in the scene. ``gone``: the user has
        removed the failure from the scene. ``taken``: there are settings to restore.
        """
        here = record.here if not record.wrong else None
        fresh = here is not None and "here" not in record.old
        token = "ok" if here and here.evidence.holds else "danger"
        self.sign.show_sign("" if here is None else "check" if token == "ok" else "close", token)
        clause_list = clauses(here.evidence.text) if here else ["This value was not tried yet"]
        self.label.setText(record.wrong or clause_list[0])
        mark(self.label, "ink", token if fresh or record.wrong else "ink3")
        mark(self.label, "role", "headline" if record.wrong else "readout")
        live = here.live if here else None
        advice = live.advice if live else ""
        felt_text = f"The scene shows this failure now. {advice}".strip()
        self.more.setText(felt_text if felt else _GONE if gone else self._where(record, clause_list[1:]))
        mark(self.more, "on", felt)
        pressed = next((button for button in (self.feel, self.back) if button.hasFocus()), None)
        self.feel.setVisible(record.failure.live is not None and not felt)
        self.feel.setEnabled(harmless and fresh and live is not None)
        self.feel.setToolTip(_FEEL if harmless else _BOARD)
        self.back.setVisible(taken)
        # a hidden button would pass the keyboard focus to a spin box, which the next key press would change
        if pressed is not None and pressed.isHidden():
            (self.back if taken else self.feel).setFocus()

    @staticmethod
    def _where(record: Record, rest: list[str]) -> str:
        """Describe the knob's value as a fraction of the limit, and the rest of the verdict."""
        if record.wrong or not record.ready or record.value is None or record.limit is None:
            return f"{record.failure.summary}."
        knob = record.failure.knob
        name = "" if knob.unit else f"{knob.symbol or knob.label} = "
        here, limit = on_screen(record.value, knob.unit), on_screen(record.limit, knob.unit)
        place = f"{name}{here}, {record.share:.2f} of the limit {limit}"
        return " ".join(f"{part}." for part in [place, *rest])


class Detail(QScrollArea):
    """Shows the chosen failure; a click or drag on the curve emits ``picked``.

    ``picked`` has a fraction of the limit as its argument. Scroll bars appear only if the window is smaller
    than the minimum size of the content.
    """

    picked = Signal(float)

    def __init__(self, record: Record, chart: Drawing):
        super().__init__()
        self.knob, self.verdict, self.chart = KnobBar(record), VerdictRow(), chart
        chart.setMinimumSize(200, 120)
        # with its own size hint, the chart would make the area scroll
        chart.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        chart.clicked.connect(self._pick)
        chart.dragged.connect(self._pick)
        self._record = record
        self._parts: tuple = ()
        self._state: tuple = ()
        self._marker: Knob | plane.KnobPoint | None = None
        self.which = Segmented("Chart", ("Curve", "Map"))
        self.which.button(1).setToolTip("A map of this limit in dimensionless numbers, with measured points")
        self.which.show_index(0)
        self.which.chosen.connect(lambda _index: self.show_results(self._record))
        sheet = QWidget()
        sheet.setMinimumHeight(350)
        sheet.setObjectName("sheet")
        verdict = hbox((self.verdict, 1), self.which)
        vbox(self.knob, verdict, (chart, 1), into=sheet, margins=(14, 8, 12, 10), gap=8)
        self.setWidgetResizable(True)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setWidget(sheet)

    def show_results(self, record: Record) -> None:
        """Show the measured part of the curve or plane.

        If only the knob has changed, move only the knob's marker.
        """
        self.which.setVisible(record.failure.plane is not None)
        parts = (record.failure, record.inside, record.outside, record.chart, record.plane)
        state = (record.limit, record.old - {"here"}, self.which.index)
        same = len(parts) == len(self._parts) and all(map(is_, parts, self._parts)) and state == self._state
        self._record, self._parts, self._state = record, parts, state
        if same:
            self._place()
            self.chart.follow()
        else:
            self.chart.show_drawing(self._paint)

    @property
    def shows_plane(self) -> bool:
        """Return whether the plane of dimensionless numbers is shown; otherwise the curve is shown."""
        return (
            bool(self.which.index)
            and self._record.plane is not None
            and self._record.failure.plane is not None
        )

    def _paint(self, figure, colors):
        found = self._record.plane
        if found is not None and self.shows_plane:
            old = "plane" in self._record.old
            self._marker = plane.draw(figure, style.pale(colors) if old else colors, found)
        else:
            self._marker = draw(figure, colors, self._record)
        self._place()
        return self._marker.artists if self._marker else ()

    def _place(self) -> None:
        """Move the knob's marker and the dot that shows the result at the knob's value."""
        if isinstance(self._marker, plane.KnobPoint):
            self._marker.place(self._record.value)
        elif self._marker is not None:
            here, chart = self._record.here, self._record.chart
            self._marker.place(self._record.value, measured_there(chart, here.evidence) if here else None)

    def _pick(self, x: float, _y: float) -> None:
        """Set the knob to a clicked value if the chart's x axis shows the knob's values."""
        scale = self._record.scale
        if scale is not None and self._record.limit is not None:
            low, high = self._record.failure.span
            self.picked.emit(min(max(x / scale / self._record.limit, low), high))

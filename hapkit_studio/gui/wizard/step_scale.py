"""The step Scale: the user holds the handle at marks, which give zero and scale.

Radii that the user enters are only compared with this scale.
"""

from PySide6.QtWidgets import QLabel

from hapkit_studio.analysis.calibrate.result import FAIL, PASS, CheckResult
from hapkit_studio.analysis.calibrate.scale import Mark, Scale
from hapkit_studio.formatting import number
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.wizard.board_dialog import SIGNS
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.step_page import StepPage, ThousandthsBox

REACH = 0.050
"""m: marks are allowed within this distance on either side."""
PLACES = (0.0, -0.020, 0.020, 0.0)
_SAME = 6e-6
"""m: smaller differences in a radius are due to the rounding of the display."""
_RADII = (
    ("handle_radius", "Handle radius, rh"),
    ("pulley_radius", "Pulley radius, rp"),
    ("sector_radius", "Sector radius, rs"),
)


class ScaleStep(StepPage):
    """This step is complete once the scale is applied."""

    name = "Zero and scale"
    heading = "Zero and scale: hold the handle at marks"
    intro = (
        "With a ruler, mark 0 in the middle and 20 mm to the left and to the right of it, at the handle. "
        "Hold the handle still at each mark and press Take mark. The middle is measured twice to see whether "
        "the cable slips."
    )
    if_skipped = "The studio uses the board's present zero and computes the scale from the radii."

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_handle()
        self.place = ThousandthsBox("Mark", "mm", -1e3 * REACH, 1e3 * REACH, 1)
        self.take = self.button("Take mark", self.take_mark, primary=True)
        self.restart = self.button("Delete marks", self.forget_marks)
        self.apply = self.job_button(
            "Use this scale", "Sending the scale…", lambda work: work.use_scale(), self._scale_applied,
            ready=self._scale_usable,
        )  # fmt: skip
        self.add_row(QLabel("Position of the mark"), self.place, self.take, self.restart, self.apply)
        self.residuals = self.add_text()
        self.radii = {key: ThousandthsBox(text, "mm", 1.0, 200.0, 2) for key, text in _RADII}
        for box in self.radii.values():
            box.valueChanged.connect(lambda _value: self.enable_buttons())
        self.set_radii = self.button("Use these radii", self.use_radii, ready=self._radii_differ)
        cells = [vbox(QLabel(text), self.radii[key], gap=6) for key, text in _RADII]
        self.column.addWidget(label("Measure the radii of your kit, not the diameters:", "hint"))
        self.column.addLayout(hbox(*cells, vbox(None, self.set_radii), None))
        self.column.addStretch(1)
        self._offer_mark()

    @property
    def _marks(self) -> list[Mark]:
        return self.calibration.marks if self.calibration is not None else []

    def enter(self) -> None:
        if self.calibration is not None:
            self._show_radii()
            if not self._marks:
                self._show_first()

    def reset(self) -> None:
        super().reset()
        self._show_first()
        self._offer_mark()

    # marks

    def take_mark(self) -> None:
        """Record the mark at which the user holds the handle now."""
        place = self.place.si
        self.run_job("Hold the handle still…", lambda work: work.take_mark(place), self._mark_taken)

    def forget_marks(self) -> None:
        """Discard all marks."""
        self.calibration.forget_marks()
        self.reset()
        self.changed.emit()

    def _show_first(self) -> None:
        text = f"Hold the handle at {_mm(PLACES[0])}, then press Take mark."
        self.box.show_text(
            text,
            "Before you take the marks, the picture uses the zero stored in the board, which may be wrong.",
        )

    def _mark_taken(self, mark: Mark) -> None:
        taken = len(self._marks)
        if taken < len(PLACES):
            text = f"The mark at {_mm(mark.place)} is taken. Move the handle to {_mm(PLACES[taken])}."
            self.box.show_text(text, sign=SIGNS[PASS])
        else:
            self._fit()
        self._offer_mark()

    def _fit(self) -> None:
        self.run_job("Computing the scale…", lambda work: work.measure_scale(), self._fitted)

    def _fitted(self, scale: Scale) -> None:
        off = ", ".join(number(1e3 * r, 2) for r in scale.residuals)
        reverse = scale.sense != self.calibration.board.sense
        text = " The sensor counts in the other direction, so its positions are reversed." if reverse else ""
        self.residuals.setText(f"Each mark's distance from the fitted straight line: {off} mm.{text}")
        self.box.show_result(scale.result)
        # Enter must not take a fifth mark by accident
        self.first = self.apply if scale.result.good else None

    def show_refusal(self, text: str, remedy: str = "") -> None:
        """Show a refusal; it is red if all marks are taken but give no scale."""
        if len(self._marks) >= len(PLACES) and self.calibration.scale is None:
            self.box.show_text(text, remedy, SIGNS[FAIL])
        else:
            super().show_refusal(text, remedy)

    def _scale_applied(self, result: CheckResult) -> None:
        self._show_radii()
        self.finish(result)

    def _scale_usable(self) -> bool:
        """Return True if all marks are taken, and agree with each other and the result of step Sensor."""
        found = self.calibration.scale if self.calibration is not None else None
        return len(self._marks) >= len(PLACES) and found is not None and found.result.level != FAIL

    def _offer_mark(self) -> None:
        """Show the instruction for the next mark."""
        taken = [mark.place for mark in self._marks]
        left = PLACES[len(taken) :]
        self.place.show_si(left[0] if left else 0.0)
        if self.handle is not None:
            self.handle.marks = {p: p in taken and p not in left for p in sorted({*PLACES, *taken})}
            self.handle.update()
        if not taken:
            self.residuals.setText("")
        self.first = self.take

    # radii

    def use_radii(self) -> None:
        """Apply the typed radii."""
        radii = {key: box.si for key, box in self.radii.items()}
        self.run_job("Sending the radii…", lambda work: work.change_geometry(**radii), self._radii_applied)

    def _radii_applied(self, _none: object) -> None:
        self._show_radii()
        self.result = None
        self.changed.emit()
        if len(self._marks) >= len(PLACES):
            self._fit()  # this shows at once whether the existing marks agree with the radii
        else:
            text = "The board now uses these radii. Take the marks to check them."
            self.box.show_text(text, sign=SIGNS[PASS])

    def _show_radii(self) -> None:
        for key, box in self.radii.items():
            box.show_si(getattr(self.calibration.board, key))

    def _radii_differ(self) -> bool:
        """Return True if the typed radii differ from the board's."""
        board = self.calibration.board
        return any(abs(box.si - getattr(board, key)) > _SAME for key, box in self.radii.items())


def _mm(place: float) -> str:
    return f"{number(1e3 * place, 0)} mm"

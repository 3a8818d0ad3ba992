"""Step 2: hold the handle at marks; zero and scale follow, and are checked against the radii."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QVBoxLayout

from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.analysis.calibrate.scale import Mark, Scale
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.numbers import Millimetres
from hapkit_studio.gui.wizard.page import Seen, StepPage
from hapkit_studio.gui.wizard.rail import Rail

PLACES = (0.0, -0.020, 0.020, 0.0)
_SAME = 6e-6
"""m by which a radius may differ from what is shown of it."""
_RADII = (
    ("handle_radius", "Axis to handle, rh"),
    ("pulley_radius", "Pulley, rp"),
    ("sector_radius", "Sector, rs"),
)


class ScaleStep(StepPage):
    """Finished once the marks are in force."""

    title = "Zero and scale: hold the handle at marks"
    assumed = "zero where the board has it, and the scale that the radii make"

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self.say(
            "With a ruler, mark 0 in the middle and 20 mm to either side, at the handle. Hold the handle "
            "still at each mark and press Take. The middle comes twice: that shows whether the cable slips."
        )
        self.rail = self.with_hand(Rail())
        self.column.addWidget(self.rail)
        self.place, self.take = (
            Millimetres("Mark", -60.0, 60.0, 1),
            self.button("Take", self.mark, primary=True),
        )
        self.anew, self.apply = (
            self.button("Begin anew", self.forget),
            self.button("Use this scale", self.use),
        )
        self.row(QLabel("Handle at"), self.place, self.take, self.anew, self.apply)
        self.taken = QLabel()
        dress(self.taken, "QLabel { font-size: 14px; }")
        self.column.addWidget(self.taken)
        self.column.addLayout(self._radii())
        self.column.addStretch(1)
        self.column.addWidget(self.box)
        self._offer()

    def _radii(self) -> QVBoxLayout:
        grid, column = QHBoxLayout(), QVBoxLayout()
        self.radii = {key: Millimetres(words, 1.0, 200.0, 2) for key, words in _RADII}
        for key, words in _RADII:
            cell = QGridLayout()
            cell.addWidget(QLabel(words), 0, 0)
            cell.addWidget(self.radii[key], 1, 0)
            grid.addLayout(cell)
        self.set_radii = self.button("Use these radii", self.use_radii)
        for box in self.radii.values():
            box.valueChanged.connect(lambda _value: self._offer_radii())
        grid.addWidget(self.set_radii, 0, Qt.AlignmentFlag.AlignBottom)
        grid.addStretch(1)
        hint = QLabel("Radii of your kit, not diameters:")
        hint.setProperty("role", "hint")
        column.addWidget(hint)
        column.addLayout(grid)
        return column

    def enter(self) -> None:
        if self.desk.subject is not None:
            self._show_radii()
            if not self.subject.marks:
                self._say_first()

    def show_seen(self, seen: Seen) -> None:
        self.rail.show_handle(float(seen.position[-1]))

    # what a person does

    def mark(self) -> None:
        """Take the mark at which the handle is held."""
        place = self.place.metres
        self.do("Hold still…", lambda work: work.take_mark(place), self._marked)

    def forget(self) -> None:
        """Take all marks again."""
        self.subject.forget_marks()
        self.withdraw()
        self.changed.emit()

    def withdraw(self) -> None:
        super().withdraw()
        self._say_first()
        self._offer()

    def _say_first(self) -> None:
        words = f"Hold the handle at {_mm(PLACES[0])}, then press Take."
        self.box.say(words, "Until then the picture has the board's old zero, which may be off.")

    def use(self) -> None:
        """Put the scale in force."""
        self.do("Telling the board…", lambda work: work.use_scale(), self._used)

    def use_radii(self) -> None:
        """Put the radii in force that were typed."""
        handle, pulley, sector = (self.radii[key].metres for key, _ in _RADII)
        self.do("Telling the board…", lambda work: work.set_radii(handle, pulley, sector), self._set)

    # what comes of it

    def _marked(self, mark: Mark) -> None:
        taken = len(self.subject.marks)
        if taken < len(PLACES):
            self.box.say(f"Taken at {_mm(mark.place)}. Go on to {_mm(PLACES[taken])}.", "", "check", "ok")
        else:
            self._fit()
        self._offer()

    def _fit(self) -> None:
        self.do("Fitting…", lambda work: work.measure_scale(), self._fitted)

    def _fitted(self, scale: Scale) -> None:
        off = ", ".join(number(1e3 * r, 2) for r in scale.residuals)
        turned = scale.sense != self.subject.board.sense
        round_ = " The sensor counts the other way: positions are turned round." if turned else ""
        self.taken.setText(f"Each mark's distance from the straight line: {off} mm.{round_}")
        self.box.show_verdict(scale.result)
        self.take.setProperty("first", False)  # an Enter too many must not take a fifth mark
        self.apply.setProperty("first", scale.result.good)

    def _used(self, verdict: CheckResult) -> None:
        self._show_radii()
        self.show_verdict(verdict)

    def _set(self, _none: object) -> None:
        self._show_radii()
        self.verdict = None
        self.changed.emit()
        if len(self.subject.marks) >= len(PLACES):
            self._fit()  # what was taken says at once whether they are right
            return
        self.box.say("The board has these radii now. Take the marks: they check them.", "", "check", "ok")

    def _show_radii(self) -> None:
        for key, box in self.radii.items():
            box.show_metres(getattr(self.subject.board, key))
        self._offer_radii()

    def _offer_radii(self) -> None:
        """Offer radii only where those typed are others than the board's."""
        subject = self.desk.subject
        other = subject is not None and any(
            abs(box.metres - getattr(subject.board, key)) > _SAME for key, box in self.radii.items()
        )
        self.set_radii.setEnabled(other and not self.desk.busy)

    def _offer(self) -> None:
        """Offer the next mark."""
        marks = self.subject.marks if self.desk.subject is not None else []
        taken = [mark.place for mark in marks]
        left = list(PLACES[len(taken) :])
        self.place.show_metres(left[0] if left else 0.0)
        places = sorted({*PLACES, *taken})
        self.rail.show_marks(tuple((p, p in taken and p not in left) for p in places))
        if not marks:
            self.taken.setText("")
        self.take.setProperty("first", True)
        self.apply.setProperty("first", False)
        self.apply.setEnabled(len(taken) >= 2)

    def set_busy(self, busy: bool) -> None:
        super().set_busy(busy)
        if not busy:
            self._offer_radii()
            self.apply.setEnabled(self.desk.subject is not None and len(self.subject.marks) >= 2)


def _mm(place: float) -> str:
    return f"{number(1e3 * place, 0)} mm"

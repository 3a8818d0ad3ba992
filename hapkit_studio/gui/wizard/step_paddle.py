"""Step 5: a gentle sweep by itself tells mass, damping and dry friction, and a dead band of the motor."""

from PySide6.QtWidgets import QLabel, QVBoxLayout

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.calibrate.result import passed, warn
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import number
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.page import Seen, StepPage
from hapkit_studio.gui.wizard.position_plot import PositionPlot
from hapkit_studio.gui.wizard.rail import Rail

_LINES = (
    ("mass", "Mass", 1e3, "g", 1),
    ("viscous", "Damping", 1.0, "N·s/m", 3),
    ("coulomb", "Dry friction", 1.0, "N", 3),
)


class PaddleStep(StepPage):
    """Finished once a sweep told the three numbers."""

    title = "Friction, damping and mass: a gentle sweep"
    assumed = "mass and friction that this kit usually has"
    needs_direction = True

    def __init__(self, desk: Desk):
        super().__init__(desk)
        self.say(
            "Stand the kit upright again. Handle in the middle, hands off, then press Sweep: for "
            "a quarter to half a minute the motor moves the handle by itself, within ±\u00a025\u00a0mm and "
            f"{motions.SWEEP_LIMITS.force:g}\u00a0N. It stops at any doubt."
        )
        self.plot, self.rail = PositionPlot(), self.with_hand(Rail())
        self.column.addWidget(self.plot, 1)
        self.column.addWidget(self.rail)
        self.sweep = self.button("Sweep", self.begin, primary=True, motor=True)
        self.row(self.sweep)
        self.found = {key: QLabel() for key, *_rest in _LINES}
        cells = self.row()
        for key, words, *_rest in _LINES:
            cells.insertLayout(cells.count() - 1, self._cell(words, self.found[key]))
        self.column.addWidget(self.box)
        self.box.say("The motor is off until you press Sweep.")

    def withdraw(self) -> None:
        super().withdraw()
        for value in self.found.values():
            value.setText("–")

    @staticmethod
    def _cell(words: str, value: QLabel) -> QVBoxLayout:
        """Return a number below its name."""
        name = QLabel(words)
        name.setProperty("role", "axis")
        dress(value, "QLabel { font-size: 17px; font-weight: 650; min-width: 190px; }")
        value.setAccessibleName(words)
        value.setText("–")
        cell = QVBoxLayout()
        cell.setSpacing(0)
        cell.addWidget(name)
        cell.addWidget(value)
        return cell

    def enter(self) -> None:
        super().enter()
        self.plot.start = None

    def show_seen(self, seen: Seen) -> None:
        self.plot.show_positions(seen.time, seen.position)
        self.rail.show_handle(float(seen.position[-1]), seen.force)

    def begin(self) -> None:
        """Sweep."""
        self.plot.begin_here()
        self.do("Sweeping. Hands off…", lambda work: work.sweep(), self._swept)

    def _swept(self, swept: SweepResult) -> None:
        part = swept.part
        if not part.estimates:
            self.show_verdict(warn("sweep", part.advice, "Handle in the middle, hands off, sweep again."))
            return
        untold = []
        for key, words, scale, unit, decimals in _LINES:
            e = part[key]
            half = max(scale * e.half, 10.0**-decimals)
            value = f"{number(scale * e.value, decimals)} ± {half:.{decimals}f} {unit}"
            self.found[key].setText(value if e.told else "not told")
            untold += [] if e.told else [f"{words}: {e.advice}"]
        if untold:
            self.show_verdict(warn("untold", " ".join(untold), "Handle in the middle, sweep again."))
            return
        band = swept.board.dead_band
        words = f" The motor begins to turn at duty {band} of 255." if band else ""
        if band and self.subject.strength is not None:
            words += f" With it, the motor constant is {1e3 * self.subject.board.motor_constant:.2f} mN·m."
        self.show_verdict(passed(f"Found, each with its 95 % interval.{words}"))

"""Friction: a gentle sweep tells mass, damping and dry friction, and a dead band of the motor."""

from PySide6.QtWidgets import QLabel, QVBoxLayout

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.calibrate.result import passed, warn
from hapkit_studio.formatting import number
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.wizard.board_dialog import Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.handle_view import HandleView
from hapkit_studio.gui.wizard.recent_plot import PositionPlot
from hapkit_studio.gui.wizard.step_page import StepPage

_LINES = (
    ("mass", "Mass", 1e3, "g", 1),
    ("viscous", "Damping", 1.0, "N·s/m", 3),
    ("coulomb", "Dry friction", 1.0, "N", 3),
)


class FrictionStep(StepPage):
    """Complete once a sweep told the three numbers."""

    name = "Friction"
    heading = "Friction, damping and mass: a gentle sweep"
    if_skipped = "mass and friction that this kit usually has"
    needs_direction = True

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_text(
            "Stand the kit upright again. Handle in the middle, hands off, then press Sweep: for "
            "a quarter to half a minute the motor moves the handle by itself, within ±\u00a025\u00a0mm and "
            f"{motions.SWEEP_LIMITS.force:g}\u00a0N. It stops if anything looks wrong."
        )
        self.plot, self.handle = PositionPlot(), self.with_hand(HandleView())
        self.add_pictures(self.plot, self.handle)
        self.sweep = self.button("Sweep", self.start, primary=True, motor=True)
        self.add_row(self.sweep)
        self.found = {key: QLabel("–") for key, *_rest in _LINES}
        cells = self.add_row()
        cells.setSpacing(24)
        for key, words, *_rest in _LINES:
            cells.insertLayout(cells.count() - 1, _cell(words, self.found[key]))
        self.box.show_text("The motor is off until you press Sweep.")

    def enter(self) -> None:
        super().enter()
        self.plot.begin_here()

    def show_recent(self, recent: Recent) -> None:
        self.plot.show_positions(recent.time, recent.position)
        self.handle.show_handle(float(recent.position[-1]), recent.force)

    def reset(self) -> None:
        super().reset()
        for value in self.found.values():
            value.setText("–")

    def start(self) -> None:
        """Sweep."""
        self.plot.begin_here()
        self.run_job("Sweeping. Hands off…", lambda work: work.sweep(), self._swept)

    def _swept(self, sweep: SweepResult) -> None:
        part = sweep.part
        if not part.estimates:
            self.finish(warn("sweep", part.advice, "Handle in the middle, hands off, sweep again."))
            return
        not_told = []
        for key, words, scale, unit, decimals in _LINES:
            e = part[key]
            half = max(scale * e.half, 10.0**-decimals)
            value = f"{number(scale * e.value, decimals)} ± {half:.{decimals}f} {unit}"
            self.found[key].setText(value if e.told else "not told")
            not_told += [] if e.told else [f"{words}: {e.advice}"]
        if not_told:
            self.finish(warn("not told", " ".join(not_told), "Handle in the middle, sweep again."))
            return
        band = sweep.board.dead_band
        words = f" The motor begins to turn at duty {band} of 255." if band else ""
        if band and self.calibration.strength is not None:
            words += (
                f" With it, the motor constant is {1e3 * self.calibration.board.motor_constant:.2f} mN·m."
            )
        self.finish(passed(f"Found, each with its 95 % interval.{words}"))


def _cell(words: str, value: QLabel) -> QVBoxLayout:
    """Return a number below its name."""
    name = QLabel(words)
    name.setProperty("role", "axis")
    dress(value, "QLabel { font-size: 16px; font-weight: 650; min-width: 176px; }")
    value.setAccessibleName(words)
    cell = QVBoxLayout()
    cell.setSpacing(0)
    cell.addWidget(name)
    cell.addWidget(value)
    return cell

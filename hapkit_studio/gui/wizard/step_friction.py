"""The step Friction: a slow sweep measures mass, damping and dry friction."""

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.calibrate.result import passed, warn
from hapkit_studio.analysis.identify import texts
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.wizard.board_dialog import Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import PositionPlot
from hapkit_studio.gui.wizard.step_page import StepPage

_ESTIMATES = {"mass": "Mass", "viscous": "Damping", "coulomb": "Dry friction"}


class FrictionStep(StepPage):
    """A slow sweep measures mass, damping, dry friction, and the motor's dead band."""

    pushes = needs_direction = True
    name = "Friction"
    heading = "Friction, damping and mass: a gentle sweep"
    intro = (
        "Stand the kit upright again. Put the handle in the middle, take your hands off, then press "
        "Start the sweep. For "
        "15 to 30\u00a0s the motor moves the handle by itself, within ±\u00a025\u00a0mm and "
        f"{motions.SWEEP_LIMITS.force:g}\u00a0N. It stops if anything looks wrong."
    )
    begin = "The motor is off until you press Start the sweep."
    if_skipped = "The studio uses the usual mass and friction of this kit."

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.plot = PositionPlot()
        self.add_handle(self.plot)
        self.sweep = self.button("Start the sweep", self.start, primary=True, motor=True)
        self.add_row(self.sweep)
        self.found = {key: label("–", "found") for key in _ESTIMATES}
        cells = [vbox(label(name, "axis"), self.found[key]) for key, name in _ESTIMATES.items()]
        self.column.addLayout(hbox(*cells, None, gap=24))

    def enter(self) -> None:
        super().enter()
        self.plot.start = None  # limits are relative to the handle's current position

    def show_recent(self, recent: Recent) -> None:
        super().show_recent(recent)
        self.plot.show_positions(recent.time, recent.position)

    def reset(self) -> None:
        super().reset()
        for value in self.found.values():
            value.setText("–")

    def start(self) -> None:
        """Start the sweep."""
        self.plot.start = None  # limits are relative to the handle's current position
        self.run_job("Sweeping. Keep your hands off the handle…", lambda work: work.sweep(), self._swept)

    def _swept(self, sweep: SweepResult) -> None:
        part = sweep.part
        if not part.estimates:
            self.finish(
                warn(
                    "sweep",
                    part.advice,
                    "Put the handle in the middle, take your hands off, and start the sweep again.",
                )
            )
            return
        unknown = []
        for key, name in _ESTIMATES.items():
            e = part[key]
            self.found[key].setText(f"{texts.measured(e)} {texts.unit_of(e)}" if e.determined else "unknown")
            unknown += [] if e.determined else [f"{name}: {e.advice}"]
        if unknown:
            self.finish(
                warn("unknown", " ".join(unknown), "Put the handle in the middle and start the sweep again.")
            )
            return
        band, board = sweep.board.dead_band, self.calibration.board
        more = f" The motor begins to turn at a PWM duty of {band} of 255." if band else ""
        if band and self.calibration.strength is not None:
            more += f" With this dead band, the motor constant is {1e3 * board.motor_constant:.2f} mN·m."
        self.finish(passed(f"The values were found, each with its 95 % interval.{more}"))

"""Connect, Sensor, Direction and Friction: the steps of one page and one or two buttons."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox

from hapkit_studio.analysis.calibrate import motions
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.calibrate.result import PASS, CheckResult, passed, warn
from hapkit_studio.analysis.identify import words
from hapkit_studio.devices import profiles
from hapkit_studio.gui.widgets.parts import across, down, label
from hapkit_studio.gui.wizard.board_dialog import SIGNS, Recent
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import KitDrawing, PositionPlot, SensorPlot
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.protocol.messages import Origin, Sensor


class ConnectStep(StepPage):
    """Plug in USB only, and say which kit it is; skipped, the board's own numbers stay."""

    padding_chosen = Signal(int)
    name = "Connect"
    heading = "Connect, and choose your kit"
    words = (
        "1. Plug in USB, and hold the board's connector with the other hand: a green light comes on.\n"
        "2. Leave the motor's 12 V supply unplugged until the step Direction.\n"
        "3. Choose your kit."
    )
    if_skipped = "the kit that the board is set to"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self._size = 0
        self.column.addWidget(KitDrawing(supply=False), 1)
        self.kits, self.padded = QComboBox(), QCheckBox()
        self.kits.setProperty("tall", True)
        self.kits.setAccessibleName("Kit")
        for kit in profiles.KITS:
            self.kits.addItem(kit.title, kit.key)
        self.first = self.take = self.button("Use this kit", self.use_kit, primary=True)
        self.add_row(self.kits, self.take)
        self.note = self.add_text()
        self.padded.hide()
        self.column.addWidget(self.padded)
        self.padded.toggled.connect(lambda on: self.padding_chosen.emit(self._size if on else 0))
        self.kits.currentIndexChanged.connect(lambda _index: self._show_note())
        self._show_note()

    def enter(self) -> None:
        """Show the kit that the board is set to; offer to fill frames where that shortens the delay."""
        if self.calibration is None or self.result is not None:
            return
        now, found = self.calibration.original, self.calibration.padding
        kit = profiles.numbered(now.profile)
        self.kits.setCurrentIndex(profiles.KITS.index(kit) if kit else 0)
        self._size = found.better if found is not None else 0
        self.padded.setVisible(self._size > 0)
        if found is not None:
            delays = f"{1e3 * found.padded:.1f} ms instead of {1e3 * found.plain:.1f} ms"
            self.padded.setText(f"Fill frames to {self._size} bytes: delay {delays}")
        stored = "has stored settings" if now.origin == Origin.STORED else "has the usual kit's settings"
        self.box.show_text(f"Connected. The board {stored}. Force is zero.", look=SIGNS[PASS])

    def reset(self) -> None:
        super().reset()
        self.enter()

    def use_kit(self) -> None:
        """Take the kit's numbers."""
        kit = profiles.named(self.kits.currentData())
        if kit is profiles.numbered(self.calibration.board.profile):
            self.finish(passed(f"{kit.title}: as the board has it."))
        else:
            found = passed(f"The board is set to this kit: {kit.title}.")
            self.run_job("Sending…", lambda work: work.use_kit(kit), lambda _none: self.finish(found))

    def _show_note(self) -> None:
        self.note.setText(profiles.named(self.kits.currentData()).note)


RECORD_SECONDS = 10.0
_USUAL = (0, 1023)
_SCALES = {Sensor.AS5048A: (0, 16383), Sensor.QUADRATURE: (-100, 100)}


class SensorStep(StepPage):
    """Move the handle from end to end and see what the sensor says."""

    name = "Sensor"
    heading = "Sensor: move the handle from end to end"
    words = (
        "The motor is off. Hold the handle at its left end, press Start, then move it slowly to the "
        "right end and back, twice."
    )
    begin = "Waiting for you at the left end."
    if_skipped = "the sensor works, and repeats as this kit's usually does"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.plot = SensorPlot()
        self.add_handle(self.plot)
        self.first = self.start_button = self.job_button(
            f"Start ({RECORD_SECONDS:g} s)",
            "Move the handle: right end, left end, right end, left end…",
            lambda work: work.check_sensor(work.runner.record(RECORD_SECONDS)),
            self.finish,
            primary=True,
        )
        self.add_row(self.start_button)

    def show_recent(self, recent: Recent) -> None:
        super().show_recent(recent)
        bottom, top = _SCALES.get(Sensor(self.calibration.board.sensor), _USUAL)
        most = int(abs(recent.raw).max())  # an encoder goes as far as the handle does
        self.plot.show_readings(recent.time, recent.raw, min(bottom, -most) if bottom else 0, max(top, most))


class DirectionStep(StepPage):
    """Switch the motor's supply on; small pulses say whether force and position agree."""

    pushes = True
    name = "Direction"
    heading = "Direction: a push to the right goes to the right"
    words = (
        "Now plug in the motor's 12 V supply. Put the handle in the middle, hands off, then press Push: "
        "pulses of 0.1\u00a0N, 0.3\u00a0N at most, 80 ms long. A wrong sign would make a spring run away."
    )
    begin = "The motor is off until you press Push."
    if_skipped = "the direction that the board has; Strength and Friction wait until it is tried"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.add_handle(KitDrawing(supply=True))
        self.push = self.job_button(
            "Push", "Pushing, 0.3 N at most…", lambda work: work.try_direction(), self._judged,
            primary=True, motor=True,
        )  # fmt: skip
        self.find_dead_band = self.job_button(
            "Look for a dead band", "Raising the force, 1.5 N at most…", lambda work: work.find_dead_band(),
            self._judged, motor=True,
        )  # fmt: skip
        self.find_dead_band.setToolTip(
            "Raises the force slowly, 1.5 N at most, until the handle moves half a millimetre"
        )
        self.find_dead_band.hide()
        self.add_row(self.push, self.find_dead_band)

    def _judged(self, result: CheckResult) -> None:
        self.find_dead_band.setVisible(result.key == "no motion")
        self.push.setText("Push again")
        self.finish(result)


_ESTIMATES = {"mass": "Mass", "viscous": "Damping", "coulomb": "Dry friction"}


class FrictionStep(StepPage):
    """A gentle sweep tells mass, damping and dry friction, and a dead band of the motor."""

    pushes = needs_direction = True
    name = "Friction"
    heading = "Friction, damping and mass: a gentle sweep"
    words = (
        "Stand the kit upright again. Handle in the middle, hands off, then press Sweep: for "
        "a quarter to half a minute the motor moves the handle by itself, within ±\u00a025\u00a0mm and "
        f"{motions.SWEEP_LIMITS.force:g}\u00a0N. It stops if anything looks wrong."
    )
    begin = "The motor is off until you press Sweep."
    if_skipped = "mass and friction that this kit usually has"

    def __init__(self, board: BoardThread) -> None:
        super().__init__(board)
        self.plot = PositionPlot()
        self.add_handle(self.plot)
        self.sweep = self.button("Sweep", self.start, primary=True, motor=True)
        self.add_row(self.sweep)
        self.found = {key: label("–", "found") for key in _ESTIMATES}
        cells = [down(label(name, "axis"), self.found[key]) for key, name in _ESTIMATES.items()]
        self.column.addLayout(across(*cells, None, gap=24))

    def enter(self) -> None:
        super().enter()
        self.plot.start = None  # limits are about where the handle is now

    def show_recent(self, recent: Recent) -> None:
        super().show_recent(recent)
        self.plot.show_positions(recent.time, recent.position)

    def reset(self) -> None:
        super().reset()
        for value in self.found.values():
            value.setText("–")

    def start(self) -> None:
        """Sweep."""
        self.plot.start = None  # limits are about where the handle is now
        self.run_job("Sweeping. Hands off…", lambda work: work.sweep(), self._swept)

    def _swept(self, sweep: SweepResult) -> None:
        part = sweep.part
        if not part.estimates:
            self.finish(warn("sweep", part.advice, "Handle in the middle, hands off, sweep again."))
            return
        not_told = []
        for key, name in _ESTIMATES.items():
            e = part[key]
            self.found[key].setText(f"{words.measured(e)} {words.unit_of(e)}" if e.told else "not told")
            not_told += [] if e.told else [f"{name}: {e.advice}"]
        if not_told:
            self.finish(warn("not told", " ".join(not_told), "Handle in the middle, sweep again."))
            return
        band, board = sweep.board.dead_band, self.calibration.board
        more = f" The motor begins to turn at duty {band} of 255." if band else ""
        if band and self.calibration.strength is not None:
            more += f" With it, the motor constant is {1e3 * board.motor_constant:.2f} mN·m."
        self.finish(passed(f"Found, each with its 95 % interval.{more}"))

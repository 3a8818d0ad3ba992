"""A whole calibration: the result of each step, the settings that it changes, and undo."""

import math
from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

from hapkit_studio.analysis.calibrate import motions, motor, paddle, scale, sensor
from hapkit_studio.analysis.calibrate.motor import Direction, Strength
from hapkit_studio.analysis.calibrate.paddle import SweepResult
from hapkit_studio.analysis.calibrate.result import CheckResult, passed
from hapkit_studio.analysis.calibrate.scale import Mark, Scale
from hapkit_studio.analysis.calibrate.sensor import SensorResult
from hapkit_studio.analysis.identify.estimates import Part
from hapkit_studio.devices.board_runner import AbortedError, BoardRunner, LateError, Track
from hapkit_studio.devices.padding import Padding
from hapkit_studio.devices.profiles import Kit, of_settings, quantum_of
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board, Settings

MARK_SECONDS = 0.5
HOOK_SECONDS = 1.0
"""s: time until the handle rests at a spring."""
_TRIES = 3
_REVERSING = {"sense", "direction", "pins", "sensor", "motor_map"}
NO_DIRECTION = "Do the step Direction first: with a wrong direction the motor would push the handle away."


class Calibration:
    """Runs the steps of a calibration on an open board, in the runner's thread.

    ``original`` contains the board's settings at the start. A step that moves the handle or changes settings
    raises DeviceError if the board fails.
    """

    def __init__(self, runner: BoardRunner):
        self.runner = runner
        self.original: Settings = runner.settings
        self.padding: Padding | None = None
        self._stored = False
        self._discard_results()

    def _discard_results(self) -> None:
        self.sensor: SensorResult | None = None
        self.marks: list[Mark] = []
        self.scale: Scale | None = None
        self.direction: Direction | None = None
        self.carried: list[tuple[float, Track]] = []
        self.pushed: Track | None = None
        self.pulled: list[tuple[float, Track]] = []
        self._measured: Callable[[Board], Strength] | None = None
        self.strength: Strength | None = None
        self.sweep_result: SweepResult | None = None
        self._constant = self.runner.settings.motor_constant

    @property
    def board(self) -> Board:
        """Return the board's current settings."""
        return of_settings(self.runner.settings)

    # --- kit
    def use_kit(self, kit: Kit) -> None:
        """Apply a kit's numbers; the board's zero, sense and direction do not change."""
        now = self.board
        keep = {"zero": now.zero, "sense": now.sense, "direction": now.direction, "label": now.label}
        self._change(**asdict(kit.board) | keep)
        self._constant = self.board.motor_constant

    def change_geometry(self, **changes: Any) -> None:
        """Apply measured radii in m, or counts per turn; they determine the scale until marks measure it."""
        self._change(**changes, quantum=quantum_of(replace(self.board, **changes)))

    # --- sensor
    def check_sensor(self, track: Track) -> CheckResult:
        """Evaluate a track in which the handle was moved from end to end, and apply a measured period."""
        self.sensor = sensor.analyse(track)
        made = sensor.changes(self.sensor, self.board)
        if made:
            self.change_geometry(**made)
        return self.sensor.result

    # --- zero and scale
    def take_mark(self, place: float) -> Mark:
        """Record a mark: the handle is held at ``place`` in m; raise ParameterError if the handle moves."""
        self.marks.append(scale.mark_from(self.runner.record(MARK_SECONDS), place))
        self.scale = None
        return self.marks[-1]

    def forget_marks(self) -> None:
        self.marks.clear()
        self.scale = None

    def measure_scale(self) -> Scale:
        """Fit the scale to the marks without changing settings; raise ParameterError for too few marks."""
        inverted = self.sensor.result.key == "inverted" if self.sensor and self.sensor.result.good else None
        self.scale = scale.fit(self.marks, self.board, inverted)
        return self.scale

    def use_scale(self) -> CheckResult:
        """Apply the measured scale: change the quantum, and correct the radius that disagrees with it."""
        found, before = self.scale or self.measure_scale(), self.board
        self._change(**scale.changes(found, before))
        self._recompute_strength()
        return scale.in_force(found, before)

    # --- direction
    def try_direction(self) -> CheckResult:
        """Push both ways. If the motor is reversed, correct its sign and push again."""
        found, wrong = self._keep_direction(lambda: motor.push_both_ways(self.runner))
        if wrong and found.agrees:
            return passed(
                "The motor pushed the wrong way. It is reversed now, so the handle follows the force."
            )
        return found.result

    def find_dead_band(self) -> CheckResult:
        """Increase the force until the handle moves, apply the dead band found, and push again."""
        broke = motor.breakaway(self.runner)
        band = broke.dead_band
        if band:
            self._change(dead_band=band)
        found = self.try_direction()
        if found.key == "no motion":  # friction may be larger than the largest pulse
            known = [broke]  # measure again only after reversing the motor
            slow, wrong = self._keep_direction(
                lambda: motor.judge_pulses((known.pop() if known else motor.breakaway(self.runner)).pulses)
            )
            turn = " The motor pushed the wrong way. It is reversed now." if wrong else ""
            held = f"Dry friction holds the handle up to {broke.force:.2f} N.{turn}"
            found = passed(f"{held} The handle follows the force.") if slow.agrees else slow.result
        more = f" The motor begins to turn at duty {band} of 255; the step Friction measures it."
        return replace(found, text=found.text + more) if band else found

    def _keep_direction(self, push: Callable[[], Direction]) -> tuple[Direction, bool]:
        """Push and return the direction, and whether the motor was reversed.

        If it was, its sign is corrected, and the push is repeated.
        """
        self.direction = push()
        wrong = self.direction.agrees is False
        if wrong:
            self._change(direction=-self.board.direction)
            self.direction = push()
        return self.direction, wrong

    # --- strength
    def carry(self, mass: float) -> float:
        """Carry a mass in kg and return the commanded force in N."""
        self._need_direction()
        track = motions.carry(self.runner, motor.GRAVITY * mass)
        force, _ = motor.carrying_force(track, self.board)
        self.carried = [*(h for h in self.carried if h[0] != mass), (mass, track)]
        return force

    @property
    def weighed(self) -> bool:
        """Return True if a mass was carried, so that the motor constant can be computed."""
        return any(mass > 0.0 for mass, _ in self.carried)

    def use_weights(self) -> Strength:
        """Apply the motor constant measured with masses; raise ParameterError if it is implausible."""
        return self._apply_strength(lambda board: motor.strength_from_weights(self.carried, board))

    def pull(self, stiffness: float) -> float:
        """Pull a spring of ``stiffness`` N/m; return its stiffness in N/m according to the board's settings.

        On a virtual board, this method also attaches the spring before the pull and detaches it afterwards.
        """
        self._need_direction()
        hook = self.runner.board.hook_spring
        hook(stiffness)
        try:
            track = self._pull_in_time(stiffness)
        finally:
            hook(None)
        felt, _ = motor.felt_stiffness(track, self.board)
        self.pulled = [*(p for p in self.pulled if p[0] != stiffness), (stiffness, track)]
        return felt

    def _pull_in_time(self, stiffness: float, tries: int = _TRIES) -> Track:
        """Pull the spring; retry if the computer was late.

        A retry is safe, because nobody holds the handle.
        """
        self.runner.record(HOOK_SECONDS)
        try:
            return motions.pull(self.runner, stiffness)
        except LateError:
            if tries == 1:
                raise
            return self._pull_in_time(stiffness, tries - 1)

    def use_springs(self, known: float = motor.SPRING_UNCERTAINTY) -> Strength:
        """Apply the motor constant computed from pulled springs; raise ParameterError if it is implausible.

        ``known`` is the relative uncertainty of the springs.
        """
        return self._apply_strength(
            lambda board: motor.strength_from_springs(self.pulled, board, known, self._length_uncertainty)
        )

    @property
    def _length_uncertainty(self) -> float:
        """Return the relative uncertainty of the length scale."""
        return self.scale.quantum_half / self.scale.quantum if self.scale else motor.LENGTH_UNCERTAINTY

    def push_on_scale(self, force: float, seconds: float, until: Callable[[], bool]) -> Track:
        """Press on a kitchen scale with a force in N."""
        self._need_direction()
        self.pushed = motions.push(self.runner, force, seconds, until)
        return self.pushed

    def use_reading(self, reading: float) -> Strength:
        """Apply the motor constant from a scale's reading in kg; raise ParameterError for a wrong reading."""
        if self.pushed is None:
            raise ParameterError("Push on the scale first, and read it during the push.")
        pushed = self.pushed
        return self._apply_strength(lambda board: motor.strength_from_scale(reading, pushed, board))

    def _apply_strength(self, measured: Callable[[Board], Strength]) -> Strength:
        """Apply a measured motor constant; store its computation, to repeat it with later settings.

        The interval includes the uncertainty of the dead band.
        """
        board = replace(self.board, motor_constant=self._constant)
        found = measured(board)
        near = [measured(other).ratio for other in paddle.dead_bands_nearby(board)]
        moved = max((abs(ratio - found.ratio) for ratio in near), default=0.0)
        self._measured, self.strength = measured, replace(found, half=math.hypot(found.half, moved))
        self._change(motor_constant=found.motor_constant)
        return self.strength

    def _recompute_strength(self) -> None:
        """Recompute the motor constant from the same measurement after a change of settings."""
        if self._measured is not None:
            self._apply_strength(self._measured)

    # --- mass and friction of the paddle
    def sweep(self, seconds: float = motions.SWEEP_SECONDS) -> SweepResult:
        """Sweep the handle, and apply the measured mass, friction and dead band.

        A new dead band changes the forces, so the sweep is repeated and the motor constant is recomputed.
        """
        self._need_direction()
        found = paddle.sweep(self.runner, seconds)
        if found.board.dead_band != self.board.dead_band:
            self._apply_dead_band(found.board.dead_band)
            found = paddle.sweep(self.runner, seconds, fine=True)
        self._apply_dead_band(found.board.dead_band)
        part = self._widened(paddle.paddle_of(found.track, self.board), found.track)
        self.sweep_result = replace(found, part=part, board=self.board)
        self._change(**paddle.changes(part))
        return self.sweep_result

    def _apply_dead_band(self, band: int) -> None:
        """Apply a dead band, and recompute the motor constant with it."""
        self._change(dead_band=band)
        self._recompute_strength()

    def _widened(self, part: Part, track: Track) -> Part:
        """Widen the intervals of a part's estimates by the uncertainties of dead band, force and length."""
        part = paddle.widened_by_dead_band(part, track, self.board)
        force = self.strength.half / self.strength.ratio if self.strength else 0.0
        length = self.scale.quantum_half / self.scale.quantum if self.scale else 0.0
        return paddle.widened(part, force, length) if part.estimates else part

    @property
    def direction_known(self) -> bool:
        """Return True if the direction was tested, and force and position agree."""
        return self.direction is not None and self.direction.agrees is True

    def _need_direction(self) -> None:
        if self.direction is None:
            self.direction = motor.push_both_ways(self.runner)
        if not self.direction_known:
            raise AbortedError(NO_DIRECTION)

    # --- completion
    def store(self, label: str) -> Settings:
        """Name the kit and store its settings on the board."""
        self._change(label=label)
        self._stored = True
        return self.runner.save()

    def undo(self) -> None:
        """Restore the settings that the board had at the start, also in its EEPROM, and discard all results.

        Raise StudioError if the board does not accept them.
        """
        self._change(**asdict(of_settings(self.original)))
        if self._stored:
            self.runner.save()
            self._stored = False
        self._discard_results()

    def _change(self, **changes: Any) -> None:
        """Apply new settings; send nothing to the board if all settings have these values already.

        A reversal of force or position invalidates the direction test.
        """
        made = {name for name, value in changes.items() if getattr(self.runner.settings, name) != value}
        if made:
            self.runner.configure(**changes)
        if made & _REVERSING:
            self.direction = None

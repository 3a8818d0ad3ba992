"""One calibration from beginning to end: what each step found, what it changed, and the way back."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from hapkit_studio.analysis.calibrate import direction, paddle, scale, sensor, strength, trials
from hapkit_studio.analysis.calibrate.direction import Direction
from hapkit_studio.analysis.calibrate.scale import Mark, Scale
from hapkit_studio.analysis.calibrate.sensor import Sensed
from hapkit_studio.analysis.calibrate.strength import Strength
from hapkit_studio.analysis.calibrate.trials import Breakaway, Swept
from hapkit_studio.analysis.calibrate.verdict import Verdict, passed
from hapkit_studio.analysis.identify.estimates import Part
from hapkit_studio.devices import calibration_moves as moves
from hapkit_studio.devices.calibration import Bench, DoubtError, Track
from hapkit_studio.devices.padding import Padding
from hapkit_studio.devices.profiles import Kit, of_settings, quantum_of
from hapkit_studio.protocol.messages import Board, Settings

MARK_SECONDS = 0.5
_TURNING = {"sense", "direction", "pins", "sensor", "motor_map"}
NO_DIRECTION = "Do step 3 first: with a wrong direction the motor would push the handle away."


class Calibration:
    """Works on an open bench, in the bench's thread. ``before`` is what the board held at the start."""

    def __init__(self, bench: Bench):
        self.bench = bench
        self.before: Settings = bench.now
        self.padding: Padding | None = None
        self._stored = False
        self._forget()

    def _forget(self) -> None:
        """Forget whatever was found."""
        self.sensed: Sensed | None = None
        self.marks: list[Mark] = []
        self.scale: Scale | None = None
        self.direction: Direction | None = None
        self.held: list[tuple[float, Track]] = []
        self.strength: Strength | None = None
        self.swept: Swept | None = None
        self._constant = self.bench.now.motor_constant

    @property
    def board(self) -> Board:
        """Return the settings in force."""
        return of_settings(self.bench.now)

    # 0: the kit
    def choose(self, kit: Kit) -> None:
        """Take a kit's numbers instead of what the board has; its zero, sense and direction stay."""
        now = self.board
        keep = {"zero": now.zero, "sense": now.sense, "direction": now.direction, "label": now.label}
        self._change(**{f.name: getattr(kit.board, f.name) for f in Board.layout()} | keep)
        self._constant = self.board.motor_constant

    def set_radii(self, handle: float, pulley: float, sector: float) -> None:
        """Take radii in m as measured, and the scale that they make until marks say better."""
        radii = {"handle_radius": handle, "pulley_radius": pulley, "sector_radius": sector}
        board = replace(self.board, **radii)  # type: ignore[arg-type]
        self._change(**radii, quantum=quantum_of(board))

    # 1: the sensor
    def look_at_sensor(self, track: Track) -> Verdict:
        """Judge a track of the handle moved from end to end; a measured period is put in force."""
        self.sensed = sensor.sense(track)
        made = sensor.changes(self.sensed, self.board)
        if made:
            board = replace(self.board, **made)  # type: ignore[arg-type]
            self._change(**made, quantum=quantum_of(board))
        return self.sensed.verdict

    # 2: zero and scale
    def mark(self, place: float) -> Mark:
        """Take the place in m at which the handle is held now; raise ParameterError where it is not still."""
        self.marks.append(scale.take(self.bench.watch(MARK_SECONDS), place))
        self.scale = None
        return self.marks[-1]

    def forget_marks(self) -> None:
        """Take all marks again."""
        self.marks.clear()
        self.scale = None

    def measure_scale(self) -> Scale:
        """Fit the marks, change nothing yet; raise ParameterError."""
        self.scale = scale.fit(self.marks, self.board)
        return self.scale

    def use_scale(self) -> Verdict:
        """Put the scale in force: positions, and the radius that explains them; raise ParameterError."""
        found, before = self.scale or self.measure_scale(), self.board
        self._change(**scale.changes(found, before))
        if self.held:
            self.use_weights()
        return scale.in_force(found, before)

    # 3: direction
    def push(self) -> Verdict:
        """Push both ways; turn the motor round where it went wrong, and push again; raise DeviceError."""
        self.direction = trials.push_both_ways(self.bench)
        if self.direction.agrees is not False:
            return self.direction.verdict
        self._change(direction=-self.board.direction)
        self.direction = trials.push_both_ways(self.bench)
        if self.direction.agrees:
            return passed("The motor pushed the wrong way. It is turned round; force and position agree now.")
        return self.direction.verdict

    def look_for_dead_band(self) -> Verdict:
        """Raise the force until the handle moves, start above that, push again; raise DeviceError."""
        broke = trials.breakaway(self.bench)
        band = trials.first_dead_band(broke)
        if band:
            self._change(dead_band=band)
        found = self.push()
        if found.key == "no motion":
            found = self._judge_breakaway(broke)
        words = f" The motor begins to turn at duty {band} of 255; step 5 measures it." if band else ""
        return replace(found, words=found.words + words)

    def _judge_breakaway(self, broke: Breakaway) -> Verdict:
        """Judge by what the slowly raised force did: friction may be more than a pulse is allowed to be."""
        self.direction = direction.judge(list(broke.pulses))
        turned = self.direction.agrees is False
        if turned:
            self._change(direction=-self.board.direction)
            self.direction = direction.judge(list(trials.breakaway(self.bench).pulses))
        if not self.direction.agrees:
            return self.direction.verdict
        turn = " The motor pushed the wrong way. It is turned round." if turned else ""
        return passed(
            f"Dry friction holds the handle up to {broke.force:.2f} N.{turn} Force and position agree."
        )

    # 4: strength
    def carry(self, mass: float) -> float:
        """Carry a mass in kg and return the force in N that it took, by the settings; raise StudioError."""
        self._need_direction()
        track = moves.hold(self.bench, strength.GRAVITY * mass)
        force, _ = strength.carried(track, self.board)
        self.held = [*(h for h in self.held if h[0] != mass), (mass, track)]
        return force

    def use_weights(self) -> Strength:
        """Put the motor constant from the masses carried in force; raise ParameterError."""
        board = self._as_held()
        found = strength.of_weights(self.held, board)
        near = [strength.of_weights(self.held, other).ratio for other in paddle.bands_near(board)]
        moved = max((abs(ratio - found.ratio) for ratio in near), default=0.0)
        return self._use(replace(found, half=math.hypot(found.half, moved)))

    def press(self, force: float, seconds: float, until: Callable[[], bool]) -> Track:
        """Press on a kitchen scale with a force in N; raise DeviceError."""
        self._need_direction()
        return moves.push(self.bench, force, seconds, until)

    def use_reading(self, reading: float, track: Track) -> Strength:
        """Put the motor constant from a scale's reading in kg in force; raise ParameterError."""
        return self._use(strength.of_scale(reading, track, self._as_held()))

    def _as_held(self) -> Board:
        """Return the settings with the motor constant that this calibration began with."""
        return replace(self.board, motor_constant=self._constant)

    def _use(self, found: Strength) -> Strength:
        self.strength = found
        self._change(motor_constant=found.motor_constant)
        return found

    # 5: the paddle
    def sweep(self, seconds: float = moves.SWEEP_SECONDS) -> Swept:
        """Sweep, put mass, friction and a dead band in force; raise DeviceError.

        A dead band changes what forces were: the sweep is made again with it, and weights count by it.
        """
        self._need_direction()
        found = trials.sweep(self.bench, seconds)
        if found.board.dead_band != self.board.dead_band:
            self._use_dead_band(found.board.dead_band)
            found = trials.sweep(self.bench, seconds, fine=True)
        self._use_dead_band(found.board.dead_band)
        part = self._widened(paddle.paddle_of(found.track, self.board), found.track)
        self.swept = replace(found, part=part, board=self.board)
        self._change(**paddle.changes(part))
        return self.swept

    def _use_dead_band(self, band: int) -> None:
        """Put a dead band in force, and the motor constant that the weights make by it."""
        self._change(dead_band=band)
        if self.held:
            self.use_weights()

    def _widened(self, part: Part, track: Track) -> Part:
        """Return a part with what the dead band and the scales, as far as measured, may be off."""
        part = paddle.unsure_of_band(part, track, self.board)
        force = self.strength.half / self.strength.ratio if self.strength else 0.0
        length = self.scale.quantum_half / self.scale.quantum if self.scale else 0.0
        return paddle.widened(part, force, length) if part.estimates else part

    def _need_direction(self) -> None:
        if self.direction is None:
            self.direction = trials.push_both_ways(self.bench)
        if not self.direction.agrees:
            raise DoubtError(NO_DIRECTION)

    # the end
    def store(self, label: str) -> Settings:
        """Name the kit and keep its settings on the board; raise StudioError."""
        self._change(label=label)
        self._stored = True
        return self.bench.save()

    def undo(self) -> None:
        """Put back what the board held at the start, where it is stored too; forget what was found.

        Raise StudioError.
        """
        self._change(**{f.name: getattr(self.before, f.name) for f in Board.layout()})
        if self._stored:
            self.bench.save()
            self._stored = False
        self._forget()

    def _change(self, **changes: Any) -> None:
        """Put changes in force; nothing is sent where they are none.

        What turns force or position round makes a direction that was tried worth nothing.
        """
        made = {name for name, value in changes.items() if getattr(self.bench.now, name) != value}
        if made:
            self.bench.configure(**changes)
        if made & _TURNING:
            self.direction = None

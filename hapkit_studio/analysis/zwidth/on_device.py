"""Z-width on a running device: a hand presses walls of rising stiffness until a wall keeps oscillating.

A simulated hand hits the wall; a person is asked to press. Slow motion of the hand is filtered out, and the
remaining oscillation must decay. No wall stiffer than the first failed one is tried. Force, speed and travel
are limited. An E-stop, a fault or cancelling ends the measurement at once, and the old settings are restored.
In a band around the limit, walls pass and fail alternately. To measure this band, at least four further walls
are tried for each damping.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.analysis.zwidth import DEVICE_DAMPING, result
from hapkit_studio.analysis.zwidth.guarded_device import (
    GuardedDevice,
    Interrupted,
    TrialLimits,
    Unsafe,
    force_withheld,
    pressing_force,
)
from hapkit_studio.analysis.zwidth.simulation import Arrived
from hapkit_studio.dynamics.hand import GRIPS, Grip
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.formatting import compact
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine

# s: longest period of an oscillation that counts; a hand's tremor (8 to 12 Hz) is slower
_SLOW_SECONDS = 0.05
_WINDOW_SECONDS = 0.25
_MOST_WINDOWS = 16
_QUIET_WINDOWS = 2
_MOST_REPEATS = 5
# ratio of the amplitudes of consecutive windows: below _DYING the motion decays, above _GROWING it grows
_DYING, _GROWING = 0.9, 1.1
_STEP_SECONDS = 0.01
_AWAY = 0.005
_AWAY_SECONDS = 1.5
_SLOW = 0.03
_PATIENCE_SECONDS = 60.0
_LEAST_SHARE, _MOST_SHARE = 0.3, 0.85
ASK = "Press gently into the wall and hold"
USUAL_GRIP = "medium"


def measure(
    engine: Engine,
    damping: Sequence[float] = DEVICE_DAMPING,
    limits: TrialLimits | None = None,
    *,
    person: bool | None = None,
    progress: Progress = no_progress,
    arrived: Arrived = lambda damping, point: None,
    instruct: Callable[[str], object] = lambda text: None,
) -> result.ZWidth:
    """Return the Z-width of a running engine's device with its current loop.

    ``person`` is True if a person presses; if it is None, a person presses if the device has no simulated
    hand. ``instruct`` receives texts for the user. Raise ParameterError for an invalid argument, Interrupted
    if the measurement ends early, and any exception of ``progress``. The settings are restored in any case.
    """
    limits, levels = limits or TrialLimits(), result.levels_of(damping)
    if person is None:
        person = not engine.device.simulated_hand
    steps = _TrialProgress(limits, len(levels), progress)
    points: list[result.Point] = []
    with GuardedDevice(engine, limits, instruct, steps.poll) as guarded:
        hand: SimulatedHand | Person = Person(guarded) if person else SimulatedHand(guarded)
        for level in levels:
            points.append(_stiffest_at(guarded, hand, level, steps))
            steps.next_level()
            arrived(level, points[-1])
        setting = setting_of(engine, hand.grip)
    force, share = limits.max_force, limits.precision
    found = (
        *result.loop_conditions(setting, friction=engine.modelled is not None),
        result.Condition("measured_rate_Hz", guarded.rate, "Measured rate", f"{guarded.rate:,.0f} Hz"),
        result.Condition("max_force", force, "Force limit", f"{force:g} N"),
        result.Condition("precision", share, "Precision of the stiffness", f"{100.0 * share:g} %"),
        *hand.conditions,
    )
    return result.ZWidth.of(engine.device.title, levels, points, setting, found)


def setting_of(engine: Engine, grip: str) -> LoopSettings:
    """Return the device and its loop, with the measured delay."""
    device = engine.modelled or engine.device
    coulomb = engine.modelled.coulomb_force if engine.modelled else 0.0
    loop, delay = engine.loop, engine.health().delay or 0.0
    return replace(
        loop, delay=delay, hand=grip, mass=device.mass, viscous=device.viscous, coulomb=coulomb,
        quantum=device.quantum,
    )  # fmt: skip


class SimulatedHand:
    """A simulated hand that moves away from the wall, hits it at a speed, and presses with a force."""

    def __init__(self, guarded: GuardedDevice):
        self._guarded = guarded
        grip = guarded.engine.grip
        self.grip = grip if GRIPS.get(grip) is not None else USUAL_GRIP
        guarded.engine.set_loop(hand=self.grip)

    @property
    def conditions(self) -> tuple[result.Condition, ...]:
        limits = self._guarded.limits
        return (
            result.Condition("hand", self.grip, "Hand", f"simulated, {self.grip}"),
            result.Condition("speed", limits.hit, "Impact speed", f"{limits.hit:g} m/s", "v₀"),
            result.Condition("push", limits.push, "Push", f"{limits.push:g} N"),
        )

    def begin(self) -> None:
        """Move away from the wall and wait until the handle has followed."""
        away = self._guarded.surface - self._guarded.into * _AWAY
        self._guarded.engine.move_hand(away)
        end = time.monotonic() + _AWAY_SECONDS
        while time.monotonic() < end:
            found = self._guarded.collect(2.0 * _STEP_SECONDS, judged=False)
            near = np.abs(found[:, rows.POSITION] - away) < 0.5 * _AWAY
            if near.all() and np.ptp(found[:, rows.POSITION]) < _SLOW * 2.0 * _STEP_SECONDS:
                return

    def press(self, stiffness: float) -> None:
        """Move the hand at its speed to the position at which wall and grip balance at the pushing force."""
        grip = GRIPS[self.grip]
        assert isinstance(grip, Grip)
        guarded, limits = self._guarded, self._guarded.limits
        goal = limits.push / grip.stiffness + limits.push / stiffness
        start, depth = guarded.collect(_STEP_SECONDS)[-1, rows.BOARD_TIME], -_AWAY
        while depth < goal:
            now = guarded.collect(_STEP_SECONDS)[-1, rows.BOARD_TIME]
            depth = min(limits.hit * (now - start) - _AWAY, goal)
            guarded.engine.move_hand(guarded.surface + guarded.into * depth)

    def presses(self, found: np.ndarray) -> bool:
        """Return True if the hand presses; in the window, a user may drag the handle away."""
        least = _LEAST_SHARE * self._guarded.limits.push
        return not force_withheld(found) and pressing_force(found, self._guarded.into) >= least


class Person:
    """A person who is asked to press, and whose motion is monitored."""

    grip = "released"

    def __init__(self, guarded: GuardedDevice):
        self._guarded = guarded
        limits = guarded.limits
        self._least, self._most = _LEAST_SHARE * limits.push, _MOST_SHARE * limits.max_force

    @property
    def conditions(self) -> tuple[result.Condition, ...]:
        text = f"{compact(self._least, 2)} to {compact(self._most, 2)} N"
        return (
            result.Condition("hand", result.PERSON, "Hand", "a person's hand"),
            result.Condition("push", text, "Push", text),
        )

    def begin(self) -> None:
        """Wait until a person presses; raise Interrupted after a time-out."""
        end = time.monotonic() + _PATIENCE_SECONDS
        last_text = ""
        while not self.presses(found := self._guarded.collect(0.2, judged=False)):
            force, text = pressing_force(found, self._guarded.into), f"{ASK}."
            if force > self._most:
                push = self._guarded.limits.push
                text = f"Press more gently: {force:.1f} N now, {push:g} N is enough."
            if text != last_text:
                self._guarded.instruct(text)
            last_text = text
            if time.monotonic() > end:
                raise Interrupted(
                    f"You did not press within {_PATIENCE_SECONDS:.0f} s. The measurement ended."
                )
        self._guarded.instruct("Hold the handle still")

    def press(self, stiffness: float) -> None:
        """Do nothing, because the person presses."""

    def presses(self, found: np.ndarray) -> bool:
        force = pressing_force(found, self._guarded.into)
        return not force_withheld(found) and self._least <= force <= self._most


class _TrialProgress:
    """Count the trials for progress; the number of trials per level is an estimate."""

    def __init__(self, limits: TrialLimits, levels: int, progress: Progress):
        raised = math.log(limits.highest / limits.softest) / math.log(limits.raised)
        self.halvings = max(1, math.ceil(math.log2((limits.raised - 1.0) / limits.precision)))
        self._each = math.ceil(raised) + 1 + self.halvings + 2 * result.band_trials(limits.precision)
        self._of, self._progress = levels * self._each, progress
        self._level = self._done = 0

    def poll(self) -> None:
        """Report progress; the callback may raise to abort."""
        self._progress(self._done, self._of)

    def next_trial(self) -> None:
        self._done = min(self._done + 1, (self._level + 1) * self._each - 1)

    def next_level(self) -> None:
        """Count a level as done, and report progress."""
        self._level += 1
        self._done = self._level * self._each
        self.poll()


def _stiffest_at(
    guarded: GuardedDevice, hand: SimulatedHand | Person, damping: float, steps: _TrialProgress
) -> result.Point:
    """Return the stiffest wall that passed at one damping, and the band around it."""
    limits, stiffest_resting, stiffest_tried = guarded.limits, 0.0, 0.0

    def tried(stiffness: float) -> result.TrialOutcome:
        """Try one wall, then apply the stiffest one that passed."""
        nonlocal stiffest_resting, stiffest_tried
        stiffest_tried = max(stiffest_tried, stiffness)
        steps.next_trial()
        hand.begin()
        guarded.clamped = False
        guarded.wall(stiffness, damping)
        try:
            hand.press(stiffness)
            why = _watched(guarded, hand, stiffness)
        except Unsafe as unsafe:
            why = str(unsafe)
        stiffest_resting = stiffest_resting if why else stiffness
        if stiffest_resting:
            guarded.wall(stiffest_resting, damping)
        else:
            guarded.calm()
        return result.TrialOutcome(why, guarded.clamped)

    guarded.calm()
    point = result.stiffest(tried, limits.softest, limits.raised, limits.highest, steps.halvings)
    return result.with_band(tried, point, limits.precision, limits.softest, stiffest_tried)


def _watched(guarded: GuardedDevice, hand: SimulatedHand | Person, stiffness: float) -> str:
    """Watch until the oscillation has decayed or persists; return why the wall failed, "" if it passed."""
    limit = guarded.limits.counts * guarded.quantum
    calm, before = 0, math.inf
    for window in range(_MOST_WINDOWS):
        found = _window(guarded, hand, stiffness)
        now = ripple(found[:, rows.POSITION], guarded.engine.loop.rate)
        calm = calm + 1 if now <= limit else 0
        if calm == _QUIET_WINDOWS:
            return ""
        if window > 1 and now > limit and now > _DYING * before:
            return result.GROWS if now > _GROWING * before else result.BUZZES
        before = now
    return result.BUZZES


def _window(guarded: GuardedDevice, hand: SimulatedHand | Person, stiffness: float) -> np.ndarray:
    """Return the next rows during which the hand presses; collect again if it does not press."""
    for _ in range(_MOST_REPEATS):
        found = guarded.collect(_WINDOW_SECONDS + _SLOW_SECONDS)
        if hand.presses(found):
            return found
        hand.begin()
        hand.press(stiffness)
    raise Interrupted(
        f"You stopped pressing against the wall {_MOST_REPEATS} times, so the measurement ended."
    )


def ripple(position: np.ndarray, rate: float) -> float:
    """Return the peak-to-peak motion in m after subtracting a 50 ms moving average; rate in Hz."""
    count = 2 * round(0.5 * _SLOW_SECONDS * rate) + 1
    if len(position) < 2 * count:
        return float(np.ptp(position))
    slow = np.convolve(position, np.full(count, 1.0 / count), "valid")
    return float(np.ptp(position[count // 2 : len(position) - count // 2] - slow))

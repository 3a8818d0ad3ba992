"""Z-width on a running device: a hand presses into walls of rising stiffness until one keeps buzzing.

What a hand does slowly is taken out of the motion, and what is left must die out. Nothing stiffer than the
first wall that fails is tried; force, speed and travel are limited; E-stop, fault or cancelling end it at
once, and the old settings come back.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.sweeps import Progress, quiet
from hapkit_studio.analysis.zwidth import Arrived, nobody
from hapkit_studio.analysis.zwidth_bench import Bench, Care, Interrupted, Unsafe
from hapkit_studio.analysis.zwidth_hands import Person, Presser, SimulatedHand
from hapkit_studio.analysis.zwidth_limits import DEVICE_DAMPING
from hapkit_studio.analysis.zwidth_protocol import levels_of, linear_curve, linear_limits, loop_conditions
from hapkit_studio.analysis.zwidth_result import BUZZES, GROWS, Condition, ZWidth
from hapkit_studio.analysis.zwidth_search import Point, Verdict, stiffest
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine

# A buzz is faster than this; a hand's own tremor (8 to 12 Hz) is slower.
_SLOW_SECONDS = 0.05
_WINDOW_SECONDS = 0.25
_MOST_WINDOWS = 16
_QUIET_WINDOWS = 2
_MOST_REPEATS = 5
# From one window to the next: less than this share goes on dying out, more than that one grows.
_DYING, _GROWING = 0.9, 1.1


def silent(words: str) -> None:
    """Tell nobody."""


def measure(
    engine: Engine,
    damping: Sequence[float] = DEVICE_DAMPING,
    care: Care | None = None,
    *,
    person: bool | None = None,
    progress: Progress = quiet,
    arrived: Arrived = nobody,
    say: Callable[[str], None] = silent,
) -> ZWidth:
    """Return the Z-width of a running engine's device, its loop as it is set.

    person: a person presses; None: where the device has no simulated hand. say is told what to do next.
    Raise ParameterError, Interrupted, and what progress raises; the old settings are back then too.
    """
    care, levels = care or Care(), levels_of(damping)
    if person is None:
        person = not (engine.device.simulated or getattr(engine.device, "hand", False))
    steps = _Steps(care, len(levels), progress)
    points: list[Point] = []
    with Bench(engine, care, say, steps.look) as bench:
        hand: Presser = Person(bench) if person else SimulatedHand(bench)
        for level in levels:
            points.append(_Trials(bench, hand, level, steps).point())
            steps.next_level()
            arrived(level, points[-1])
        setting = setting_of(engine, hand.grip)
    linear, curve = linear_limits(setting, levels), linear_curve(setting, levels[-1])
    found = _conditions(bench, setting) + hand.conditions
    return ZWidth.of(engine.device.title, levels, points, linear, curve, found)


def setting_of(engine: Engine, grip: str) -> Setting:
    """Return the device and its loop as they are, the delay as measured."""
    device = engine.modelled or engine.device
    coulomb = engine.modelled.coulomb_force if engine.modelled else 0.0
    loop, delay = engine.loop, engine.health().delay
    handle = device.mass, device.viscous, coulomb, device.quantum
    return Setting(*handle, loop.rate, delay, loop.estimator, grip, loop.controller)


def _conditions(bench: Bench, setting: Setting) -> tuple[Condition, ...]:
    """Return device and loop as they are, how fast the loop really went, and the care taken."""
    rate, care = bench.rate, bench.care
    return (
        *loop_conditions(setting, friction=bench.engine.modelled is not None),
        Condition("measured_rate_Hz", rate, "Rate measured", f"{rate:.0f} Hz"),
        Condition("max_force", care.max_force, "Force limit", f"{care.max_force:g} N"),
        Condition("precision", care.precision, "Stiffness to", f"{100.0 * care.precision:g} %"),
    )


class _Steps:
    """Counts trials for progress; how many a level takes is known only roughly."""

    def __init__(self, care: Care, levels: int, progress: Progress):
        raised = math.log(care.highest / care.softest) / math.log(care.raised)
        self.halvings = max(1, math.ceil(math.log2((care.raised - 1.0) / care.precision)))
        self._each = math.ceil(raised) + 1 + self.halvings
        self._of, self._progress = levels * self._each, progress
        self._level = self._done = 0

    def look(self) -> None:
        """Tell how far it is; whoever listens may raise to end it all."""
        self._progress(self._done, self._of)

    def next_trial(self) -> None:
        """Count one trial."""
        self._done = min(self._done + 1, (self._level + 1) * self._each - 1)

    def next_level(self) -> None:
        """Count a level as done, and tell."""
        self._level += 1
        self._done = self._level * self._each
        self.look()


class _Trials:
    """The trials at one damping."""

    def __init__(self, bench: Bench, hand: Presser, damping: float, steps: _Steps):
        self._bench, self._hand, self._damping, self._steps = bench, hand, damping, steps
        self._held = 0.0

    def point(self) -> Point:
        """Return the stiffest wall that held."""
        care = self._bench.care
        self._bench.calm()
        return stiffest(self._held_at, care.softest, care.raised, care.highest, self._steps.halvings)

    def _held_at(self, stiffness: float) -> Verdict:
        """Try one wall; after it the last one that held is in force."""
        self._steps.next_trial()
        self._hand.begin()
        self._bench.clamped = False
        self._bench.wall(stiffness, self._damping)
        try:
            self._hand.press(stiffness)
            why = self._watched(stiffness)
        except Unsafe as unsafe:
            why = unsafe.why
        if not why:
            self._held = stiffness
        self._soften()
        return Verdict(why, self._bench.clamped)

    def _soften(self) -> None:
        if self._held:
            self._bench.wall(self._held, self._damping)
        else:
            self._bench.calm()

    def _watched(self, stiffness: float) -> str:
        """Watch until the motion has died out, or does not any more; return why the wall fails."""
        limit = self._bench.care.counts * self._bench.quantum
        calm, before = 0, math.inf
        for window in range(_MOST_WINDOWS):
            found = self._window(stiffness)
            now = ripple(found[:, rows.POSITION], self._bench.engine.loop.rate)
            calm = calm + 1 if now <= limit else 0
            if calm == _QUIET_WINDOWS:
                return ""
            if window > 1 and now > limit and now > _DYING * before:
                return GROWS if now > _GROWING * before else BUZZES
            before = now
        return BUZZES

    def _window(self, stiffness: float) -> np.ndarray:
        """Return the next rows under a hand that presses; where it does not, it begins anew."""
        for _ in range(_MOST_REPEATS):
            found = self._bench.collect(_WINDOW_SECONDS + _SLOW_SECONDS)
            if self._hand.presses(found):
                return found
            self._hand.begin()
            self._hand.press(stiffness)
        raise Interrupted(f"The wall was let go {_MOST_REPEATS} times. The measurement ended.")


def ripple(position: np.ndarray, rate: float) -> float:
    """Return the peak-to-peak motion in m beside the mean over 50 ms, of positions sampled at a rate."""
    count = 2 * round(0.5 * _SLOW_SECONDS * rate) + 1
    if len(position) < 2 * count:
        return float(np.ptp(position))
    slow = np.convolve(position, np.full(count, 1.0 / count), "valid")
    return float(np.ptp(position[count // 2 : len(position) - count // 2] - slow))

"""What a Z-width is measured by: the wall hits in numbers, and the conditions it depends on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.checks import row
from hapkit_studio.analysis.plane import exact_boundary
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.zwidth_limits import DAMPING, MAX_FORCE, PUSH, SPEED
from hapkit_studio.analysis.zwidth_result import Condition, estimator_words
from hapkit_studio.errors import ParameterError

_CURVE = 81
# A row takes 256 bytes; and fewer samples than that show no motion.
MOST_SAMPLES = 400_000
FEWEST_IN_TAIL = 5


@dataclass(frozen=True)
class Protocol:
    """How a wall is tried: hit at a speed in m/s, pushed by N, at phases of the sample, for seconds.

    It fails where the handle goes beyond travel m, or moves by more than so many counts in the tail s.
    Stiffness begins at the softest N/m. max_force: the motor's limit in N, inf for none. Raise
    ParameterError.
    """

    speed: float = SPEED.default
    push: float = PUSH.default
    phases: tuple[float, ...] = (1 / 6, 3 / 6, 5 / 6)
    seconds: float = 4.0
    tail: float = 0.5
    travel: float = 0.2
    counts: float = 2.0
    softest: float = 200.0
    raised: float = 1.3
    halvings: int = 14
    max_force: float = math.inf

    def __post_init__(self) -> None:
        SPEED.check(self.speed)
        PUSH.check(self.push)
        if self.max_force == math.inf:
            return
        MAX_FORCE.check(self.max_force)
        if self.push >= self.max_force:
            raise ParameterError(
                f"A push of {self.push:g} N needs a force limit above it, not {self.max_force:g} N."
            )


def samples_of(setting: Setting, protocol: Protocol) -> int:
    """Return how many samples a hit takes; raise ParameterError where they are too few or too many."""
    seconds, rate = protocol.seconds, setting.rate
    count = round(seconds * rate)
    if count > MOST_SAMPLES or round(protocol.tail * rate) < FEWEST_IN_TAIL:
        least, most = FEWEST_IN_TAIL / protocol.tail, MOST_SAMPLES / seconds
        raise ParameterError(
            f"A hit of {seconds:g} s is simulated at {least:g} to {most:g} Hz, not at {rate:g} Hz."
        )
    return count


def levels_of(damping: Sequence[float]) -> list[float]:
    """Return checked virtual dampings in N·s/m, each once, rising; raise ParameterError."""
    levels = sorted(set(row(damping, DAMPING).tolist()))
    if not levels:
        raise ParameterError("A Z-width takes one damping or more, e.g. 0,1,2,5.")
    return levels


def linear_limits(setting: Setting, damping: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the linear loop's limit (n,) in N/m, nan where the estimator is not linear."""
    if not setting.linear:
        return np.full(len(damping), math.nan)
    return exact_boundary(setting, np.asarray(damping, dtype=float))


def linear_curve(setting: Setting, highest: float) -> np.ndarray:
    """Return the linear limit (2, m): damping up to the highest, and stiffness; finely, for a chart."""
    damping = np.linspace(0.0, highest or 1.0, _CURVE)
    return np.array([damping, linear_limits(setting, damping)])


def loop_conditions(setting: Setting, friction: bool = True) -> tuple[Condition, ...]:
    """Return everything about device and loop that a Z-width depends on; friction: whether it is known."""
    known, rubs = (setting.coulomb, f"{setting.coulomb:g} N") if friction else (math.nan, "not known")
    given, estimator = estimator_words(setting.estimator)
    controller = "on" if setting.controller else "off"
    return (
        Condition("rate_Hz", setting.rate, "Period", f"{1e3 * setting.period:g} ms", "T"),
        Condition("delay", setting.delay, "Delay", f"{1e3 * setting.delay:.3g} ms"),
        Condition("mass", setting.mass, "Mass", f"{1e3 * setting.mass:g} g", "m"),
        Condition("viscous", setting.viscous, "Own damping", f"{setting.viscous:g} N·s/m", "b"),
        Condition("coulomb", known, "Friction", rubs),
        Condition("quantum", setting.quantum, "Sensor step", f"{1e6 * setting.quantum:.3g} µm"),
        Condition("estimator", given, "Velocity", estimator),
        Condition("controller", controller, "Passivity controller", controller, "controller"),
    )


def conditions(setting: Setting, protocol: Protocol) -> tuple[Condition, ...]:
    """Return everything that a simulated Z-width depends on."""
    limit = protocol.max_force
    return (
        *loop_conditions(setting),
        Condition("hand", setting.hand, "Hand", setting.hand),
        Condition("speed", protocol.speed, "Hit at", f"{protocol.speed:g} m/s", "v₀"),
        Condition("push", protocol.push, "Push", f"{protocol.push:g} N"),
        Condition("max_force", limit, "Force limit", f"{limit:g} N" if limit < math.inf else "none"),
    )

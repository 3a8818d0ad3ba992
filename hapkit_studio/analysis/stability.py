"""The stiffest virtual spring that stays stable: exact from the sampled loop, and measured by simulation."""

import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.exact import Loop, checked_loop, stiffness_limits
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec, design, parse
from hapkit_studio.dynamics.filter_design import USUAL_QUANTUM
from hapkit_studio.dynamics.hand import Grip, Hand
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

_RELEASED_AT = 1e-6
_RELEASED_FAR = 1e-3
_SMALL = 5.0 * USUAL_QUANTUM
_DYING = 0.9
_LOST_AT = 1.0
_SECONDS = 12.0
_TURNS = 80.0
_SAMPLES = 12_000
_MOST_SAMPLES = 5_000_000
_SOFTEST, _STIFFEST = 1e-3, 1e9
_PRECISION = 1e-4


def stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
) -> float:
    """Return the largest stable virtual stiffness in N/m, exact; 0 if the damping alone is unstable.

    mass kg, viscous and virtual damping N·s/m, rate Hz, delay s; hand: a Hand, a Grip, a name, or None for a
    released handle. Raise ParameterError.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand)
    return float(stiffness_limits(loop, np.array([loop.damping]))[0])


def _settles(loop: Loop, stiffness: float) -> bool:
    """Return whether the handle, let go 1 µm away, moves less in the run's last third than in the one before.

    Compares a^2 + (w v)^2: steady along a spring's own oscillation, and large where a fast one grows beside a
    slow creep home.
    """
    out = _released(loop, stiffness, _RELEASED_AT)
    if not np.abs(out[:, rows.TRUE_POSITION]).max() < _LOST_AT:
        return False
    third = len(out) // 3
    slowest = math.sqrt((stiffness + loop.hand.stiffness) / loop.mass)
    speed = out[:, rows.TRUE_VELOCITY]
    size = np.hypot(np.diff(speed) * loop.rate, slowest * speed[1:])
    before, after = np.linalg.norm(size[third : 2 * third]), np.linalg.norm(size[2 * third :])
    return bool(after < before or before == 0.0)


def _stays_small(loop: Loop, stiffness: float) -> bool:
    """Return whether the handle, let go 1 mm away, moves within five counts in the run's last third.

    For an estimator that is not linear: it answers motion within the sensor's noise otherwise than motion
    beyond, and so may keep a buzz alive without letting it grow.
    """
    x = _released(loop, stiffness, _RELEASED_FAR)[:, rows.TRUE_POSITION]
    if not np.abs(x).max() < _LOST_AT:
        return False
    third = len(x) // 3
    before, after = np.ptp(x[third : 2 * third]), np.ptp(x[2 * third :])
    return bool(after <= _SMALL or after < _DYING * before)


def _released(loop: Loop, stiffness: float, start: float) -> np.ndarray:
    """Return the rows of a rendered spring whose handle is let go at `start`; raise ParameterError."""
    device = SimulatedHapkit(
        loop.handle_mass, loop.handle_viscous, 0.0, 0.0, math.inf, initial_position=start
    )
    settings = LoopSettings(loop.rate, loop.delay, loop.estimator)
    values = {"stiffness": stiffness, "damping": loop.damping, "center": 0.0}
    slowest = math.sqrt((stiffness + loop.hand.stiffness) / loop.mass)
    count = 3 * math.ceil(max(_SECONDS * loop.rate, _TURNS / slowest * loop.rate, _SAMPLES) / 3.0)
    if count > _MOST_SAMPLES:
        raise ParameterError(f"Measuring at {loop.rate:g} Hz takes {count} samples; {_MOST_SAMPLES} at most.")
    return headless.spring_rows(environments.named("spring"), values, device, settings, loop.hand, count)


def measured_stiffness_limit(
    mass: float,
    viscous: float,
    *,
    damping: float = 0.0,
    rate: float = 1000.0,
    delay: float = 0.0,
    estimator: Spec = "difference",
    hand: Hand | Grip | str | None = None,
) -> float:
    """Return the largest stable virtual stiffness in N/m to 1e-4, found by rendering the spring.

    Arguments as ``stiffness_limit``; a hand rests at the centre. 0 if no spring is stable. With
    an estimator that is not linear, a buzz of up to five counts of the usual sensor counts as stable.
    Raise ParameterError.
    """
    loop = checked_loop(mass, viscous, damping, rate, delay, estimator, hand)
    design(estimator, rate)
    stable = _settles if parse(estimator)[0].response else _stays_small
    low, high = 0.0, 1.0
    while low == 0.0 and high > _SOFTEST:
        low, high = (high, high) if stable(loop, high) else (0.0, high / 4.0)
    if low == 0.0:
        return 0.0
    while high == low or stable(loop, high):
        low, high = high, 4.0 * high
        if high > _STIFFEST:
            return math.inf
    while high > low * (1.0 + _PRECISION):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(loop, middle) else (low, middle)
    return math.sqrt(low * high)

"""The stiffest passive virtual spring: passivity of the sampled loop with any hand and any delay.

The loop samples x at k T. Its command F_k = K x_k + B v^_k acts from k T + td on, with td = d T + θ. Only the
positions at the instants k T and k T + θ matter. Between two of these instants the handle's damping
dissipates at least b Δx²/Δt, which is reached at a constant speed. The controller absorbs the sum of F_k
(y_k+1 - y_k), with y_k = x(k T + td). At one frequency, with x_k = X z^k and x(k T + θ) = P z^k, this is a
Hermitian form in (X, P). It is non-negative if |b β - c| <= b α with α = 1/θ + 1/(T-θ), β = 1/θ + z*/(T-θ), c
= (K + B H)* z^d (z - 1) / 2, and H the velocity estimator. The hand is arbitrary, so neither hand nor mass
matters. For a delay of whole periods this is the condition of Colgate & Schenkel (J. Robotic Systems 14(1),
1997).
"""

import math
from dataclasses import dataclass

import numpy as np

from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, Spec, design, parse
from hapkit_studio.errors import ParameterError

# number of angles at which the condition is evaluated: the minimum, and the increase per whole period of
# delay
_FEWEST, _A_TURN = 2000, 64
_SLOWEST = 1e-4
# a delay that differs from whole periods by a smaller fraction of a period is rounded to whole periods
_SAME = 1e-9
_NEARLY = 1e-12
_HALVINGS = 50
# above this multiple of the handle's damping no virtual damping is passive in any sampled loop
_MOST = 1e6


@dataclass(frozen=True)
class _Angles:
    """The loop at angles w per sample, all arrays of shape (m,): z, the estimator H, and H / (z - 1)."""

    period: float
    whole: int
    rest: float
    w: np.ndarray
    z: np.ndarray
    velocity: np.ndarray
    slope: np.ndarray

    def sweep(self, turns: int) -> np.ndarray:
        """Return S = sin((turns + 1/2) w) / sin(w / 2) at each angle.

        A spring K with a delay of ``turns`` periods is passive if the handle's damping is at least S K T/2.
        """
        return np.sin((turns + 0.5) * self.w) / np.sin(0.5 * self.w)


def passive_stiffness(
    viscous: float,
    damping: np.ndarray,
    rate: float,
    delay: float,
    estimator: Spec = "difference",
    quantum: float = USUAL_QUANTUM,
) -> np.ndarray:
    """Return the largest passive stiffness (n,) in N/m for each virtual damping (n,); 0 if no stiffness is.

    ``viscous`` is the handle's damping in N·s/m, ``rate`` is in Hz, and ``delay`` in s. ``quantum`` in m is
    that of the sensor for which the estimator is designed. Raise ParameterError for a nonlinear estimator.
    """
    angles = _angles(rate, delay, estimator, quantum)
    return np.array([_largest(angles, viscous, float(virtual)) or 0.0 for virtual in damping])


def passive_damping(
    viscous: float,
    rate: float,
    delay: float,
    estimator: Spec = "difference",
    quantum: float = USUAL_QUANTUM,
) -> float:
    """Return the largest virtual damping in N·s/m that is passive with some stiffness.

    The arguments are those of ``passive_stiffness``.
    """
    angles = _angles(rate, delay, estimator, quantum)
    low, high = 0.0, viscous
    while high > 0.0 and _largest(angles, viscous, high) is not None:
        low, high = high, 2.0 * high
        if high > _MOST * viscous:
            return math.inf
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _largest(angles, viscous, middle) is None else (middle, high)
    return low


def _largest(angles: _Angles, viscous: float, damping: float) -> float | None:
    """Return the largest stiffness that is passive at every angle; None if no stiffness is."""
    low, high = (_fractional_bounds if angles.rest else _whole_period_bounds)(angles, viscous, damping)
    most, least = float(np.nanmin(high)), max(float(np.nanmax(low)), 0.0)
    return max(most, 0.0) if most >= least - _NEARLY * viscous / angles.period else None


def _angles(rate: float, delay: float, estimator: Spec, quantum: float) -> _Angles:
    method = parse(estimator)[0]
    if method.response is None:
        raise ParameterError(
            f"There is no passivity line with the velocity filter {method.key}, because it is not linear."
        )
    period = 1.0 / rate
    whole = math.floor(delay * rate + _SAME)
    rest = delay - whole * period
    w = np.union1d(np.geomspace(_SLOWEST, 1.0, 200), np.linspace(0.0, math.pi, _FEWEST + _A_TURN * whole)[1:])
    z = np.exp(1j * w)
    velocity = method.response(design(estimator, rate, quantum)[1], period, z)
    rest = rest if rest > _SAME * period else 0.0
    return _Angles(period, whole, rest, w, z, velocity, velocity / (z - 1.0))


def _whole_period_bounds(at: _Angles, viscous: float, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and largest passive stiffness at each angle, for a delay of whole periods.

    The condition is b + B T Re(W z^-d) >= K T/2 S_d, with W = H / (z - 1) and S_d = sin((d + 1/2) w) /
    sin(w/2).
    """
    free = viscous + damping * at.period * (at.slope * at.z**-at.whole).real
    lag = 0.5 * at.period * at.sweep(at.whole)
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = free / lag
    never = np.where(free >= -_NEARLY * viscous, -math.inf, math.inf)
    low = np.where(lag < 0.0, bound, never)
    return low, np.where(lag > 0.0, bound, math.inf)


def _fractional_bounds(at: _Angles, viscous: float, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest and largest passive stiffness if the delay is not a whole number of periods.

    They are the roots of K² - 2 r K + q = 0. The condition is |b β - c|² <= (b α)². Both sides are reduced by
    their value at w = 0, divided by |z - 1|²/4, and rearranged to avoid cancellation as w -> 0.
    """
    late = at.period - at.rest
    mixed = (1.0 / at.rest + at.z / late) * np.conj(at.slope) * at.z**at.whole
    r = -viscous * (at.sweep(at.whole) / at.rest + at.sweep(at.whole + 1) / late) - damping * at.velocity.real
    q = (
        damping**2 * np.abs(at.velocity) ** 2
        - 4.0 * viscous**2 / (at.rest * late)
        - 4.0 * viscous * damping * mixed.real
    )
    inside = r * r - q
    root = np.sqrt(np.maximum(inside, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = np.where(r < 0.0, r - root, q / (root + r)), np.where(r < 0.0, -q / (root - r), r + root)
    return np.where(inside < 0.0, math.inf, low), np.where(inside < 0.0, -math.inf, high)

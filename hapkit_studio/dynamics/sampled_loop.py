"""Exact limits of stiffness and damping, at which roots of the sampled loop cross the unit circle.

The loop consists of the exact paddle, a force that is held between samples and delayed by any time, u = -(K x
+ B v^) with the linear velocity estimate v^ = H(z) x, and a hand. The hand adds its mass, and a spring and
damper to the ground. There is no quantisation, no Coulomb friction, no force limit. The characteristic
equation 1 + (K + B H) P = 0 has a root on the unit circle if K = -1/P - B H is real at z = e^jw. The inside
of the circle maps to the left of this curve. If the curve crosses the real axis upwards, a pair of roots
leaves the circle when K increases past this value; if it crosses downwards, a pair returns (D-decomposition,
Neimark 1948). There may be several stable intervals: with a filter, damping may drive a slow oscillation on a
soft spring but damp the faster one on a stiffer spring.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise

import numpy as np

from hapkit_studio.dynamics.estimators import design, parse
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.paddle import transition
from hapkit_studio.errors import ParameterError

_SLOWEST = 1e-7
_MOST_STEPS, _CLOSE = 50, 1e-14
# number of dampings per batch; it amortises Python's overhead and fits the processor's cache
_BATCH = 32

# maps angles w per sample (m,) and their columns (m,) to complex values (m,)
Curve = Callable[[np.ndarray, np.ndarray], np.ndarray]
# stable intervals (low, high) in N/m, the lowest first
Intervals = tuple[tuple[float, float], ...]


def _inverse_plant(loop: LoopSettings, w: np.ndarray) -> np.ndarray:
    """Return 1 / P(e^jw); P is the transfer from command to sampled position, with hold and delay.

    The expression uses z - 1, which avoids cancellation at low frequencies.
    """
    m, c, k = loop.moving_mass, loop.total_viscous, loop.grip_stiffness
    period = 1.0 / loop.rate
    whole_periods, fraction = loop.parted
    g0, g1 = transition(m, c, k, period)[4:7:2]
    a, b, c_, d, new0, _, new1, _ = transition(m, c, k, period - fraction)
    first0, first1 = transition(m, c, k, fraction)[4:7:2]
    old0, old1 = a * first0 + b * first1, c_ * first0 + d * first1
    z = np.exp(1j * w)
    step = -2.0 * np.sin(0.5 * w) ** 2 + 1j * np.sin(w)
    slow = step + c * g1 + k * g0
    poles = (step + k * g0) * slow + m * k * g1 * g1
    zeros = slow * (new0 * z + old0) + m * g1 * (new1 * z + old1)
    return np.exp(1j * w * (whole_periods + 1)) * poles / zeros


def _frequencies(loop: LoopSettings) -> np.ndarray:
    """Return angles in rad per sample from nearly 0 to pi, dense enough for the turns of the delay's phase.

    Without delay or hand the crossing is near sqrt(2 b T / m), so the range starts well below this angle.
    """
    turns = loop.delay * loop.rate + 2.0
    slowest = min(_SLOWEST, 0.1 * math.sqrt(loop.total_viscous / (loop.moving_mass * loop.rate))) or _SLOWEST
    even = np.linspace(0.0, math.pi, int(1000 + 24 * turns))[1:]
    return np.union1d(np.geomspace(slowest, 1.0, 600), even)


def _crossings(curve: Curve, w: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where complex curves on [w[0], pi] cross the positive real axis, in no particular order.

    The results are arrays (k,): the column, the value at the crossing, and the number of roots that leave the
    unit circle beyond this value. This number is 2, or -2 if the roots return; at pi it is 1 or -1.
    """
    values = curve(w, np.arange(columns)[:, np.newaxis])
    negative = np.signbit(values.imag)
    negative[:, -1] = negative[:, -2]  # the value at pi is real, and its imaginary part is a rounding error
    column, place = np.nonzero(negative[:, :-1] != negative[:, 1:])
    low, high, below = w[place], w[place + 1], negative[column, place]
    at_low, at_high = values.imag[column, place], values.imag[column, place + 1]
    middle, was_left, found = low, np.full(len(low), -1), np.zeros(len(low), bool)
    # Illinois rule: the secant method, in which the weight of an end is halved if the end is kept twice
    for _ in range(_MOST_STEPS):
        last = middle  # columns that have converged do not change
        middle = np.where(found, last, high - at_high * (high - low) / (at_high - at_low))
        found |= np.abs(middle - last) <= _CLOSE * middle
        if found.all():
            break
        at_middle = curve(middle, column).imag
        left = np.signbit(at_middle) == below
        stays = np.where(left, at_high, at_low) * np.where(left == was_left, 0.5, 1.0)
        at_low, at_high = np.where(left, at_middle, stays), np.where(left, stays, at_middle)
        low, high, was_left = np.where(left, middle, low), np.where(left, high, middle), left
    value = np.r_[curve(middle, column).real, values.real[:, -1]]
    leaving = np.r_[np.where(below, 2, -2), np.where(negative[:, -1], 1, -1)]
    there = value > 0.0
    return np.r_[column, np.arange(columns)][there], value[there], leaving[there]


def _velocity_of(loop: LoopSettings) -> Callable[[np.ndarray], np.ndarray]:
    """Return the estimator's response at angles w per sample; raise ParameterError if nonlinear."""
    coefs = design(loop.estimator, loop.rate, loop.quantum)[1]
    method = parse(loop.estimator)[0]
    response = method.response
    if response is None:
        raise ParameterError(
            f"The estimator {method.key} is not linear, it has no exact stiffness limit: "
            "measured_stiffness_limit finds it by simulation."
        )
    return lambda w: response(coefs, 1.0 / loop.rate, np.exp(1j * w))


def _damping_crossings(loop: LoopSettings) -> tuple[np.ndarray, np.ndarray]:
    """Return the dampings at which roots cross the unit circle, and the number of roots that leave it.

    The stiffness is nearly 0.
    """
    velocity = _velocity_of(loop)

    def curve(w: np.ndarray, column: np.ndarray) -> np.ndarray:
        return np.broadcast_to(-_inverse_plant(loop, w) / velocity(w), np.broadcast(w, column).shape)

    return _crossings(curve, _frequencies(loop), 1)[1:]


def _roots_outside(loop: LoopSettings, damping: np.ndarray) -> np.ndarray:
    """Return the number of roots (n,) outside the unit circle at virtual damping (n,) and stiffness 0."""
    value, leaving = _damping_crossings(loop)
    return (value < damping[:, np.newaxis]) @ leaving


@lru_cache(maxsize=64)
def damping_limit(loop: LoopSettings) -> float:
    """Return the largest stable virtual damping in N·s/m at stiffness 0; inf if it is unlimited.

    Raise ParameterError for a nonlinear estimator.
    """
    return float(_damping_crossings(loop)[0].min(initial=math.inf))


def stable_intervals(loop: LoopSettings, damping: np.ndarray) -> list[Intervals]:
    """Return the stable stiffness intervals for each virtual damping (n,) in N·s/m.

    K = -1/P - B H on the unit circle, one column per damping. Raise ParameterError for a nonlinear estimator.
    """
    velocity, outside = _velocity_of(loop), _roots_outside(loop, damping)
    found: list[Intervals] = []
    for start in range(0, len(damping), _BATCH):
        part = damping[start : start + _BATCH]

        def curve(w: np.ndarray, column: np.ndarray, virtual: np.ndarray = part) -> np.ndarray:
            return -_inverse_plant(loop, w) - virtual[column] * velocity(w)

        column, value, leaving = _crossings(curve, _frequencies(loop), len(part))
        for k in range(len(part)):
            own = np.flatnonzero(column == k)
            own = own[value[own].argsort()]
            edges = [0.0, *value[own].tolist(), math.inf]
            roots = outside[start + k] + np.cumsum([0, *leaving[own]])
            ends = zip(pairwise(edges), roots, strict=True)
            found.append(tuple(interval for interval, lost in ends if lost == 0))
    return [each if b + loop.total_viscous > 0.0 else () for each, b in zip(found, damping, strict=True)]


def first_end(intervals: Intervals) -> float:
    """Return the end in N/m of the stable interval that starts at 0; 0 if the softest spring is unstable."""
    return intervals[0][1] if intervals and intervals[0][0] == 0.0 else 0.0


def stiffness_limits(loop: LoopSettings, damping: np.ndarray) -> np.ndarray:
    """Return the limit (n,) in N/m for each damping, the ``first_end`` of the ``stable_intervals``."""
    return np.array([first_end(each) for each in stable_intervals(loop, damping)])


def stable(loop: LoopSettings, stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Return whether stiffness (m,) in N/m is stable at virtual damping (n,) in N·s/m, as bool (m, n)."""
    found = np.zeros((len(stiffness), len(damping)), dtype=bool)
    for column, intervals in enumerate(stable_intervals(loop, damping)):
        for low, high in intervals:
            found[:, column] |= (low < stiffness) & (stiffness <= high)
    return found


@lru_cache(maxsize=64)
def stiffness_limit(loop: LoopSettings, damping: float = 0.0) -> float:
    """Return the largest stable stiffness in N/m at a virtual damping in N·s/m.

    Raise ParameterError for a nonlinear estimator.
    """
    return float(stiffness_limits(loop, np.array([damping]))[0])

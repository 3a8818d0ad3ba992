"""Theory curves: a law's static force over position or velocity, sampled adaptively at bends and jumps."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio.environments.base import Environment, Values

Force = Callable[[np.ndarray], np.ndarray]
"""Force in N per branch (m, n), NaN for a gap, over position in m or velocity in m/s (n,)."""

TOLERANCE = 2e-3  # N: tolerance of the interpolation, a hundredth of a perceptible force
# N: a step with a larger deviation is refined; the interpolation error is at most deviation / 0.382
_REFINE_ABOVE = 0.35 * TOLERANCE
WHOLE = 1000  # number of even steps of a whole curve; a range of 120 mm has steps of 0.12 mm
_COARSER = (16, 4, 1)  # even steps between samples in successive passes; a slow law gets fewer passes
_PROBE = 0.382  # position of the test sample in a step; it finds waves as long as a step or half a step
_PARTS = 8  # number of parts into which a step with a bend or jump is divided, repeatedly
_NARROWEST = 1e-9  # fraction of the range to which a bend or jump is located
_MOST = 4  # largest number of samples per even step; finer waves look like a band on any screen
_SECONDS = 0.05  # s: processor time after which sampling of a slow law stops


@dataclass(frozen=True)
class Curve:
    """Samples x (n,), ascending in SI units, and force (m, n) in N; ``even`` marks samples at even steps."""

    force_at: Force
    x: np.ndarray
    force: np.ndarray
    even: np.ndarray


def over_position(environment: Environment, values: Values, low: float, high: float) -> Curve | None:
    """Return the static force from low to high in m; None if the law depends only on velocity."""
    declared = environment.over_position
    if declared is not None:
        return _if_any(sampled(lambda x: np.atleast_2d(declared(values, x)), low, high))
    if environment.over_velocity is not None:
        return None
    still = sampled(lambda x: environment.curve(values, x)[np.newaxis], low, high)
    moving = environment.curve(values, still.x[:1], 0.1)[0]
    return None if not np.ptp(still.force) and moving != still.force[0, 0] else still


def over_velocity(environment: Environment, values: Values, low: float, high: float) -> Curve | None:
    """Return the force from low to high in m/s; None if the law depends on position."""
    declared = environment.over_velocity
    if declared is not None:
        return _if_any(sampled(lambda v: np.atleast_2d(declared(values, v)), low, high))
    if environment.over_position is not None:
        return None
    along = sampled(lambda x: environment.curve(values, x)[np.newaxis], -0.05, 0.05)
    if np.ptp(along.force):
        return None
    return sampled(lambda v: environment.curve(values, np.zeros(1), v)[np.newaxis], low, high)


def _if_any(curve: Curve) -> Curve | None:
    return curve if np.isfinite(curve.force).any() else None


def sampled(force_at: Force, low: float, high: float, steps: int = WHOLE) -> Curve:
    """Sample a force from low to high: at even steps, between them, and adaptively at bends and jumps.

    Linear interpolation is accurate to ``TOLERANCE`` for features wider than a step. A slow law gets fewer
    samples.
    """
    end = time.thread_time() + _SECONDS  # processor time, so that the load of other programs costs no samples
    for coarser in _COARSER:
        even = np.linspace(low, high, max(steps // coarser, 1) + 1)
        x, force = even, np.asarray(force_at(even))
        if time.thread_time() > end:
            return Curve(force_at, even, force, np.full(len(even), True))
    more = even[:-1] + _PROBE * np.diff(even)
    while len(more) and time.thread_time() < end:
        order = np.argsort(np.append(x, more), kind="stable")
        x, force = np.append(x, more)[order], np.hstack([force, force_at(more)])[:, order]
        wide = np.diff(x)
        coarse = np.flatnonzero((_deviations(x, force) > _REFINE_ABOVE) & (wide > _NARROWEST * (high - low)))
        parts = min((_MOST * (steps + 1) - len(x)) // max(len(coarse), 1) + 1, _PARTS)
        shares = np.arange(1, parts) / parts
        more = (x[coarse, np.newaxis] + wide[coarse, np.newaxis] * shares).ravel()
    return Curve(force_at, x, force, np.isin(x, even))


def _deviations(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the deviation in N (n - 1,) of the force in each interval from a linear extrapolation.

    The force is extrapolated from the left and from the right; the smaller deviation is used. An interval
    next to a bend or jump deviates from one extrapolation only; an interval that contains it, from both.
    """
    wide = np.diff(x)
    middle = (force[:, :-2] * wide[1:] + force[:, 2:] * wide[:-1]) / (wide[1:] + wide[:-1])
    off = np.nan_to_num(np.abs(force[:, 1:-1] - middle)).max(axis=0)
    ends = np.diff(np.isfinite(force), axis=1).any(axis=0)
    return np.where(ends, np.inf, np.minimum(np.append(off, np.inf), np.append(np.inf, off)))

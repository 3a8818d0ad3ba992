"""Theory curves: a law's force at rest over position, or over velocity, sampled where it bends and jumps."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio.environments.base import Environment, Values

Force = Callable[[np.ndarray], np.ndarray]
"""Force in N by branch (m, n), NaN where there is none, over position in m or velocity in m/s (n,)."""

TOLERANCE = 2e-3  # N between the curve and the line through its samples: a hundredth of what a hand feels
_BENT = 0.35 * TOLERANCE  # off its neighbours' lines: the curve is up to 1 / 0.382 times as far off its own
WHOLE = 1000  # even steps of a whole curve: 0.12 mm of the 120 mm of a position
_COARSER = (16, 4, 1)  # steps in place of one, tried one after the other while time allows
_PROBE = 0.382  # of a step: a wave whose length is the step, or half of it, shows there
_PARTS = 8  # into which a step with a bend or jump is divided at most, again and again
_NARROWEST = 1e-9  # of the range: a bend or jump is located to this
_MOST = 4  # samples for each even step: waves finer than that are a band on any screen
_SECONDS = 0.05  # of processor time, after which the samples must do: some laws are slow


@dataclass(frozen=True)
class Curve:
    """Samples x (n,) ascending in SI, force (m, n) in N; even: those at even steps, both ends included."""

    force_at: Force
    x: np.ndarray
    force: np.ndarray
    even: np.ndarray


def over_position(environment: Environment, values: Values, low: float, high: float) -> Curve | None:
    """Return the force at rest from low to high in m; None where the law depends on velocity alone."""
    declared = environment.over_position
    if declared is not None:
        return _if_any(sampled(lambda x: np.atleast_2d(declared(values, x)), low, high))
    if environment.over_velocity is not None:
        return None
    still = sampled(lambda x: environment.curve(values, x)[np.newaxis], low, high)
    moving = environment.curve(values, still.x[:1], 0.1)[0]
    return None if not np.ptp(still.force) and moving != still.force[0, 0] else still


def over_velocity(environment: Environment, values: Values, low: float, high: float) -> Curve | None:
    """Return the force from low to high in m/s; None where it depends on position."""
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
    """Sample a force from low to high: at even steps, between them, and ever closer to bends and jumps.

    Lines through the samples are within `TOLERANCE` of a curve whose features are wider than a step. A slow
    law gets fewer samples.
    """
    end = time.thread_time() + _SECONDS  # not the clock: another program's work costs no samples
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
        coarse = np.flatnonzero((_off(x, force) > _BENT) & (wide > _NARROWEST * (high - low)))
        parts = min((_MOST * (steps + 1) - len(x)) // max(len(coarse), 1) + 1, _PARTS)
        shares = np.arange(1, parts) / parts
        more = (x[coarse, np.newaxis] + wide[coarse, np.newaxis] * shares).ravel()
    return Curve(force_at, x, force, np.isin(x, even))


def _off(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return how far in N each step (n - 1,) is off the lines through its neighbours on both sides.

    Beside a bend or jump only one of them is off, and where one lies between two samples both are.
    """
    wide = np.diff(x)
    middle = (force[:, :-2] * wide[1:] + force[:, 2:] * wide[:-1]) / (wide[1:] + wide[:-1])
    off = np.nan_to_num(np.abs(force[:, 1:-1] - middle)).max(axis=0)
    ends = np.diff(np.isfinite(force), axis=1).any(axis=0)
    return np.where(ends, np.inf, np.minimum(np.append(off, np.inf), np.append(np.inf, off)))

"""The longest step at which an integrator does not make a mass on a spring and damper gain energy; SI."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np


def _explicit_euler(ratio: float) -> float:
    return 2.0 * ratio if ratio <= 1.0 else 2.0 / (ratio + math.sqrt(ratio * ratio - 1.0))


def _lecture(ratio: float) -> float:
    """Return (1 + 2 r^2 - sqrt(1 + 4 r^4)) / r, written so that it keeps its digits for small r."""
    return 4.0 * ratio / (1.0 + 2.0 * ratio**2 + math.sqrt(1.0 + 4.0 * ratio**4))


def _semi_implicit(ratio: float) -> float:
    return 2.0 / (math.sqrt(1.0 + ratio * ratio) + ratio)


def _verlet(ratio: float) -> float:
    return 2.0


@lru_cache(maxsize=64)
def _rk4(ratio: float) -> float:
    """Return the first step at which the method amplifies an eigenvalue, its polynomial beyond 1."""
    eigenvalues = np.roots([1.0, 2.0 * ratio, 1.0])
    steps = np.geomspace(1e-4, 3.0, 12_000)
    z = steps[:, None] * eigenvalues
    grows = np.abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))).max(axis=1) > 1.0 + 1e-12
    return float(steps[np.argmax(grows)])


_LIMITS: dict[str, Callable[[float], float]] = {
    "explicit_euler": _explicit_euler,
    "lecture": _lecture,
    "semi_implicit": _semi_implicit,
    "verlet": _verlet,
    "rk4": _rk4,
}


def longest_step(method: str, mass: float, damping: float, stiffness: float) -> float:
    """Return the limit of one of INTEGRATORS in s, inf for those that have none; stiffness above 0.

    The explicit ones' closed forms over the damping ratio follow from their characteristic polynomials.
    """
    if method not in _LIMITS:
        return math.inf
    omega = math.sqrt(stiffness / mass)
    return _LIMITS[method](damping / (2.0 * mass * omega)) / omega

"""Stability of integrators for a mass on a spring: spectral radius of one step, and longest stable step.

All quantities are dimensionless: step is ω dt, and ratio is the damping ratio ζ = b / (2 m ω). The closed
forms follow from the characteristic polynomials of one step.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike


def _one_step(amplification: Callable[[np.ndarray], np.ndarray]) -> Callable:
    """Return the spectral-radius function of a method that multiplies each mode by a function of step · λ."""

    def radius(step: np.ndarray, ratio: np.ndarray) -> np.ndarray:
        root = np.sqrt(np.asarray(ratio * ratio - 1.0, complex))
        eigenvalues = -ratio + root, -ratio - root  # eigenvalues of x″ = −x − 2 ratio x′
        return np.maximum(*(np.abs(amplification(step * value)) for value in eigenvalues))

    return radius


def _quadratic(trace: np.ndarray, determinant: np.ndarray) -> np.ndarray:
    """Return the larger absolute value of the two roots of z² − trace z + determinant."""
    root = np.sqrt(np.asarray(trace * trace - 4.0 * determinant, complex))
    return 0.5 * np.maximum(np.abs(trace + root), np.abs(trace - root))


def _verlet(step: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """Return the spectral radius of x1 = x + h v + h² a / 2, v1 = v + h (a + a1) / 2.

    a1 = −x1 − 2 ratio v1 is inserted, and the second equation is solved for v1.
    """
    square, loss = step * step, ratio * step
    trace = 1.0 - 0.5 * square + ((1.0 - loss) - 0.5 * step * (step - loss * step)) / (1.0 + loss)
    return _quadratic(trace, (1.0 - loss) / (1.0 + loss))


def _lecture(step: np.ndarray, ratio: np.ndarray) -> np.ndarray:
    """Return the spectral radius from the companion matrices of the characteristic polynomial.

    The polynomial is z³ + (h²/4 + ratio h − 2) z² + (1 + h²/2) z + (h²/4 − ratio h).
    """
    quarter = 0.25 * step * step
    companion = np.zeros((*np.broadcast(step, ratio).shape, 3, 3))
    companion[..., 0, 0] = 2.0 - quarter - ratio * step
    companion[..., 0, 1] = -1.0 - 2.0 * quarter
    companion[..., 0, 2] = ratio * step - quarter
    companion[..., 1, 0] = companion[..., 2, 1] = 1.0
    return np.abs(np.linalg.eigvals(companion)).max(axis=-1)


def _rk4(z: np.ndarray) -> np.ndarray:
    return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))


_RADIUS: dict[str, Callable] = {
    "explicit_euler": _one_step(lambda z: 1.0 + z),
    "lecture": _lecture,
    "semi_implicit": lambda h, r: _quadratic(2.0 - 2.0 * r * h - h * h, 1.0 - 2.0 * r * h),
    "verlet": _verlet,
    "rk4": _one_step(_rk4),
    "implicit_euler": _one_step(lambda z: 1.0 / (1.0 - z)),
    "trapezoid": _one_step(lambda z: (1.0 + 0.5 * z) / (1.0 - 0.5 * z)),
    "exact": _one_step(np.exp),
}


def spectral_radius(method: str, step: ArrayLike, ratio: ArrayLike) -> np.ndarray:
    """Return the largest growth factor of one step; above 1 the motion grows.

    ``method`` is one of INTEGRATORS. ``step`` and ``ratio`` broadcast together.
    """
    return _RADIUS[method](np.asarray(step, float), np.asarray(ratio, float))


def _rk4_limit(ratio: float) -> float:
    """Return the largest step with a spectral radius of 1; for a ratio above 1, the faster mode limits it."""
    from scipy.optimize import brentq  # imported here because it is slow

    damped = min(ratio, 1.0)
    limit = float(brentq(lambda h: float(spectral_radius("rk4", h, damped)) - 1.0, 1.0, 4.0, xtol=1e-13))
    return limit / (ratio + math.sqrt(ratio * ratio - 1.0)) if ratio > 1.0 else limit


# functions of the damping ratio r that return the longest step in 1 / ω
_LONGEST: dict[str, Callable[[float], float]] = {
    "explicit_euler": lambda r: 2.0 * r if r <= 1.0 else 2.0 / (r + math.sqrt(r * r - 1.0)),
    # this is (1 + 2 r² − sqrt(1 + 4 r⁴)) / r in a form without cancellation for small r
    "lecture": lambda r: 4.0 * r / (1.0 + 2.0 * r**2 + math.sqrt(1.0 + 4.0 * r**4)),
    "semi_implicit": lambda r: 2.0 / (math.sqrt(1.0 + r * r) + r),
    "verlet": lambda r: 2.0,
    "rk4": _rk4_limit,
}


def longest_step(method: str, mass: float, damping: float, stiffness: float) -> float:
    """Return the longest step in s at which a mass on a spring (> 0 N/m) and damper gains no energy.

    Return inf for a method that is unconditionally stable.
    """
    if method not in _LONGEST:
        return math.inf
    omega = math.sqrt(stiffness / mass)
    return _LONGEST[method](damping / (2.0 * mass * omega)) / omega

"""How much one step of an integrator amplifies x'' = -x - 2 r x', from its formula alone."""

from collections.abc import Callable

import numpy as np


def _explicit_euler(r: float, h: float) -> np.ndarray:
    return np.roots([1.0, 2.0 * r * h - 2.0, 1.0 - 2.0 * r * h + h * h])


def _lecture(r: float, h: float) -> np.ndarray:
    q = 0.25 * h * h
    return np.roots([1.0, q + r * h - 2.0, 1.0 + 2.0 * q, q - r * h])


def _semi_implicit(r: float, h: float) -> np.ndarray:
    return np.roots([1.0, 2.0 * r * h + h * h - 2.0, 1.0 - 2.0 * r * h])


def _verlet(r: float, h: float) -> np.ndarray:
    """x1 = x + h v + h² a / 2, v1 = v + h (a + a1) / 2 with a1 = -x1 - 2 r v1, solved for v1."""
    x = np.array([1.0 - 0.5 * h * h, h - r * h * h])
    v = np.array([-0.5 * h, 1.0 - r * h]) - 0.5 * h * x
    return np.linalg.eigvals(np.array([x, v / (1.0 + r * h)]))


def _rk4(r: float, h: float) -> np.ndarray:
    z = h * np.roots([1.0, 2.0 * r, 1.0])
    return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))


def _implicit_euler(r: float, h: float) -> np.ndarray:
    return 1.0 / (1.0 - h * np.roots([1.0, 2.0 * r, 1.0]))


def _trapezoid(r: float, h: float) -> np.ndarray:
    z = 0.5 * h * np.roots([1.0, 2.0 * r, 1.0])
    return (1.0 + z) / (1.0 - z)


def _exact(r: float, h: float) -> np.ndarray:
    return np.exp(h * np.roots([1.0, 2.0 * r, 1.0]))


_ROOTS: dict[str, Callable[[float, float], np.ndarray]] = {
    "explicit_euler": _explicit_euler,
    "lecture": _lecture,
    "semi_implicit": _semi_implicit,
    "verlet": _verlet,
    "rk4": _rk4,
    "implicit_euler": _implicit_euler,
    "trapezoid": _trapezoid,
    "exact": _exact,
}


def growth_per_radian(method: str, ratio: float, step: float) -> float:
    """Return the growth of the largest root over ω t; ratio is the damping ratio, step ω dt."""
    return float(np.log(np.abs(_ROOTS[method](ratio, step)).max()) / step)

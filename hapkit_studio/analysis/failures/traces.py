"""Traces of motions: where they are lost, how fast they grow, and made short enough to be drawn."""

import numpy as np

# Points of a trace: a pixel has two of them, its lowest and its highest.
POINTS = 2400


def before_lost(x: np.ndarray, most: float) -> int:
    """Return how many samples of x (n,) come before the first beyond ``most`` or not finite."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.abs(x) <= most)
    return int(np.argmax(lost)) if lost.any() else len(x)


def alive(size: np.ndarray, least: float) -> int:
    """Return how many samples of size (n,) there are up to the last that is ``least`` or more."""
    big = np.flatnonzero(size >= least)
    return int(big[-1]) + 1 if len(big) else 0


def thinned(time: np.ndarray, x: np.ndarray, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Return (time, x) of at most about ``points``: of each piece the lowest and the highest, in order."""
    if len(x) <= points:
        return time, x
    size = -(-2 * len(x) // points)
    count = len(x) // size
    pieces = x[: count * size].reshape(count, size)
    first = size * np.arange(count)
    lowest, highest = first + pieces.argmin(axis=1), first + pieces.argmax(axis=1)
    chosen = np.unique(np.r_[lowest, highest, len(x) - 1])
    return time[chosen], x[chosen]


def growth(size: np.ndarray, seconds: float) -> float:
    """Return the growth in 1/s of an oscillation's size (n,), samples ``seconds`` apart.

    From the last two thirds of it, so that what dies out at once does not count; 0 where nothing moves.
    """
    third = len(size) // 3
    if third == 0:
        return float("inf")
    before, after = np.linalg.norm(size[-2 * third : -third]), np.linalg.norm(size[-third:])
    if after == 0.0:
        return 0.0 if before == 0.0 else float("-inf")
    with np.errstate(divide="ignore"):
        return float(np.log(after / before) / (third * seconds))

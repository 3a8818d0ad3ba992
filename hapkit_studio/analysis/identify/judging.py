"""When a piece tells a number and when not, and what to do then."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import stats

from hapkit_studio.analysis.identify.grid import Grid
from hapkit_studio.analysis.identify.part import TERMS, Estimate, Points
from hapkit_studio.analysis.identify.regression import LEVEL, Fit
from hapkit_studio.analysis.identify.windows import Windows

# Sums over samples stand for integrals only so well: no interval is finer than that share of what is felt.
_FINEST = 1e-3


@dataclass(frozen=True)
class Sizes:
    """How far, how fast and how hard a piece moves: m peak to peak, m/s, m/s^2; frequency, mean in m."""

    travel: float
    speed: float
    jolt: float
    hertz: float
    middle: float = 0.0


def sizes(position: np.ndarray, windows: Windows, kept: np.ndarray) -> Sizes:
    """Return the sizes of a position (n,) in the windows kept; zeros where there is none."""
    if not kept.any():
        return Sizes(0.0, 0.0, 0.0, 0.0)
    x, v, a = (windows.derivative(position, order)[kept] for order in range(3))
    spread = float(np.std(x))
    hertz = float(np.sqrt(np.mean(v**2))) / (math.tau * spread) if spread > 0.0 else 0.0
    return Sizes(float(np.ptp(x)), float(np.abs(v).max()), float(np.abs(a).max()), hertz, float(x.mean()))


def speed_of(grid: Grid, chosen: np.ndarray) -> float:
    """Return the root mean square speed in m/s of the samples chosen (n,), 0 without motion."""
    moving = chosen & (grid.sign != 0.0)
    return float(np.sqrt(np.mean(grid.slope[moving] ** 2))) if moving.any() else 0.0


def estimate(
    name: str,
    value: float,
    half: float,
    moved: Sizes,
    asked: float | None = None,
    expected: float | None = None,
) -> Estimate:
    """Return the estimate; an interval wider than its value and than what is felt tells nothing."""
    term, value = TERMS[name], float(value)
    half = max(float(half), _FINEST * term.fine)
    told = math.isfinite(half) and (half <= abs(value) or half <= term.fine) and _possible(name, value, half)
    words = {
        "travel": f"{1e3 * moved.travel:.2g} mm",
        "speed": f"{1e3 * moved.speed:.2g} mm/s",
        "jolt": f"{moved.jolt:.2g} m/s²",
    }
    advice = "" if told else f"Cannot tell. {term.advice.format(**words)}"
    return Estimate(name, value, half, asked, expected, told, advice)


def _possible(name: str, value: float, half: float) -> bool:
    """Return whether a handle can have such a number: a mass is above zero, no friction pushes."""
    if name == "mass":
        return value - half > 0.0
    return name not in ("viscous", "coulomb") or value + half >= 0.0


def points(
    grid: Grid,
    windows: Windows,
    names: tuple[str, ...],
    columns: np.ndarray,
    force: np.ndarray,
    kept: np.ndarray,
    fit: Fit,
) -> Points:
    """Return what was used, to be drawn."""
    times = grid.begin + grid.period * (windows.starts + 0.5 * windows.length)
    return Points(
        times[kept],
        (*names, "offset"),
        columns[kept],
        fit.beta,
        fit.covariance,
        float(stats.t.ppf(0.5 + 0.5 * LEVEL, fit.freedom)),
        force[kept],
        fit.residual,
        grid.middle,
    )

"""The period of stick-slip: measured from the spring's force, and in closed form."""

import math

import numpy as np

# What hardly pulls the spring tight is no stick-slip, in N; the first cycles are left out.
_HARDLY, _FIRST = 0.05, 2


def measured(t: np.ndarray, force: np.ndarray) -> float:
    """Return the mean time in s between falls of the force (n,) through its middle, inf where it has none."""
    late = force[len(force) // 4 :]
    if not np.isfinite(force).all() or np.ptp(late) < _HARDLY:
        return math.inf
    middle = 0.5 * (late.max() + late.min())
    falls = np.flatnonzero((force[:-1] >= middle) & (force[1:] < middle))[_FIRST:]
    if len(falls) < 2:
        return math.inf
    share = (force[falls] - middle) / (force[falls] - force[falls + 1])
    times = t[falls] + share * (t[falls + 1] - t[falls])
    return float(times[-1] - times[0]) / (len(times) - 1)


def exact(mass: float, spring: float, static: float, kinetic: float, speed: float) -> float:
    """Return the period in s without viscous friction: 2 dF / (k V) + 2 (pi - atan lambda) / omega."""
    drop, omega = static - kinetic, math.sqrt(spring / mass)
    slope = drop / (speed * math.sqrt(spring * mass))
    return 2.0 * drop / (spring * speed) + 2.0 * (math.pi - math.atan(slope)) / omega


def error(t: np.ndarray, force: np.ndarray, period: float) -> float:
    """Return by what share of it the period measured is off."""
    found = measured(t, force)
    return abs(found / period - 1.0)

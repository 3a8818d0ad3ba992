"""A moving mass driven by any integrator, step after step, compiled; the period of stick-slip."""

import math
from dataclasses import astuple, dataclass

import numpy as np

from hapkit_studio.dynamics.integrators import INTEGRATORS, glide, step
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.dynamics.moving_mass import FAR, acceleration


@dataclass(frozen=True)
class Body:
    """The parameters of an object in the order of ``moving_mass``, without force and handle; SI units."""

    mass: float
    damping: float = 0.0
    stiffness: float = 0.0
    contact: float = 0.0
    reach: float = FAR
    wall: float = 0.0
    static: float = 0.0
    kinetic: float = 0.0

    def numbers(self) -> np.ndarray:
        """Return these numbers as one row."""
        return np.array(astuple(self))


_EXACT = float(INTEGRATORS.index("exact"))


@compiled
def drive(method, times, h, body, force, touch, x, v):
    """Fill x, v (n,) from their first values, `times` over; force and touch (n,) are held for a step.

    body are the numbers of Body. What rests stays up to the static friction and slides against the kinetic.
    """
    m, b, k, contact = body[0], body[1], body[2], body[3]
    reach, wall, static, kinetic = body[4], body[5], body[6], body[7]
    for _ in range(times):
        if method == _EXACT and contact == 0.0 and wall == 0.0 and max(static, kinetic) == 0.0:
            glide(h, m, b, k, force, x, v)
            continue
        before = acceleration(x[0], v[0], m, b, k, force[0], touch[0], 1.0, 0.0, contact, 0.0, reach, wall)
        for n in range(x.size - 1):
            f = force[n]
            held = v[n] == 0.0 and abs(f - k * x[n]) <= static
            friction = static if held else kinetic
            x[n + 1], v[n + 1], before = step(
                method, x[n], v[n], before, h, friction,
                m, b, k, f, touch[n], 1.0, 0.0, contact, 0.0, reach, wall,
            )  # fmt: skip


def samples(seconds: float, h: float) -> np.ndarray:
    """Return the times (n,) from 0 to seconds, both ends included."""
    return h * np.arange(math.floor(seconds / h + 0.5) + 1)


# What hardly pulls the spring tight is no stick-slip, in N; the first cycles are left out.
_HARDLY, _FIRST = 0.05, 2


def exact_period(mass: float, spring: float, static: float, kinetic: float, speed: float) -> float:
    """Return the period in s without viscous friction: 2 dF / (k V) + 2 (pi - atan lambda) / omega."""
    drop, omega = static - kinetic, math.sqrt(spring / mass)
    slope = drop / (speed * math.sqrt(spring * mass))
    return 2.0 * drop / (spring * speed) + 2.0 * (math.pi - math.atan(slope)) / omega


def period_error(t: np.ndarray, force: np.ndarray, period: float) -> float:
    """Return by what share of it the mean time between falls of the force (n,) through its middle is off.

    inf where there are none.
    """
    late = force[len(force) // 4 :]
    if not np.isfinite(force).all() or np.ptp(late) < _HARDLY:
        return math.inf
    middle = 0.5 * (late.max() + late.min())
    falls = np.flatnonzero((force[:-1] >= middle) & (force[1:] < middle))[_FIRST:]
    if len(falls) < 2:
        return math.inf
    share = (force[falls] - middle) / (force[falls] - force[falls + 1])
    times = t[falls] + share * (t[falls + 1] - t[falls])
    return abs(float(times[-1] - times[0]) / (len(times) - 1) / period - 1.0)

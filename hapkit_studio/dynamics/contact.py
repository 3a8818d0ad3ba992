"""A mass between two springy walls at ± reach, simulated in two ways; SI units.

``held`` samples the contact force, and ``located`` computes the times of contact and release.
"""

import math

import numpy as np

from hapkit_studio.dynamics.jit import compiled


@compiled
def spring(x, reach, rate):
    """Return the acceleration in m/s² that a wall causes; ``rate`` is its stiffness over the mass in 1/s²."""
    if x > reach:
        return -rate * (x - reach)
    return -rate * (x + reach) if x < -reach else 0.0


@compiled
def held(times: int, h: float, mass: float, wall: float, reach: float, x: np.ndarray, v: np.ndarray) -> None:
    """Compute x, v (n,) from their first values; the wall's force is constant between samples.

    The computation is repeated ``times`` times, to measure its speed.
    """
    for _ in range(times):
        for n in range(x.size - 1):
            a = spring(x[n], reach, wall / mass)
            x[n + 1], v[n + 1] = x[n] + h * (v[n] + 0.5 * h * a), v[n] + h * a


@compiled
def located(
    times: int, h: float, mass: float, wall: float, reach: float, x: np.ndarray, v: np.ndarray
) -> None:
    """Compute x, v (n,) from their first values by Verlet; steps are split at contact and release.

    The computation is repeated ``times`` times, to measure its speed.
    """
    rate = wall / mass
    for _ in range(times):
        for n in range(x.size - 1):
            q, u, left = x[n], v[n], h
            for _part in range(4):
                a = spring(q, reach, rate)
                inside = abs(q) > reach or (abs(q) == reach and q * u > 0.0)
                span = left
                level = math.copysign(reach, q if inside else u)
                end = q + left * (u + 0.5 * left * a)
                crosses = (abs(end) <= reach) if inside else (abs(end) > reach)
                if crosses and q != level:
                    # the smaller root of q + u t + a t²/2 = level, in a form without cancellation
                    root = math.sqrt(max(u * u + 2.0 * a * (level - q), 0.0))
                    span = min(2.0 * (level - q) / (u + math.copysign(root, level - q)), left)
                end = q + span * (u + 0.5 * span * a)
                if span < left:
                    end = level
                u += 0.5 * span * (a + spring(end, reach, rate))
                q = end
                left -= span
                if left <= 0.0:
                    break
            x[n + 1], v[n + 1] = q, u

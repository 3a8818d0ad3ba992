"""Independent simulation of a handle that is released or kicked, with or without a hand on it.

A step is 1/32 of a sample period. The simulation shares only numpy and numba with the product. A step
in which friction would reverse the velocity ends at rest; estimators use their difference equations.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

STEPS = 32


@dataclass(frozen=True)
class Handle:
    """A handle, its loop, a spring or a wall, and the hand on it.

    A wall is ``one_sided`` and has its surface at 0 m. ``hand`` is its mass, damping and stiffness, or zeros.
    """

    mass: float
    viscous: float
    coulomb: float
    quantum: float
    limit: float
    rate: float
    delay: float
    stiffness: float
    damping: float
    one_sided: bool = False
    hand: tuple[float, float, float] = (0.0, 0.0, 0.0)
    filter: tuple[float, ...] = (1.0,)  # coefficient of a low-pass, or alpha and beta of a tracker

    def let_go(self, place: float, target: float, seconds: float, speed: float = 0.0) -> np.ndarray:
        """Return the positions (n,) in m after a release at rest or a kick; the hand's target is in m."""
        n = round(seconds * self.rate)
        numbers = np.array([
            self.mass + self.hand[0], self.viscous + self.hand[1], self.coulomb, self.quantum, self.limit,
            1.0 / self.rate, self.delay, self.stiffness, self.damping, float(self.one_sided), self.hand[2],
            target, place, speed,
        ])  # fmt: skip
        return _run(numbers, np.array(self.filter), n)


@njit
def _run(numbers, filtering, n):
    mass, viscous, coulomb, quantum, limit, period, delay, stiffness, damping = numbers[:9]
    one_sided, pull, target, x, v = numbers[9:]
    steps = STEPS
    h = period / steps
    late = round(delay / h)
    forces = np.zeros(n * steps + late + 1)
    places = np.empty(n)
    seen, rate, guess = 0.0, 0.0, 0.0
    for k in range(n):
        now = quantum * math.floor(x / quantum) if quantum > 0.0 else x
        if k == 0:
            seen = guess = now
        if filtering.size == 1:
            rate += filtering[0] * ((now - seen) / period - rate)
        else:
            guess += period * rate
            rate, guess = rate + filtering[1] * (now - guess) / period, guess + filtering[0] * (now - guess)
        seen = now
        force = 0.0
        if one_sided == 0.0:
            force = -stiffness * now - damping * rate
        elif now > 0.0:
            force = -stiffness * now - damping * max(rate, 0.0)
        force = min(max(force, -limit), limit)
        for i in range(steps):
            forces[k * steps + i + late] = force
        places[k] = x
        for i in range(steps):
            u = forces[k * steps + i] + pull * (target - x - 0.5 * h * v)
            if v == 0.0 and abs(u) <= coulomb:
                continue
            side = math.copysign(1.0, v) if v != 0.0 else math.copysign(1.0, u)
            new = (v + h * (u - side * coulomb) / mass) / (1.0 + h * viscous / mass)
            if new * side < 0.0:
                new = 0.0
            x += 0.5 * h * (v + new)
            v = new
    return places

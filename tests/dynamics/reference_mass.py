"""Independent simulation of a pushed mass by an adaptive ODE solver that stops at every event."""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class World:
    """Parameters of the forces on the mass, in the order in which the compiled steps take them."""

    m: float
    b: float = 0.0
    k: float = 0.0
    f: float = 0.0
    touch: float = -9.0
    side: float = 1.0
    speed: float = 0.0
    contact: float = 0.0
    pad: float = 0.0
    reach: float = 9.0
    wall: float = 0.0

    @property
    def numbers(self):
        return tuple(vars(self).values())

    def acceleration(self, x, v):
        """Return x'' at (x, v), including the forces of all contacts that touch the mass at x."""
        depth, rate = self.side * (self.touch - x), self.side * (self.speed - v)
        push = self.contact * depth + self.pad * max(rate, 0.0) if depth > 0.0 else 0.0
        beyond = max(x - self.reach, 0.0) + min(x + self.reach, 0.0)
        return (self.f - self.b * v - self.k * x + self.side * push - self.wall * beyond) / self.m

    def energy(self, x, v):
        """Return the sum of the kinetic energy and the springs' energy."""
        depth = max(self.side * (self.touch - x), 0.0)
        beyond = max(abs(x) - self.reach, 0.0)
        springs = self.k * x * x + self.contact * depth**2 + self.wall * beyond**2
        return 0.5 * (self.m * v * v + springs) - self.f * x


def advance(world, x, v, h, friction=0.0):
    """Return (x, v) after h. The solver is restarted slightly beyond each event.

    Events are contacts, walls, reversals, and the instants at which both speeds are equal.
    """
    levels = (
        lambda t, y: y[0] - world.touch,
        lambda t, y: y[0] - world.reach,
        lambda t, y: y[0] + world.reach,
        lambda t, y: y[1] - world.speed,
        lambda t, y: y[1],
    )
    for level in levels:
        level.terminal = True  # type: ignore[attr-defined]
    left = h
    while left > 0.0:
        pull = world.acceleration(x, v) * world.m
        if friction > 0.0 and abs(v) < 1e-10 and abs(pull) <= friction:
            return x, 0.0
        dry = friction * np.sign(v if abs(v) >= 1e-10 else pull) / world.m

        def rates(t, y, dry=dry):
            return [y[1], world.acceleration(y[0], y[1]) - dry]

        # skip the last event, so that it is not found again
        skip = min(1e-9, left)
        y = np.array([x, v]) + skip * np.array(rates(0.0, [x, v]))
        left -= skip
        if left <= 0.0:
            return float(y[0]), float(y[1])
        found = solve_ivp(
            rates, (0.0, left), y, method="DOP853", rtol=1e-10, atol=1e-14, events=levels, max_step=0.3e-3
        )
        x, v = found.y[:, -1]
        if friction > 0.0 and len(found.t_events[4]):
            v = 0.0
        left -= found.t[-1]
    return x, v

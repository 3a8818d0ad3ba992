"""A virtual mass under each friction model: drawn by a spring, or pulled by less than friction holds."""

import math
from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.accuracy import period, timing
from hapkit_studio.analysis.accuracy.driving import samples
from hapkit_studio.dynamics import stick_slip
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.dynamics.stick_slip import MODELS

MASS, STATIC, KINETIC = 0.05, 1.0, 0.5
SPRING, DRAWN, DRAWN_SECONDS = 300.0, 0.02, 6.0
# Beside a steady pull one that trembles, together below what kinetic friction holds; watched for two seconds.
PULL, TREMBLING, TREMOR = 0.3, 0.15, 20.0
HELD_SECONDS, HELD_FROM = 3.0, 1.0
# It comes to rest by sliding, or a model without rest would start in it.
SLIDES_IN = 0.02


@compiled
def slides(times, model, applied, spring, levels, options, dt, memory, x, v):
    """Fill x, v (n,) from their first values, `times` over; levels are mass, static, kinetic."""
    for _ in range(times):
        stick_slip.run(
            model, applied, levels[0], spring, 0.0, levels[1], levels[2], options, dt, memory, x, v
        )


def trembling(t: np.ndarray) -> np.ndarray:
    """Return the pull in N at the times (n,)."""
    return PULL + TREMBLING * np.sin(2.0 * math.pi * TREMOR * t)


def drift(t: np.ndarray, x: np.ndarray) -> float:
    """Return by how many m/s it creeps on average once it should hold; inf where it is nowhere."""
    begin = int(np.searchsorted(t, HELD_FROM - 1e-9))
    found = abs(float(x[-1] - x[begin])) / float(t[-1] - t[begin])
    return found if math.isfinite(found) else math.inf


@dataclass(frozen=True)
class Trial:
    """One model at one step in one scene."""

    model: str
    dt: float
    held: bool

    @property
    def seconds(self) -> float:
        """Return how long is simulated."""
        return HELD_SECONDS if self.held else DRAWN_SECONDS

    def computed(self, times: int = 1) -> tuple[timing.Work, np.ndarray, np.ndarray, np.ndarray]:
        """Return what computes the trial, its times, applied forces and positions, each (n,)."""
        code, declared = MODELS[self.model]
        options = np.array([*(p.default for p in declared), 0.0])
        t = samples(self.seconds, self.dt)
        applied = trembling(t) if self.held else SPRING * DRAWN * t
        x, v = np.zeros_like(t), np.zeros_like(t)
        v[0] = SLIDES_IN if self.held else 0.0
        levels, memory = np.array([MASS, STATIC, KINETIC]), np.zeros(stick_slip.MEMORY)
        spring = 0.0 if self.held else SPRING
        return (
            (lambda: slides(times, code, applied, spring, levels, options, self.dt, memory, x, v)),
            t,
            applied,
            x,
        )

    def error(self) -> float:
        """Return the drift in m/s, or the share by which the period is off."""
        work, t, applied, x = self.computed()
        work()
        if self.held:
            return drift(t, x)
        return period.error(t, applied - SPRING * x, period.exact(MASS, SPRING, STATIC, KINETIC, DRAWN))

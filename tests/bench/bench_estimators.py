"""Time of one step of every velocity estimator, slow and fast, and of a step of each friction model."""

import numpy as np

from hapkit_studio.dynamics import estimators, stick_slip
from hapkit_studio.dynamics.jit import compiled
from tests.bench.bench_tick import nanoseconds
from tests.bench.frame import Row

NAME = "estimators"
ORDER = 26
STEPS = 20_000
QUANTUM = 20.7e-6


@compiled
def many_steps(code, coefs, memory, positions, period):
    """Estimate the velocity at every position (n,) in m; return their sum, so that none is left out."""
    total = 0.0
    for k in range(positions.size):
        total += estimators.step(code, coefs, memory, positions[k], period)
    return total


def estimator_step(key: str, amplitude: float) -> float:
    """Return ns per step on a counted sine of 1 Hz and an amplitude in m."""
    positions = QUANTUM * np.floor(amplitude * np.sin(2e-3 * np.pi * np.arange(STEPS)) / QUANTUM)
    code, coefs = estimators.design(key, 1000.0, QUANTUM)
    memory = np.zeros(estimators.MEMORY)
    return nanoseconds(lambda: many_steps(code, coefs, memory, positions, 1e-3), STEPS)


def friction_step(model: str) -> float:
    """Return ns per step of a mass drawn by a spring."""

    def draw() -> None:
        stick_slip.stick_slip(
            model, mass=0.05, spring=300.0, static=1.0, kinetic=0.5, speed=0.02, dt=1e-4, seconds=STEPS * 1e-4
        )

    return nanoseconds(draw, STEPS)


def run() -> list[Row]:
    """Return a row an estimator, the slower motion's, which fills the longest window; a row a model."""
    rows = []
    for key in estimators.ESTIMATORS:
        slowest = max(estimator_step(key, amplitude) for amplitude in (2e-4, 2e-2))
        rows.append(Row(f"step of {key}", slowest, "ns"))
    rows += [Row(f"step of stick-slip, {model}", friction_step(model), "ns") for model in stick_slip.MODELS]
    return rows

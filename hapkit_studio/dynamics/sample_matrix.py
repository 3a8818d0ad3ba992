"""The whole loop from one sample to the next as a matrix: handle, hold, delay, estimator and a linear law.

It covers cases beyond the characteristic equation of ``sampled_loop``: laws with state, and varying periods
and delays.
"""

from collections.abc import Callable, Sequence

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.integrators import step
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.dynamics.moving_mass import FAR
from hapkit_studio.dynamics.paddle import apply, transition

Law = Callable[[np.ndarray, float, float, float], tuple[float, Sequence[float]]]
"""A function of the state (k,), position in m, velocity in m/s and elapsed time in s.

It returns the force in N and the next state, and is linear in state, position and velocity.
"""

_ESTIMATOR = 6  # size of the state of a linear estimator; its first value is the last position
_LAW = 2 + _ESTIMATOR  # offset of the law's state, which is followed by the commands, newest first


def spring(stiffness: float, damping: float) -> Law:
    """Return the law of a spring and damper to the ground, which has no state."""
    return lambda memory, x, v, dt: (-stiffness * x - damping * v, ())


COUPLED = 5
"""Size of a coupled object's state: its position, speed and last acceleration, the handle's last x and v."""


def coupled(integrator: float, mass: float, own: tuple[float, float], coupling: tuple[float, float]) -> Law:
    """Return the law of an object that a spring and damper connect to the handle in both directions.

    ``own`` and ``coupling`` contain a stiffness in N/m and a damping in N·s/m each. As in the scenes, the
    object first moves for one period, in which the handle stays at its previous position; then the coupling
    acts.
    """
    (k, b), (contact, pad) = own, coupling

    def force(memory: np.ndarray, x: float, v: float, dt: float) -> tuple[float, Sequence[float]]:
        place, speed, before, handle, handle_speed = memory
        pull = contact * handle + pad * handle_speed
        place, speed, before = step(
            integrator, place, speed, before, dt, 0.0,
            mass, b + pad, k + contact, pull, -FAR, 1.0, 0.0, 0.0, 0.0, FAR, 0.0,
        )  # fmt: skip
        return -contact * (x - place) - pad * (v - speed), (place, speed, before, x, v)

    return force


def without_law(loop: LoopSettings, remembered: int, period: float, late: float) -> np.ndarray:
    """Return the map (n + 1, n) from just after one sample to just after the next, ``period`` s later.

    A command acts ``late`` s after its sample, plus the whole periods of the loop's delay. The state contains
    x, v, the states of estimator and law, and the commands, newest first. Entries for the law are 0. The last
    row is the velocity passed to the law. The virtual damping of the loop is ignored.
    """
    m, c, k = loop.moving_mass, loop.total_viscous, loop.grip_stiffness
    first, second = transition(m, c, k, late), transition(m, c, k, period - late)
    code, coefs = estimators.design(loop.estimator, loop.rate, loop.quantum)
    whole = loop.parted[0]
    size = _LAW + remembered + whole + 2

    def after(state: np.ndarray) -> np.ndarray:
        memory, commands = np.zeros(estimators.MEMORY), state[_LAW + remembered :]
        memory[:_ESTIMATOR] = state[2:_LAW]
        x, v = apply(first, state[0], state[1], commands[whole + 1], 0.0)
        x, v = apply(second, x, v, commands[whole], 0.0)
        velocity = estimators.step(code, coefs, memory, x, period)
        return np.r_[x, v, memory[:_ESTIMATOR], np.zeros(remembered + 1), commands[:-1], velocity]

    return np.column_stack([after(unit) for unit in np.eye(size)])


def sample_matrix(free: np.ndarray, law: Law, remembered: int, period: float) -> np.ndarray:
    """Return the matrix (n, n) of the closed loop over a period in s; ``without_law`` returned ``free``."""
    rows = slice(_LAW, _LAW + remembered)
    felt = np.vstack([np.eye(free.shape[1])[rows], free[0], free[-1]])
    answers = (law(unit[:-2], unit[-2], unit[-1], period) for unit in np.eye(remembered + 2))
    columns = np.column_stack([np.r_[memory, force] for force, memory in answers])
    whole = free[:-1].copy()
    whole[_LAW : _LAW + remembered + 1] = columns @ felt
    return whole


def used(matrices: np.ndarray) -> np.ndarray:
    """Return the maps (n, s, s) without the states that affect no other state."""
    others = matrices * (1.0 - np.eye(matrices.shape[-1]))
    rows = np.flatnonzero((others != 0.0).any(axis=(0, 1)))
    return matrices[:, rows[:, np.newaxis], rows]


def radius(matrix: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())

"""The stability map in NumPy as a reference: all cells at once, with the same handle, loop and rule."""

import numpy as np

from hapkit_studio.analysis.stability import rendered
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import cell_batch


def _glide(
    what: LoopSettings, seconds: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the derivatives of a free handle's final x and v by its initial v and by a constant force.

    They are dx/dv, dv/dv, dx/dforce and dv/dforce after ``seconds``.
    """
    m, b = what.mass, what.viscous
    v_v, v_f = np.exp(-b * seconds / m), -np.expm1(-b * seconds / m) / b
    return m * v_f, v_v, (seconds - m * v_f) / b, v_f


def by_roots(what: LoopSettings, stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Return the classes (n,) of an ideal device without delay, by the eigenvalues of all loops' matrices."""
    x_v, v_v, x_f, v_f = _glide(what, what.period)
    late = damping / what.period
    loops = np.zeros((stiffness.size, 3, 3))  # the state is x, v, and the previous sample's position
    loops[:, 0] = np.column_stack([1.0 - x_f * (stiffness + late), np.full_like(late, x_v), x_f * late])
    loops[:, 1] = np.column_stack([-v_f * (stiffness + late), np.full_like(late, v_v), v_f * late])
    loops[:, 2, 0] = 1.0
    stable = np.abs(np.linalg.eigvals(loops)).max(axis=1) < 1.0
    return np.where(stable, rendered.DECAYS, rendered.GROWS)


def by_steps(what: LoopSettings, stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Return the classes (n,) with friction and sensor steps, without delay; all cells step together."""
    few = rendered.FEW_STEPS * what.quantum
    verdict, quiet = np.zeros(stiffness.size, dtype=np.int8), np.arange(stiffness.size)
    for start in rendered.STARTS:
        found = _let_go(what, stiffness[quiet], damping[quiet], start * what.quantum)
        verdict[quiet] = rendered.by_reach(found, few, held=False, linear=True)
        quiet = quiet[verdict[quiet] == rendered.DECAYS]
    return verdict


def _let_go(
    what: LoopSettings, stiffness: np.ndarray, damping: np.ndarray, start: float
) -> cell_batch.CellResults:
    """Simulate every cell from rest at a start in m, until it diverges or has rested for a while."""
    count = stiffness.size
    found = cell_batch.CellResults(
        np.zeros((count, cell_batch.PARTS, 3)), *np.zeros((2, count), dtype=np.int64)
    )
    left = np.arange(count)
    x, v = np.full(count, start), np.zeros(count)
    seen = what.quantum * np.floor(x / what.quantum)
    for part in range(cell_batch.PARTS):
        low, high, moved = x.copy(), x.copy(), np.zeros(left.size, dtype=bool)
        for _ in range(round(rendered.SECONDS * what.rate / cell_batch.PARTS)):
            before, seen = seen, what.quantum * np.floor(x / what.quantum)
            pull = -stiffness[left] * (seen + 0.5 * what.quantum)
            x, v = _step(what, x, v, pull - damping[left] * (seen - before) / what.period)
            np.minimum(low, x, out=low)
            np.maximum(high, x, out=high)
            moved |= v != 0.0
        found.parts[left, part, cell_batch.LOW], found.parts[left, part, cell_batch.HIGH] = low, high
        lost = np.maximum(-low, high) > rendered.FAR
        found.ends[left[lost]], found.ends[left[~lost & ~moved]] = cell_batch.LEFT_RANGE, cell_batch.SETTLED
        on = moved & ~lost
        left, x, v, seen = left[on], x[on], v[on], seen[on]
    return found


def _step(
    what: LoopSettings, x: np.ndarray, v: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return position and velocity after a period, exactly, because the handle stops at most once."""
    m, b, friction = what.mass, what.viscous, what.coulomb
    x_v, v_v, x_f, v_f = _glide(what, what.period)
    way = np.sign(np.where(v == 0.0, force, v))
    net = force - way * np.where(v == 0.0, np.minimum(friction, np.abs(force)), friction)
    later, speed = x + x_v * v + x_f * net, v_v * v + v_f * net
    stops = np.flatnonzero(speed * v < 0.0)
    after = m / b * np.log1p(-b * v[stops] / net[stops])
    later[stops] = x[stops] + (net[stops] * after + m * v[stops]) / b
    back = force[stops] - np.clip(force[stops], -friction, friction)
    _, _, x_f, v_f = _glide(what, what.period - after)
    later[stops] += x_f * back
    speed[stops] = v_f * back
    return later, speed

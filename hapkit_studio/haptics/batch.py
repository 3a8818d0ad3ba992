"""Headless rendering: the tick and the simulated Hapkit, sample after sample, as fast as they go."""

import math

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.dynamics.jit import compiled, inlined
from hapkit_studio.haptics import block, plant, rig, rows
from hapkit_studio.haptics.fences import load_acquire
from hapkit_studio.haptics.tick import tick


@inlined
def sample(r, body, row, target, after, shown):
    """Fill one row, whose time is set, and move the device on as the hand's target goes on to `after` m.

    shown is the target in the row, nan where no hand holds.
    """
    plant.write_truth(body, shown, row)
    force = tick(r, plant.measure(body), r.block_values[block.PERIOD], body.dev[simulated.EFFECT], row)
    simulated.command(body.dev, body.queue, force)
    simulated.advance(body.dev, body.queue, target, after)


@compiled
def run(r, body, hand, targets, holding, out):
    """Fill one row a sample; return how many were done (fewer only where the run was told to quit).

    hand is mass, damping, stiffness; targets (n + 1,) in m, linear between samples; holding (n,) says
    whether the hand holds from sample k on; out is (n, ROW_WIDTH), row 0 the initial state.
    """
    settings = r.block_values
    period = settings[block.PERIOD]
    for k in range(out.shape[0]):
        if load_acquire(r.control, rig.QUIT):
            return k
        on = holding[k] != 0
        plant.configure(
            body, settings, hand[0] if on else 0.0, hand[1] if on else 0.0, hand[2] if on else 0.0
        )
        row = out[k]
        row[rows.BOARD_TIME] = k * period
        sample(r, body, row, targets[k], targets[k + 1], targets[k] if on else math.nan)
    return out.shape[0]


@compiled
def run_prescribed(r, body, positions, velocities, out):
    """Fill one row a sample of a motion imposed on the handle: positions, velocities (n,) in m, m/s."""
    period = r.block_values[block.PERIOD]
    plant.configure(body, r.block_values, 0.0, 0.0, 0.0)
    for k in range(out.shape[0]):
        body.dev[simulated.X] = positions[k]
        body.dev[simulated.V] = velocities[k]
        row = out[k]
        row[rows.BOARD_TIME] = k * period
        sample(r, body, row, positions[k], positions[k], positions[k])
    return out.shape[0]


def new_rows(count: int) -> np.ndarray:
    """Return room for count rows."""
    return np.zeros((count, rows.ROW_WIDTH))

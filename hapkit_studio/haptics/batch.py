"""Headless rendering: the tick and the simulated Hapkit, sample after sample, as fast as they go."""

import math

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import block, plant, rig, rows
from hapkit_studio.haptics.fences import load_acquire
from hapkit_studio.haptics.tick import tick


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
        plant.write_truth(body, targets[k] if on else math.nan, row)
        row[rows.BOARD_TIME] = k * period
        force = tick(r, plant.measure(body), period, body.dev[simulated.EFFECT], row)
        simulated.command(body.dev, body.queue, force)
        simulated.advance(body.dev, body.queue, targets[k], targets[k + 1])
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
        plant.write_truth(body, positions[k], row)
        row[rows.BOARD_TIME] = k * period
        force = tick(r, plant.measure(body), period, body.dev[simulated.EFFECT], row)
        simulated.command(body.dev, body.queue, force)
        simulated.advance(body.dev, body.queue, positions[k], positions[k])
    return out.shape[0]


def new_rows(count: int) -> np.ndarray:
    """Return room for count rows."""
    return np.zeros((count, rows.ROW_WIDTH))

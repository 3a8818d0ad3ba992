"""Cells rendered one after another in the same memory have exactly the samples of separate headless runs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import GRIPS, Grip, Hand
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import cell_batch, headless, rows

EVERY = cell_batch.Limits(math.inf, cell_batch.NEVER_STILL, cell_batch.NEVER_FAINT, cell_batch.NEVER_SMALL)
PART = 40
# columns: stiffness in N/m, damping in N·s/m, centre in m; the first row diverges, and the second row settles
NUMBERS = np.array([[30_000.0, 0.0, 0.0], [900.0, 4.0, -1e-5], [5000.0, 1.0, 2e-4], [900.0, 4.0, -1e-5]])
STARTS = np.array([1e-3, 4e-3, -2e-3, 4e-3])
SCENES = [
    (SimulatedHapkit(max_force=math.inf), LoopSettings(1000.0, 0.0, "difference"), None),
    (SimulatedHapkit(0.05, 0.2, 0.0, 0.0, math.inf), LoopSettings(2000.0, 1.7e-3, "iir"), GRIPS["medium"]),
    (SimulatedHapkit(0.03, 0.2, 0.3, 1e-5), LoopSettings(500.0, 5.2e-3, "foaw"), GRIPS["light"]),
    (SimulatedHapkit(0.03, 0.2, 0.3, 1e-5), LoopSettings(1000.0, 1e-3, "kalman"), None),
]


def scene_of(device: SimulatedHapkit, loop: LoopSettings, numbers=(0.0, 0.0, 0.0)) -> headless.Scene:
    values = dict(zip(("stiffness", "damping", "center"), numbers, strict=True))
    return headless.Scene(environments.named("spring"), values, device, loop)


def cells(weights: float = 0.0, part: int = PART) -> cell_batch.Cells:
    many = len(STARTS)
    return cell_batch.Cells(NUMBERS, STARTS, np.full(many, part), np.full(many, weights))


def by_batch(device: SimulatedHapkit, loop: LoopSettings, grip: Grip | None, i: int, part=PART) -> np.ndarray:
    """Return the rows of one cell from a headless run, which has its own arrays."""
    hand = Hand(grip.mass, grip.damping, grip.stiffness) if grip else None
    scene = scene_of(replace(device, initial_position=float(STARTS[i])), loop, NUMBERS[i])
    return headless.render(scene, hand, cell_batch.PARTS * part)[0]


@pytest.mark.parametrize(("device", "loop", "grip"), SCENES)
def test_every_run_equals_the_batch_engines_bit_for_bit(device, loop, grip):
    found = cell_batch.run_cells(scene_of(device, loop), grip, cells(123.0), EVERY)
    assert (found.ends == cell_batch.COMPLETED).all()
    for i in range(len(STARTS)):
        out = by_batch(device, loop, grip, i)
        x, v = (out[:, c].reshape(cell_batch.PARTS, PART) for c in (rows.TRUE_POSITION, rows.TRUE_VELOCITY))
        assert (found.parts[i, :, cell_batch.LOW] == x.min(axis=1)).all()
        assert (found.parts[i, :, cell_batch.HIGH] == x.max(axis=1)).all()
        pull = np.diff(v.ravel(), prepend=0.0).reshape(v.shape) * loop.rate
        power = (pull**2 + (123.0 * v) ** 2).sum(axis=1)
        assert found.parts[i, :, cell_batch.POWER] == pytest.approx(power, rel=1e-12)


def render_nothing(r, body, flat, made) -> None:
    """Reset the loop's arrays and the plant to a cell's initial state, without rendering samples."""
    none = cell_batch.Cells(np.zeros((1, 3)), np.zeros(1), np.zeros(1, dtype=np.int64), np.zeros(1))
    found = cell_batch.CellResults(np.zeros((1, cell_batch.PARTS, 3)), *np.zeros((2, 1), dtype=np.int64))
    cell_batch.run(r, body, flat, made, np.zeros(3), none, EVERY, np.zeros(rows.ROW_WIDTH), found)


@pytest.mark.slow
def test_a_reset_loop_equals_a_new_one():
    """After a run with a hand and an over-speed fault, a reset restores the initial state of all arrays."""
    scene = replace(scene_of(*SCENES[2][:2]), max_speed=1e-9)
    r, body, flat = cell_batch.packed(*scene.prepare())
    new, still, new_flat = cell_batch.packed(*scene.prepare())
    made = flat.copy()
    headless.run_batch(r, body, np.array([0.1, 1.0, 9.0]), np.ones(301), np.ones(300), headless.new_rows(300))
    assert r.control.fault[0] != 0
    render_nothing(r, body, flat, made)
    render_nothing(new, still, new_flat, made)
    assert np.array_equal(flat, new_flat)


def test_a_run_that_leaves_the_range_ends():
    limits = EVERY._replace(far=0.05)
    device, loop, grip = SCENES[0]
    found = cell_batch.run_cells(scene_of(device, loop), grip, cells(), limits)
    assert found.ends[0] == cell_batch.LEFT_RANGE
    beyond = np.flatnonzero(np.abs(by_batch(device, loop, grip, 0)[:, rows.TRUE_POSITION]) > 0.05)
    assert found.samples[0] == beyond[0] + 1
    assert (found.parts[0, found.samples[0] // PART + 1 :] == 0.0).all()


def test_a_run_stuck_by_friction_ends_after_a_time_without_motion():
    limits = EVERY._replace(still=50)
    device, loop, grip = SCENES[0]
    found = cell_batch.run_cells(scene_of(device, loop), grip, cells(part=200), limits)
    assert found.ends[1] == cell_batch.SETTLED
    speed = by_batch(device, loop, grip, 1, 200)[:, rows.TRUE_VELOCITY]
    stopped = np.flatnonzero(speed != 0.0)[-1] + 1
    assert found.samples[1] == stopped + 51


def test_runs_that_died_out_or_are_steady_end_early():
    """An undamped free oscillator keeps its amplitude; a damped one loses it."""
    device = SimulatedHapkit(0.05, 0.0, 0.0, 0.0, math.inf)
    # at 50 Hz there are 20 samples per cycle, and 2 cycles per part
    hold = Grip(0.0, 0.0, 0.05 * (2.0 * math.pi * 50.0) ** 2)
    scene = scene_of(device, LoopSettings())
    one = cell_batch.Cells(np.zeros((1, 3)), np.array([1e-4]), np.array([PART]), np.zeros(1))
    found = cell_batch.run_cells(scene, hold, one, EVERY._replace(small=2.1e-4))
    assert (found.ends[0], found.samples[0]) == (cell_batch.STEADY, 3 * PART)
    assert (
        cell_batch.run_cells(scene, hold, one, EVERY._replace(small=1.9e-4)).ends[0] == cell_batch.COMPLETED
    )
    damped = replace(hold, damping=2.0)  # the decay is 20 1/s, so the amplitude falls to e^-0.8 per part
    found = cell_batch.run_cells(scene, damped, one, EVERY._replace(faint=1e-6))
    assert found.ends[0] == cell_batch.DIED_OUT
    assert found.samples[0] == pytest.approx(math.log(100.0) / 20.0 * 1000.0 + PART, abs=PART)

"""The tick, both compiled and interpreted, gives the rows of the same computation in plain numpy."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import config

from hapkit_studio import environments
from hapkit_studio.haptics import rows
from tests.haptics.support import CONSTANT, COUNTING, LoopHarness

WALL = environments.named("wall")
RATE = 1000.0
QUANTUM = 20.7e-6


def motion(seed=1, count=400):
    """Return measured positions in m of a motion in and out of a wall at 5 mm."""
    steps = np.random.default_rng(seed).normal(0.0, 2e-4, count)
    x = 0.005 + 0.002 * np.sin(np.arange(count) / 40.0) + np.cumsum(steps) * 0.1
    return QUANTUM * np.floor(x / QUANTUM)


def wall_force(x, v, stiffness, damping):
    depth = x - 0.005
    inward = np.maximum(v, 0.0)
    return np.where(depth > 0.0, -(stiffness * depth + damping * inward), 0.0)


def test_rows_agree_with_the_chain():
    x, effects = motion(), np.random.default_rng(2).normal(0.0, 1.0, 400)
    out = LoopHarness(WALL, {"stiffness": 600.0, "damping": 3.0}, max_force=1.0).run(x, effects)
    moved = np.diff(x, prepend=x[0])
    velocity = moved * RATE
    asked = wall_force(x, velocity, 600.0, 3.0)
    np.testing.assert_array_equal(out[:, rows.TICK], np.arange(400))
    np.testing.assert_array_equal(out[:, rows.POSITION], x)
    np.testing.assert_allclose(out[:, rows.VELOCITY], velocity, rtol=1e-12)
    np.testing.assert_allclose(out[:, rows.FORCE], asked, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(out[:, rows.APPLIED_FORCE], np.clip(asked, -1.0, 1.0), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(out[:, rows.ENERGY], np.cumsum(effects * moved), rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(out[:, rows.PERIOD], 1.0 / RATE)
    clamped = np.where(np.abs(asked) > 1.0, rows.CLAMPED, 0)
    # the flag ACTIVE is ignored; it is set, because these forces deliver energy that no law has stored
    flags = out[:, rows.FLAGS].astype(int) & ~rows.ACTIVE
    np.testing.assert_array_equal(flags, clamped)
    assert 0 < np.count_nonzero(clamped) < 400


def test_the_state_is_in_the_row_until_its_law_is_replaced():
    harness = LoopHarness(COUNTING)
    out = harness.ticks(0.003)
    np.testing.assert_array_equal(out[:, rows.STATE], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(out[:, rows.STATE + 1], [7.0, 9.0, 11.0])
    harness.set(CONSTANT)
    row = harness.tick()
    assert not row[rows.STATE :].any()


def test_a_live_start_fades_in():
    out = LoopHarness(CONSTANT, full=False).ticks(0.032)
    np.testing.assert_allclose(out[:30, rows.APPLIED_FORCE], np.arange(1, 31) / 30.0, rtol=1e-12)
    np.testing.assert_array_equal(out[:29, rows.FLAGS], rows.FADING)
    np.testing.assert_array_equal(out[29:, rows.APPLIED_FORCE], 1.0)
    np.testing.assert_array_equal(out[29:, rows.FLAGS], 0)


@pytest.mark.slow
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="this is the interpreted run")
def test_the_tick_runs_interpreted():
    here = Path(__file__)
    names = [here, here.with_name("test_transitions.py"), here.with_name("test_safety.py")]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *map(str, names)]
    command += ["-k", "not live and not random and not simulate and not energy"]
    done = subprocess.run(
        command,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        cwd=here.parents[2],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert " passed" in done.stdout

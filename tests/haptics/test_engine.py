"""The live loop on the simulated device: it renders what headless renders, and nothing stops or blocks it."""

import gc
import statistics
import time

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, headless, rows
from hapkit_studio.haptics.engine import Engine
from tests.haptics.engine_support import read, rest
from tests.haptics.support import slow_environment
from tests.waiting import wait_until

HOST = [rows.HOST_TIME, rows.BOARD_TIME, rows.LATENESS, rows.COMPUTE]
SPRING = environments.named("spring")


# --- the same as headless
def test_live_rows_are_those_of_headless_bit_for_bit():
    device = SimulatedHapkit(initial_position=0.012)
    engine = Engine(device, SPRING, realtime=False)
    engine.set_environment(SPRING, {"stiffness": 300.0, "damping": 1.0})
    engine.set_loop(rate=2000.0, delay=0.0007, estimator=("iir", {"cutoff": 60.0}))
    reader = engine.reader()
    engine.start()
    live = read(reader, lambda found: len(found) >= 600)[:600]
    loop, values = engine.loop, engine.values
    engine.close()
    r, body = headless.Scene(SPRING, values, device, loop).prepare()
    r.real[arrays.GAIN] = 0.0
    out = headless.new_rows(600)
    headless.run_batch(r, body, np.zeros(3), np.zeros(601), np.zeros(600, dtype=np.int64), out)
    same = [c for c in range(rows.ROW_WIDTH) if c not in HOST]
    np.testing.assert_array_equal(live[:, same], out[:, same])
    np.testing.assert_allclose(live[:, rows.BOARD_TIME], out[:, rows.BOARD_TIME], atol=1e-12)
    assert np.abs(live[:, rows.APPLIED]).max() > 1.0


def test_the_rate_changes_while_it_runs(started):
    engine = started(environment="damping")
    reader = engine.reader()
    engine.set_parameter("damping", 5.0)
    engine.set_grip("firm")
    found = []
    for k, rate in enumerate((100.0, 10_000.0, 300.0, 10_000.0, 100.0, 1000.0)):
        engine.move_hand(0.03 * (-1) ** k)
        engine.set_loop(rate=rate)
        found.append(read(reader, lambda out, T=1.0 / rate: np.count_nonzero(out[:, rows.PERIOD] == T) > 15))
        assert reader.lost == 0
    out = np.concatenate(found)
    np.testing.assert_allclose(np.diff(out[:, rows.BOARD_TIME]), out[1:, rows.PERIOD], rtol=1e-6)
    np.testing.assert_array_equal(np.diff(out[:, rows.TICK]), 1.0)
    speed = np.diff(out[:, rows.POSITION]) / out[1:, rows.PERIOD]
    np.testing.assert_allclose(out[1:, rows.VELOCITY], speed, rtol=1e-9, atol=1e-12)
    mean = np.diff(out[:, rows.TRUE_POSITION]) / np.diff(out[:, rows.BOARD_TIME])
    quantum = SimulatedHapkit().quantum
    assert np.all(np.abs(out[1:, rows.VELOCITY] - mean) <= 1.01 * quantum / out[1:, rows.PERIOD])
    assert engine.fault is None
    assert np.abs(mean).max() > 0.05


# --- nothing waits, nothing breaks
def test_no_call_blocks_while_it_runs(started):
    engine = started()
    reader = engine.reader()
    engine.set_environment("spring")
    calls = (
        lambda k: engine.set_parameter("stiffness", 100.0 + k),
        lambda k: engine.set_environment(("wall", "spring")[k % 2]),
        lambda k: engine.set_loop(rate=1000.0 + k, delay=1e-4 * k),
        lambda k: engine.move_hand(1e-4 * k),
        lambda k: engine.set_grip(("light", "firm")[k % 2]),
        lambda k: engine.stop(),
        lambda k: engine.release_stop(),
        lambda k: engine.clear_fault(),
        lambda k: engine.health(),
        lambda k: reader.read(),
        lambda k: engine.fault,
    )
    for call in calls:
        engine.set_environment("wall")
        call(1)
        took = []
        for k in range(20):
            start = time.perf_counter()
            call(k)
            took.append(time.perf_counter() - start)
            engine.set_environment("wall")
        assert statistics.median(took) < 0.005


def test_bad_settings_leave_the_last_good_ones(started):
    engine = started(environment="wall")
    reader = engine.reader()
    engine.set_parameter("stiffness", 400.0)
    engine.move_hand(0.012)
    before = engine.values, engine.loop, engine.grip
    for bad in (
        lambda: engine.set_parameter("stiffness", float("nan")),
        lambda: engine.set_parameter("stiffness", 1e9),
        lambda: engine.set_parameter("nothing", 1.0),
        lambda: engine.set_environment("nowhere"),
        lambda: engine.set_environment("wall", {"side": "up"}),
        lambda: engine.set_loop(rate=0.0),
        lambda: engine.set_loop(delay=float("inf")),
        lambda: engine.set_loop(estimator="guess"),
        lambda: engine.set_grip("iron"),
        lambda: engine.move_hand(float("nan")),
    ):
        with pytest.raises(ParameterError):
            bad()
    assert (engine.values, engine.loop, engine.grip) == before
    read(reader, lambda found: found[-1, rows.POSITION] > 0.006)
    out = rest(reader, 100)
    depth = np.maximum(out[:, rows.POSITION] - 0.005, 0.0)
    np.testing.assert_allclose(out[50:, rows.ASKED], -400.0 * depth[50:], rtol=1e-9)


def test_rows_go_on_under_garbage_collection(started):
    engine = started()
    reader = engine.reader()
    for _ in range(5):
        gc.collect()
        engine.set_environment("spring")
        rest(reader, 30)
        engine.set_environment("wall")
    assert engine.fault is None
    assert len(engine._writer.kept_laws) <= 2


def test_missed_ticks_are_counted_and_a_law_that_takes_too_long_stops_pushing(started):
    engine = started(environment=slow_environment())
    reader = engine.reader()
    engine.set_loop(rate=10_000.0)
    wait_until(lambda: engine.fault is not None)
    assert engine.fault.code == arrays.SLOW_LAW
    assert engine.fault.text.endswith(" ms, a period 0.10 ms.")
    missed = engine.health().missed
    assert missed > 50
    out = rest(reader, 10)
    assert not out[:, rows.APPLIED].any()
    assert np.all(out[:, rows.FLAGS].astype(int) & rows.FAULT)
    engine.set_environment("wall")
    engine.set_loop(rate=200.0)
    rest(reader, 10)
    engine.clear_fault()
    read(reader, lambda found: found[-1, rows.FLAGS] == 0)
    assert engine.fault is None


def test_lateness_is_counted_for_every_row(started):
    engine = started()
    reader = engine.reader()
    rest(reader, 50)
    engine.close()
    assert int(engine.lateness_bins.sum()) == int(engine.arrays.control[arrays.HEAD])


def test_says_whose_state_the_rows_hold():
    """Nobody's before the loop runs; after a switch the new environment's, from the tick that took it."""
    engine = Engine(SimulatedHapkit(), "wall", realtime=False)
    wall, button = environments.named("wall"), environments.named("button")
    assert not engine.renders(wall)
    engine.start()
    try:
        wait_until(lambda: engine.renders(wall))
        engine.set_environment("button")
        assert not engine.renders(wall)
        wait_until(lambda: engine.renders(button))
    finally:
        engine.close()

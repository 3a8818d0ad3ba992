"""Tests of the engine: settings, start and end, and its rows."""

import gc
import math
import os
import statistics
import threading
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import ARRIVES, Hand, grip_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, headless, rows
from hapkit_studio.haptics.engine import Engine
from tests.haptics.support import CONSTANT, COUNTING, loop_threads, read, rest, slow_environment
from tests.waiting import wait_until

HOST = [rows.HOST_TIME, rows.BOARD_TIME, rows.LATENESS, rows.COMPUTE]
SPRING = environments.named("spring")


def test_the_rate_can_change_while_it_runs(started):
    engine = started(environment="damping")
    reader = engine.reader()
    engine.set_parameter("damping", 5.0)
    engine.set_loop(hand="firm")
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


# --- calls never wait
@pytest.mark.alone
def test_no_call_blocks_while_it_runs(started):
    """At least half of twenty calls take less than a period of the loop at 200 Hz."""
    engine = started()
    reader = engine.reader()
    engine.set_environment("spring")
    engine.set_loop(rate=200.0)
    control = engine.arrays.control
    calls = (
        lambda k: engine.set_parameter("stiffness", 100.0 + k),
        lambda k: engine.set_environment(("wall", "spring")[k % 2]),
        lambda k: engine.set_loop(rate=200.0, delay=1e-4 * k),
        lambda k: engine.move_hand(1e-4 * k),
        lambda k: engine.set_loop(hand=("light", "firm")[k % 2]),
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
        ticks = []
        for k in range(20):
            before = control.head[0]
            call(k)
            ticks.append(control.head[0] - before)
            engine.set_environment("wall")
        assert statistics.median(ticks) == 0


BAD_LOOP = ("rate", 0.0), ("delay", math.inf), ("estimator", "guess"), ("hand", "iron")


def test_invalid_settings_leave_the_last_valid_ones(started):
    engine = started(environment="wall")
    reader = engine.reader()
    engine.set_parameter("stiffness", 400.0)
    engine.move_hand(0.012)
    before = engine.values, engine.loop, engine.grip
    for bad, *given in (
        (engine.set_parameter, "stiffness", math.nan),
        (engine.set_parameter, "stiffness", 1e9),
        (engine.set_parameter, "nothing", 1.0),
        (engine.set_environment, "nowhere"),
        (engine.set_environment, "wall", {"side": "up"}),
        *((lambda key, value: engine.set_loop(**{key: value}), *bad) for bad in BAD_LOOP),
        (engine.move_hand, math.nan),
    ):
        with pytest.raises(ParameterError):
            bad(*given)
    assert (engine.values, engine.loop, engine.grip) == before
    read(reader, lambda found: found[-1, rows.POSITION] > 0.006)
    out = rest(reader, 100)
    depth = np.maximum(out[:, rows.POSITION] - 0.005, 0.0)
    np.testing.assert_allclose(out[50:, rows.FORCE], -400.0 * depth[50:], rtol=1e-9)


def test_missed_ticks_are_counted_and_a_law_that_takes_too_long_gives_no_force(started):
    engine = started(environment=slow_environment())
    reader = engine.reader()
    engine.set_loop(rate=10_000.0)
    wait_until(lambda: engine.fault is not None)
    assert engine.fault.code == arrays.SLOW_LAW
    assert engine.fault.text.endswith(" ms, but the period is 0.1 ms.")
    assert engine.health().missed > 0
    out = rest(reader, 10)
    assert not out[:, rows.APPLIED_FORCE].any()
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
    assert int(engine.lateness_bins.sum()) == int(engine.arrays.control.head[0])


def test_it_knows_whose_state_the_rows_contain():
    """Before the loop runs, the rows belong to no environment.

    After a switch, the rows belong to the new environment from the tick on that adopts the switch.
    """
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


# --- stopping
def test_the_stop_discards_delayed_forces(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    engine.set_loop(delay=0.1)
    read(reader, lambda found: np.count_nonzero(found[:, rows.APPLIED_FORCE]) > 150)
    body = engine.driver.body
    assert body.queue.any()
    engine.stop()
    read(reader, lambda found: found[-1, rows.FLAGS] == rows.STOPPED)
    assert not body.queue.any()
    energy = rest(reader, 5)[:, rows.ENERGY]
    assert np.all(energy == energy[0])


def test_the_stop_survives_a_change_of_device_until_it_is_released(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    read(reader, lambda found: found[-1, rows.APPLIED_FORCE] == 1.0)
    engine.stop()
    read(reader, lambda found: found[-1, rows.FLAGS] == rows.STOPPED)
    engine.use(SimulatedHapkit(max_force=2.0))
    assert engine.stopped
    engine.clear_fault()
    engine.set_environment(CONSTANT, {"level": 0.5})
    out = rest(reader, 50)
    assert not out[:, rows.APPLIED_FORCE].any()
    assert reader.lost == 0
    engine.release_stop()
    out = read(reader, lambda found: found[-1, rows.APPLIED_FORCE] == 0.5)
    back = out[np.flatnonzero(out[:, rows.APPLIED_FORCE])[0] :, rows.APPLIED_FORCE]
    np.testing.assert_allclose(back[:30], 0.5 * np.arange(1, 31) / 30.0, rtol=1e-9)


def test_closing_sends_a_zero_command_last(started):
    engine = started(environment=CONSTANT)
    read(engine.reader(), lambda found: found[-1, rows.APPLIED_FORCE] == 1.0)
    body = engine.driver.body
    engine.close()
    assert not body.queue.any()
    assert engine.arrays.control.done[0] == 1
    assert not loop_threads()


def test_over_speed_latches_with_the_reason(started):
    engine = started(SimulatedHapkit(initial_velocity=4.0, damping=0.0, coulomb_force=0.0))
    wait_until(lambda: engine.fault is not None)
    assert engine.fault.text == "Fault: the handle moved too fast, 4.0 m/s (limit 3.0 m/s)."


# --- start and end
def test_the_loops_thread_has_a_name(started):
    engine = started()
    assert len(loop_threads()) == 1
    assert engine.health().running
    engine.start()
    assert len(loop_threads()) == 1
    engine.close()
    assert not engine.health().running


@pytest.mark.slow
def test_starting_and_closing_leaks_nothing():
    def life():
        engine = Engine(SimulatedHapkit(), realtime=True)
        engine.start()
        read(engine.reader(), lambda found: len(found) > 2)
        engine.close()

    life()
    gc.collect()
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    for _ in range(20):
        life()
    gc.collect()
    assert threading.active_count() == threads
    assert len(os.listdir("/proc/self/fd")) == files


def test_a_hand_holds_and_releases_the_handle(started):
    engine = started(environment="free")
    reader = engine.reader()
    rest(reader, 2)
    engine.set_loop(hand="firm")
    engine.move_hand(0.02)
    out = read(reader, lambda found: found[-1, rows.TRUE_POSITION] > 0.0197)
    held = out[~np.isnan(out[:, rows.HAND_TARGET])]
    steps = np.diff(held[:, rows.HAND_TARGET], prepend=0.0)
    np.testing.assert_allclose(steps[:100], 1e-3 * ARRIVES, rtol=1e-9)
    assert np.all(np.abs(steps) <= steps[0] * (1.0 + 1e-9))
    engine.move_hand(None)
    out = read(reader, lambda found: np.isnan(found[-1, rows.HAND_TARGET]))
    assert out[-1, rows.HAND_FORCE] == 0.0


def test_laws_in_use_stay_alive(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    for environment in (COUNTING, CONSTANT, COUNTING):
        engine.set_environment(environment)
        in_use = int(engine.arrays.laws[engine.arrays.tick.slot])
        assert in_use in engine.retained_laws
        rest(reader, 100)
    engine.set_parameter("gain", 0.01)
    rest(reader, 40)
    engine.set_parameter("gain", 0.02)
    assert list(engine.retained_laws) == [COUNTING.force.compiled().address]


START = SimulatedHapkit(initial_position=0.0121, initial_velocity=0.1)


def rendered(environment, device, count, loop):
    """Return the rows of a released handle whose force fades in as in a live loop."""
    r, body = headless.Scene(environment, environment.values(), device, loop).prepare()
    r.tick.gain = 0.0
    out = headless.new_rows(count)
    headless.run_batch(r, body, np.zeros(3), np.zeros(count + 1), np.zeros(count, dtype=np.int64), out)
    return out


def live(environment, device, count, **loop):
    """Return the first rows of a live loop."""
    engine = Engine(device, environment, realtime=False)
    engine.set_loop(**loop)
    reader = engine.reader()
    engine.start()
    found = read(reader, lambda found: len(found) >= count)[:count]
    engine.close()
    return found


def same(a, b):
    columns = [c for c in range(rows.ROW_WIDTH) if c not in HOST]
    return np.array_equal(a[:, columns], b[:, columns], equal_nan=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("needs", "rate", "delay", "estimator"),
    [
        ((), 1000.0, 0.0, "difference"),
        (("coulomb", "delay"), 1000.0, 0.0, "difference"),
        (("quantization", "filter"), 2000.0, 0.0007, "iir"),
        (("mass", "viscous"), 2000.0, 0.0007, "foaw"),
    ],
)
def test_a_live_loop_equals_the_reduced_device_bit_for_bit(needs, rate, delay, estimator):
    scene, loop = replace(SPRING, needs=needs), LoopSettings(rate, delay, estimator)
    found = live(scene, START, 300, rate=rate, delay=delay, estimator=estimator)
    assert same(found, rendered(scene, START.reduced(needs), 300, loop))
    assert same(found, rendered(scene, START, 300, loop)) != bool(needs)
    np.testing.assert_allclose(found[:, rows.BOARD_TIME], np.arange(300) / rate, atol=1e-12)


def test_a_user_can_have_every_term(started):
    engine = started(environment=replace(SPRING, needs=("mass",)))
    assert engine.loop.model == "scene"
    assert engine.modelled == SimulatedHapkit(damping=0.0, coulomb_force=0.0)
    engine.set_loop(model="everything")
    assert engine.modelled == SimulatedHapkit()
    reader = engine.reader()
    engine.move_hand(0.0123)
    # friction stops the handle within 0.36 mm of its rest position, depending on its path
    found = read(reader, lambda found: abs(found[-1, rows.TRUE_POSITION] - 0.0088) < 4e-4)
    counts = found[-1, rows.POSITION] / 20.7e-6
    assert counts == pytest.approx(round(counts), abs=1e-6)
    engine.set_loop(
        model="scene"
    )  # without friction the handle rests where hand and spring balance, within a sensor step
    hand, spring = grip_named(engine.grip).stiffness, SPRING.values()["stiffness"]
    balance = 0.0123 * hand / (hand + spring)
    read(reader, lambda found: np.ptp(found[-400:, rows.TRUE_POSITION]) < 1e-9)
    found = read(reader, lambda found: abs(found[-1, rows.TRUE_POSITION] - balance) < 20.7e-6)
    assert found[-1, rows.POSITION] != found[-1, rows.TRUE_POSITION]
    engine.set_environment(CONSTANT)
    assert engine.modelled == SimulatedHapkit()
    with pytest.raises(
        ParameterError, match="Model must be one of scene, everything, frictionless, not 'all'"
    ):
        engine.set_loop(model="all")


def test_at_other_parameters_every_term_is_modelled(started):
    engine = started(environment=replace(SPRING, needs=("mass", "viscous")))
    usual = SPRING.values()
    for values, friction in ((usual, 0.0), ({**usual, "stiffness": 100.0}, 0.10), (usual, 0.0)):
        engine.set_environment(engine.environment, values)
        assert engine.modelled.coulomb_force == friction


def test_a_change_of_model_causes_no_motion(started):
    """A handle stuck by friction between two sensor steps does not move while its damping is switched."""
    place = 20.7e-6 * 100.6
    level, where = CONSTANT.parameters
    gentle = (replace(level, default=0.05), where)
    scene = replace(CONSTANT, needs=("mass", "coulomb"), parameters=gentle)
    engine = started(SimulatedHapkit(initial_position=place), environment=scene)
    reader = engine.reader()
    found = []
    for _ in range(4):
        for model in ("everything", "scene"):
            engine.set_loop(model=model)
            found.append(rest(reader, 50))
    out = np.concatenate(found)
    np.testing.assert_array_equal(out[:, rows.TRUE_POSITION], place)
    np.testing.assert_array_equal(out[:, rows.VELOCITY], 0.0)
    np.testing.assert_array_equal(out[:, rows.ENERGY], 0.0)
    assert out[-1, rows.APPLIED_FORCE] == 0.05


# --- a device without some terms
def test_a_device_without_terms_has_none_of_their_effects():
    device = SimulatedHapkit(mass=0.05, max_force=2.0, initial_position=0.01)
    assert device.without(()) == device
    assert device.without(["viscous"]) == replace(device, damping=0.0)
    assert device.without(["saturation", "sampling", "delay", "filter"]) == replace(
        device, max_force=math.inf
    )
    assert device.without(["mass"]).mass < 1e-9
    assert device.reduced(["coulomb", "delay"]) == replace(device, damping=0.0)
    assert device.reduced(["mass"]).max_force == 2.0
    assert device.reduced(()) == device
    for wrong in (["friction"], ["viscous", ""]):
        with pytest.raises(
            ParameterError, match=r"A modelled device property must be one of mass, viscous, .*filter, not"
        ):
            device.reduced(wrong)


def test_the_true_velocity_is_the_paddles():
    hand = Hand(0.05, 4.0, 200.0, lambda t: 0.02 * math.sin(9.0 * t))
    damping = environments.named("damping")
    scene = headless.Scene(damping, damping.values(), loop=LoopSettings(estimator="iir"))
    out, _ = headless.render(replace(scene, true_velocity=True), hand, 400)
    np.testing.assert_array_equal(out[:, rows.VELOCITY], out[:, rows.TRUE_VELOCITY])
    np.testing.assert_allclose(out[:, rows.FORCE], -4.0 * out[:, rows.TRUE_VELOCITY], rtol=1e-12)
    assert not np.array_equal(headless.render(scene, hand, 400)[0][:, rows.VELOCITY], out[:, rows.VELOCITY])

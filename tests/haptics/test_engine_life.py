"""How the live loop starts, stops, changes its device and ends: nothing pushes on, nothing is left behind."""

import gc
import os
import threading

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.haptics import arrays, rows, simulated_loop
from hapkit_studio.haptics.engine import Engine
from tests.haptics.engine_support import loop_threads, read, rest
from tests.haptics.support import CONSTANT, COUNTING
from tests.waiting import wait_until


# --- stopping
def test_the_stop_drops_forces_on_their_way(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    engine.set_loop(delay=0.1)
    read(reader, lambda found: np.count_nonzero(found[:, rows.APPLIED]) > 150)
    body = engine._driver.body
    assert body.queue.any()
    engine.stop()
    read(reader, lambda found: found[-1, rows.FLAGS] == rows.STOPPED)
    assert not body.queue.any()
    energy = rest(reader, 5)[:, rows.ENERGY]
    assert np.all(energy == energy[0])


def test_the_stop_survives_another_device_and_is_released_on_purpose(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    read(reader, lambda found: found[-1, rows.APPLIED] == 1.0)
    engine.stop()
    read(reader, lambda found: found[-1, rows.FLAGS] == rows.STOPPED)
    engine.use(SimulatedHapkit(max_force=2.0))
    assert engine.stopped
    engine.clear_fault()
    engine.set_environment(CONSTANT, {"level": 0.5})
    out = rest(reader, 50)
    assert not out[:, rows.APPLIED].any()
    assert reader.lost == 0
    engine.release_stop()
    out = read(reader, lambda found: found[-1, rows.APPLIED] == 0.5)
    back = out[np.flatnonzero(out[:, rows.APPLIED])[0] :, rows.APPLIED]
    np.testing.assert_allclose(back[:30], 0.5 * np.arange(1, 31) / 30.0, rtol=1e-9)


def test_a_latched_fault_survives_another_device(started):
    engine = started(environment=CONSTANT)
    engine.arrays.control[arrays.FAULT] = arrays.OVER_SPEED
    engine.use(SimulatedHapkit())
    assert engine.fault.code == arrays.OVER_SPEED


def test_closing_leaves_a_zero_command(started):
    engine = started(environment=CONSTANT)
    read(engine.reader(), lambda found: found[-1, rows.APPLIED] == 1.0)
    body = engine._driver.body
    engine.close()
    assert not body.queue.any()
    assert engine.arrays.control[arrays.DONE] == 1
    assert not loop_threads()


def test_an_escape_latches_over_speed_with_the_reason(started):
    engine = started(SimulatedHapkit(initial_velocity=4.0, damping=0.0, coulomb_force=0.0))
    wait_until(lambda: engine.fault is not None)
    assert engine.fault.text == "Fault: over-speed, 4.0 m/s (limit 3.0 m/s)."


# --- life
def test_the_loop_has_a_thread_with_a_name(started):
    engine = started()
    assert len(loop_threads()) == 1
    assert engine.health().running
    assert engine.health().connected
    engine.start()
    assert len(loop_threads()) == 1
    engine.close()
    assert not engine.health().running


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


def test_a_hand_holds_the_handle_and_lets_go(started):
    engine = started(environment="free")
    reader = engine.reader()
    rest(reader, 2)
    engine.set_grip("firm")
    engine.move_hand(0.02)
    out = read(reader, lambda found: found[-1, rows.TRUE_POSITION] > 0.0197)
    held = out[~np.isnan(out[:, rows.HAND_TARGET])]
    steps = np.diff(held[:, rows.HAND_TARGET], prepend=0.0)
    np.testing.assert_allclose(steps[0], -0.02 * np.expm1(-1e-3 / simulated_loop.POINTER_SECONDS), rtol=1e-6)
    assert np.all(np.abs(steps) <= steps[0])
    engine.move_hand(None)
    out = read(reader, lambda found: np.isnan(found[-1, rows.HAND_TARGET]))
    assert out[-1, rows.HAND_FORCE] == 0.0


def test_laws_in_use_are_kept_alive(started):
    engine = started(environment=CONSTANT)
    reader = engine.reader()
    for environment in (COUNTING, CONSTANT, COUNTING):
        engine.set_environment(environment)
        in_use = int(engine.arrays.laws[engine.arrays.word[arrays.SLOT]])
        assert in_use in engine._writer.kept_laws
        rest(reader, 100)
    engine.set_parameter("gain", 0.01)
    rest(reader, 40)
    engine.set_parameter("gain", 0.02)
    assert list(engine._writer.kept_laws) == [COUNTING.force.compiled().address]

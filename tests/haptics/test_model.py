"""What the live loop models: the terms its scene needs, or everything; nothing jumps in between."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, headless, rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.settings_writer import LoopSettings
from tests.haptics.engine_support import read, rest
from tests.haptics.support import CONSTANT

SPRING = environments.named("spring")
HOST = [rows.HOST_TIME, rows.BOARD_TIME, rows.LATENESS, rows.COMPUTE]
START = SimulatedHapkit(initial_position=0.0121, initial_velocity=0.1)


def rendered(environment, device, count, loop=None):
    """Return the rows of a released handle, the force fading in as in a live loop."""
    r, body = headless.Scene(environment, environment.values(), device, loop or LoopSettings()).prepare()
    r.real[arrays.GAIN] = 0.0
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


@pytest.mark.parametrize(
    "needs", [(), ("mass",), ("viscous",), ("coulomb", "delay"), ("quantization", "filter"), tuple(TERMS)]
)
def test_a_live_loop_is_what_the_reduced_device_gives_bit_for_bit(needs):
    scene = replace(SPRING, needs=needs)
    found = live(scene, START, 300)
    assert same(found, rendered(scene, START.reduced(needs), 300))
    everything = not needs or len(needs) == len(TERMS)
    assert same(found, rendered(scene, START, 300)) is everything


@pytest.mark.parametrize("estimator", ["iir", "butterworth", "foaw", "kalman"])
def test_with_an_ideal_sensor_every_estimator_is_the_same_live(estimator):
    scene = replace(SPRING, needs=("mass", "viscous"))
    loop = LoopSettings(2000.0, 0.0007, estimator)
    found = live(scene, START, 300, rate=2000.0, delay=0.0007, estimator=estimator)
    assert same(found, rendered(scene, START.reduced(scene.needs), 300, loop))
    assert np.isfinite(found[:, rows.VELOCITY]).all()


def test_a_person_can_have_everything(started):
    engine = started(environment=replace(SPRING, needs=("mass",)))
    assert engine.model == "scene"
    assert engine.modelled == SimulatedHapkit(damping=0.0, coulomb_force=0.0, quantum=0.0)
    engine.set_model("everything")
    assert engine.modelled == SimulatedHapkit()
    reader = engine.reader()
    engine.move_hand(0.0123)
    # friction holds it within 0.36 mm of its rest, where depends on its way there
    found = read(reader, lambda found: abs(found[-1, rows.TRUE_POSITION] - 0.0088) < 4e-4)
    counts = found[-1, rows.POSITION] / 20.7e-6
    assert counts == pytest.approx(round(counts), abs=1e-6)
    assert found[-1, rows.POSITION] != found[-1, rows.TRUE_POSITION]
    engine.set_model("scene")
    read(reader, lambda found: found[-1, rows.POSITION] == found[-1, rows.TRUE_POSITION])
    with pytest.raises(ParameterError, match="The model is one of scene, everything, not 'all'"):
        engine.set_model("all")


def test_the_model_follows_the_environment(started):
    engine = started(environment=replace(SPRING, needs=("mass",)))
    assert engine.modelled.viscous == 0.0
    engine.set_environment(replace(SPRING, needs=("viscous",)))
    assert engine.modelled == SimulatedHapkit(coulomb_force=0.0, quantum=0.0)
    engine.set_environment(CONSTANT)
    assert engine.modelled == SimulatedHapkit()


def test_a_change_of_model_moves_nothing(started):
    """A resting handle between two sensor steps: no velocity, no energy while its sensor comes and goes."""
    place = 20.7e-6 * 100.6
    level, where = CONSTANT.parameters
    gentle = (replace(level, default=0.05), where)
    scene = replace(CONSTANT, needs=("mass", "coulomb"), parameters=gentle)
    engine = started(SimulatedHapkit(initial_position=place), environment=scene)
    reader = engine.reader()
    found = []
    for _ in range(4):
        for model in ("everything", "scene"):
            engine.set_model(model)
            found.append(rest(reader, 50))
    out = np.concatenate(found)
    assert len(np.unique(out[:, rows.POSITION])) == 2
    np.testing.assert_array_equal(out[:, rows.TRUE_POSITION], place)
    np.testing.assert_array_equal(out[:, rows.VELOCITY], 0.0)
    np.testing.assert_array_equal(out[:, rows.ENERGY], 0.0)
    assert out[-1, rows.APPLIED] == 0.05


def test_friction_that_comes_and_goes_keeps_the_motion(started):
    engine = started(environment=replace(SPRING, needs=("mass", "quantization")))
    reader = engine.reader()
    found = []
    for k, model in enumerate(("everything", "scene") * 6):
        engine.move_hand(0.02 * (-1) ** (k // 2))
        engine.set_model(model)
        found.append(read(reader, lambda found: len(found) >= 30))
    out = np.concatenate(found)
    np.testing.assert_array_equal(np.diff(out[:, rows.TICK]), 1.0)
    moved, speed = np.diff(out[:, rows.TRUE_POSITION]), out[:, rows.TRUE_VELOCITY]
    mean = 0.5 * (speed[1:] + speed[:-1]) * out[1:, rows.PERIOD]
    np.testing.assert_allclose(moved, mean, atol=2e-6)
    # what hand, motor and friction can do to the masses of handle and hand within a period
    pull = np.abs(out[:, rows.HAND_FORCE]).max() + 3.0 + 0.5 * np.abs(speed).max() + 0.1
    assert np.abs(np.diff(speed)).max() < pull / 0.094 * 1e-3
    assert np.abs(speed).max() > 0.05


# --- the device without some of its terms
def test_a_device_without_terms():
    device = SimulatedHapkit(mass=0.05, max_force=2.0, initial_position=0.01)
    assert device.without(()) == device
    assert device.without(["viscous"]) == replace(device, damping=0.0)
    assert device.without(["saturation", "sampling", "delay", "filter"]) == replace(
        device, max_force=math.inf
    )
    assert device.without(["mass"]).mass < 1e-9
    assert device.reduced(["coulomb", "delay"]) == replace(device, damping=0.0, quantum=0.0)
    assert device.reduced(["mass"]).max_force == 2.0
    assert device.reduced(()) == device
    for wrong in (["friction"], ["viscous", ""]):
        with pytest.raises(ParameterError, match=r"A modelled term is one of mass, viscous, .*filter, not"):
            device.reduced(wrong)


def test_true_velocity_is_the_paddles_own():
    hand = Hand(0.05, 4.0, 200.0, lambda t: 0.02 * math.sin(9.0 * t))
    damping = environments.named("damping")
    scene = headless.Scene(damping, damping.values(), loop=LoopSettings(estimator="iir"))
    out, _ = headless.render(replace(scene, true_velocity=True), hand, 400)
    np.testing.assert_array_equal(out[:, rows.VELOCITY], out[:, rows.TRUE_VELOCITY])
    np.testing.assert_allclose(out[:, rows.ASKED], -4.0 * out[:, rows.TRUE_VELOCITY], rtol=1e-12)
    assert not np.array_equal(headless.render(scene, hand, 400)[0][:, rows.VELOCITY], out[:, rows.VELOCITY])

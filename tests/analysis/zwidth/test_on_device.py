"""Z-width is measured on the live simulated device and the virtual board, with interruptions and a person."""

import itertools
import math
from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from hapkit_studio.analysis.zwidth import on_device, simulation
from hapkit_studio.analysis.zwidth.guarded_device import Interrupted, TrialLimits
from hapkit_studio.analysis.zwidth.on_device import ripple
from hapkit_studio.analysis.zwidth.result import BUZZES, FAST, GROWS, HIGHEST, Protocol
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.dynamics.hand import RUBBER_BAND
from hapkit_studio.errors import Cancelled
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.engine import Engine
from tests.firmware.vb import needs_board
from tests.haptics.support import rest
from tests.lateness import ATTEMPTS, clear_lateness
from tests.waiting import wait_until

BEFORE = {"stiffness": 123.0, "damping": 4.0}
ONE_TRIAL = TrialLimits(softest=300.0, highest=300.0)


@pytest.fixture
def running():
    """Return a factory of running engines with a spring, which are all closed at the end."""
    engines = []

    def make(device=None, grip="light", delay=2e-3):
        engines.append(Engine(device or SimulatedHapkit(), "spring", realtime=False))
        engines[-1].set_environment("spring", BEFORE)
        engines[-1].set_loop(hand=grip)
        engines[-1].start()
        engines[-1].set_loop(delay=delay)
        return engines[-1]

    yield make
    for engine in engines:
        engine.close()


def assert_as_before(engine, environment="spring"):
    """Assert that settings, limit and hand are restored, and that only the old environment is rendered."""
    assert engine.environment.key == environment
    assert engine.arrays.block.settings.max_force == engine.device.max_force
    assert engine.arrays.block.settings.hand_on == 0
    last = rest(engine.reader(), 100)[-1]
    if environment == "spring" and not last[rows.FLAGS]:
        assert engine.values["stiffness"] == BEFORE["stiffness"]
        expected = -BEFORE["stiffness"] * last[rows.POSITION] - BEFORE["damping"] * last[rows.VELOCITY]
        assert last[rows.FORCE] == pytest.approx(expected, abs=1e-12)


def hits(found, surface=0.005):
    """Return the mean speed in m/s of the handle over the 20 samples before each hit of the wall."""
    x, t = found[:, rows.POSITION], found[:, rows.BOARD_TIME]
    into = np.flatnonzero((x[1:] > surface) & (x[:-1] <= surface))
    far = [k for k in into if k > 30 and x[k - 30] < surface - 0.5e-3]
    assert len(far) > 2
    return np.mean([(x[k] - x[k - 20]) / (t[k] - t[k - 20]) for k in far])


def after(calls, act):
    """Return a progress function that calls ``act`` at the ``calls``-th report of a pressed wall."""
    seen = []

    def progress(done, of):
        seen.append(done)
        if len(seen) == calls:
            act()

    return progress


@pytest.mark.slow
def test_the_live_device_agrees_with_the_simulation(running):
    engine, arrived = running(), []
    limits = TrialLimits(softest=1600.0, raised=1.6, precision=0.3)
    found = on_device.measure(
        engine, (1.0,), limits, arrived=lambda b, point: arrived.append((b, point.stiffness))
    )
    setting = on_device.setting_of(engine, "light")
    reference = simulation.compute(setting, (1.0,), Protocol(max_force=2.0))
    assert found.stiffness[0] == pytest.approx(reference.stiffness[0], rel=0.3)
    assert found.points[0].ended in (BUZZES, GROWS)
    assert arrived == [(1.0, found.stiffness[0])]
    assert found.linear[0] == pytest.approx(reference.linear[0])
    assert found.where == "Simulated Hapkit"
    conditions = {c.key: c.value for c in found.conditions}
    assert conditions["delay"] == 2e-3
    assert conditions["hand"] == "light"
    assert conditions["max_force"] == 2.0
    assert conditions["measured_rate_Hz"] == pytest.approx(1000.0, rel=1e-6)
    assert_as_before(engine)


@needs_board
@pytest.mark.alone  # a frame that is 20 ms late is a fault, even on a busy machine, so this test runs alone
def test_the_virtual_board_has_a_z_width(running):
    engine = running(VirtualBoard("lockstep"), delay=1e-3)
    limits = TrialLimits(softest=1000.0, raised=1.5, precision=0.1)
    for left in reversed(range(ATTEMPTS)):
        reader = engine.reader()
        try:
            found = on_device.measure(engine, (0.0,), limits)
            break
        except Interrupted:
            if engine.fault is None or not left:
                raise
            clear_lateness(engine)
            wait_until(lambda: engine.fault is None)
    assert hits(reader.read()) == pytest.approx(0.1, rel=0.3)
    conditions = {c.key: c.value for c in found.conditions}
    # the serial line adds to the delay
    assert 1e-3 < conditions["delay"] < 2.5e-3
    setting = replace(on_device.setting_of(engine, "light"), coulomb=0.1)
    reference = simulation.compute(setting, (0.0,), Protocol(max_force=2.0))
    assert found.stiffness[0] == pytest.approx(reference.stiffness[0], rel=0.2)
    assert found.linear[0] == pytest.approx(reference.linear[0], rel=0.01)
    assert conditions["measured_rate_Hz"] == pytest.approx(1000.0, rel=1e-3)
    assert math.isnan(conditions["coulomb"])
    assert found.as_json()["conditions"]["coulomb"] is None
    assert_as_before(engine)


def cancel(engine):
    assert engine.environment.key == "wall"
    raise Cancelled("enough")


def fail(engine):
    store_release(engine.arrays.control.fault, 0, arrays.OVER_SPEED)


def quit_loop(engine):
    store_release(engine.arrays.control.quit, 0, 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("act", "error", "says", "environment"),
    [
        (cancel, Cancelled, "enough", "spring"),
        (Engine.stop, Interrupted, "Force is zero", "spring"),
        (fail, Interrupted, "moved too fast", "spring"),
        (lambda engine: engine.set_environment("friction"), Interrupted, "settings were changed", "friction"),
        (quit_loop, Interrupted, "sends no data", None),
    ],
)
def test_interruptions_restore_settings_and_remove_the_wall(
    running, monkeypatch, act, error, says, environment
):
    """The measurement ends by cancelling, a stop, a fault, a lost device, or changed settings.

    Settings that were changed meanwhile are kept.
    """
    monkeypatch.setattr("hapkit_studio.analysis.zwidth.guarded_device._SILENCE_SECONDS", 0.5)
    engine = running()
    with pytest.raises(error, match=says):
        on_device.measure(engine, (0.0,), ONE_TRIAL, progress=after(60, lambda: act(engine)))
    if environment is None:  # the case in which the device is disconnected
        assert engine.environment.key == "spring"
        return
    assert_as_before(engine, environment)
    assert engine.stopped == (act is Engine.stop)
    assert (engine.fault is not None) == (act is fail)
    if engine.stopped:
        found = rest(engine.reader(), 20)
        assert np.all(found[:, rows.APPLIED_FORCE] == 0.0)
        assert np.all(found[:, rows.FLAGS].astype(int) & rows.STOPPED)


def test_a_scene_chosen_before_the_next_wall_is_not_overwritten(running, monkeypatch):
    """Settings may change between the check and the next wall."""
    engine, wall, count = running(), on_device.GuardedDevice.wall, itertools.count()

    def choose_then_try(guarded, stiffness, damping):
        if next(count) == 2:
            engine.set_environment("friction")
        wall(guarded, stiffness, damping)

    monkeypatch.setattr(on_device.GuardedDevice, "wall", choose_then_try)
    with pytest.raises(Interrupted, match="settings were changed"):
        on_device.measure(engine, (0.0,), ONE_TRIAL)
    assert_as_before(engine, "friction")


def test_excessive_speed_ends_a_trial_and_no_stiffer_wall_is_tried(running, monkeypatch):
    engine, tried = running(), []
    wall = on_device.GuardedDevice.wall
    monkeypatch.setattr(
        on_device.GuardedDevice, "wall", lambda self, k, b: (tried.append(k), wall(self, k, b))[1]
    )
    found = on_device.measure(engine, (0.0,), TrialLimits(max_speed=0.06, precision=0.29))
    assert (found.points[0].stiffness, found.points[0].ended) == (0.0, FAST)
    assert found.sentence == "The handle did not come to rest at any wall (light grip)."
    assert max(tried) == 200.0
    assert_as_before(engine)


def test_a_medium_grip_replaces_a_rubber_band_which_does_not_press():
    guarded = MagicMock()
    guarded.engine.grip = RUBBER_BAND
    assert on_device.SimulatedHand(guarded).grip == "medium"
    guarded.engine.set_loop.assert_called_once_with(hand="medium")


def test_the_band_is_searched_below_the_first_failed_wall(monkeypatch):
    """Walls of 200 and 300 N/m pass, 450 N/m fails. Then come a bisection and a search in steps of 5 %."""
    tried = []

    def watched(_guarded, _hand, stiffness):
        tried.append(stiffness)
        return "" if stiffness < 400.0 or 420.0 < stiffness < 440.0 else BUZZES

    monkeypatch.setattr(on_device, "_watched", watched)
    guarded, steps = MagicMock(limits=TrialLimits(), clamped=False), MagicMock(halvings=4)
    point = on_device._stiffest_at(guarded, MagicMock(), 0.0, steps)
    assert point.stiffness == pytest.approx(393.75)
    assert point.first_failed == pytest.approx(403.125)
    assert point.last_held == pytest.approx(393.75 * 1.05**2)
    assert max(tried) == 450.0
    assert len(tried) == 3 + 4 + 2 + 2


@pytest.fixture
def briefly(monkeypatch):
    """Watch each wall for less time than a judgement needs."""
    monkeypatch.setattr(on_device, "_WINDOW_SECONDS", 0.05)


def test_the_force_limit_applies_and_is_reported(running, briefly):
    engine = running(delay=0.0)
    reader = engine.reader()
    limits = TrialLimits(max_force=0.5, push=0.3, hit=0.15, softest=1500.0, highest=1500.0)
    found = on_device.measure(engine, (0.0,), limits)
    assert np.abs(reader.read()[:, rows.APPLIED_FORCE]).max() <= 0.5 + 1e-12
    assert (found.points[0].ended, found.points[0].clamped) == (HIGHEST, True)
    assert found.sentence.endswith("at least 1,500 N/m, with the motor at its limit of 0.5 N.")


@pytest.mark.slow
def test_a_person_gets_instructions_and_is_monitored(running, briefly):
    engine, instructions = running(grip="medium"), []

    def person(text):
        instructions.append(text)
        force, wall = 1.9 if len(instructions) == 1 else 1.0, engine.values["stiffness"]
        if text != "Hold the handle still":  # the hand moves like a grip of 200 N/m in series with the wall
            engine.move_hand(engine.values["position"] + force * (1.0 / wall + 1.0 / 200.0))

    found = on_device.measure(engine, (0.0,), ONE_TRIAL, person=True, instruct=person)
    assert instructions[0] == "Press gently into the wall and hold."
    gentler = next(text for text in instructions if text.startswith("Press more gently: "))
    assert float(gentler.split()[3]) == pytest.approx(1.9, abs=0.15)
    assert gentler.endswith("N now, 1 N is enough.")
    assert "Hold the handle still" in instructions
    assert found.points[0].ended == HIGHEST
    assert "a person's hand" in found.caption
    assert_as_before(engine)


def test_a_person_who_does_not_press_ends_the_measurement(running, monkeypatch):
    monkeypatch.setattr(on_device, "_PATIENCE_SECONDS", 0.0)
    engine = running()
    with pytest.raises(Interrupted, match="You did not press"):
        on_device.measure(engine, (0.0,), ONE_TRIAL, person=True)
    assert_as_before(engine)


def test_ripple_excludes_slow_hand_motion():
    t = np.arange(600) / 1000.0
    for hertz, least, most in ((2.0, 0.0, 0.03), (10.0, 0.2, 0.4), (30.0, 0.7, 1.3), (100.0, 0.9, 1.1)):
        swing = 0.5e-3 * np.sin(2.0 * math.pi * hertz * t)
        assert least * 1e-3 <= ripple(3e-3 * t + swing, 1000.0) <= most * 1e-3

"""The passivity observer: its sum of energy, the energy that a law can store, alarms, and restarts."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Prescribed, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import arrays, headless, passivity, rows
from tests.haptics.support import CONSTANT, COUNTING, LoopHarness

LIBRARY = environments.discover()
SPRING, WALL = LIBRARY["spring"], LIBRARY["wall"]
MASS, PERIOD = 0.044, 1e-3


def rendered(scene, hand, seconds):
    """Render a scene; return the rows and the observer's state at the end."""
    out, r = headless.render(scene, hand, round(seconds / PERIOD))
    return out, r.watch


def alarms(out):
    return np.count_nonzero(out[:, rows.FLAGS].astype(int) & rows.ACTIVE)


def ideal(**changes):
    numbers = {"damping": 0.0, "coulomb_force": 0.0, "quantum": 0.0, "max_force": math.inf}
    return SimulatedHapkit(**{**numbers, **changes})


# --- the sum of energy


@pytest.mark.parametrize("delay", [0.0, 1e-3, 2.3e-3])
def test_the_energy_is_the_force_in_effect_over_the_true_path(delay):
    device = SimulatedHapkit(quantum=0.0)
    scene = headless.Scene(WALL, WALL.values({"stiffness": 600.0}), device, LoopSettings(delay=delay))
    out, watch = rendered(scene, hand_named("tap"), 1.5)
    late = np.concatenate((np.zeros(8), out[:, rows.APPLIED_FORCE]))
    whole, share = int(delay * 1e3), delay * 1e3 % 1.0
    first = 8 - whole
    n = len(out)
    acting = (1.0 - share) * late[first : first + n - 1] + share * late[first - 1 : first + n - 2]
    given = np.cumsum(acting * np.diff(out[:, rows.TRUE_POSITION]))
    assert watch.given == pytest.approx(given[-1], rel=1e-9)
    np.testing.assert_allclose(out[1:, rows.ENERGY_GIVEN], given, rtol=1e-9, atol=1e-15)
    assert np.isfinite(out[1:, rows.ENERGY_LIMIT]).all()


def test_slow_motions_through_sensor_steps_have_the_true_energy():
    """The handle moves in and out of a wall 20 times at 2 mm/s.

    If the energy were computed from counts instead of their edges, it would drift.
    """

    def motion(t):
        return 0.005 + 0.002 * (1.0 - math.cos(0.5 * math.pi * t))

    scene = headless.Scene(WALL, WALL.values(), SimulatedHapkit(coulomb_force=0.0, damping=0.0))
    out, watch = rendered(scene, Prescribed(motion), 80.0)
    true = np.sum(out[:-1, rows.APPLIED_FORCE] * np.diff(out[:, rows.TRUE_POSITION]))
    step = 20.7e-6 * np.abs(out[:, rows.APPLIED_FORCE]).max()
    assert out[-1, rows.ENERGY] - true > 0.5 * 20 * step
    assert abs(watch.given - true) < 0.1 * step
    assert not alarms(out)


@pytest.mark.parametrize("stiffness", [300.0, 1000.0])
def test_a_bounce_off_a_sampled_wall_has_the_theoretical_energy(stiffness):
    """Theory 4.4 gives E_out / E_in = exp(pi w T / 2), averaged over the sampling phases of the contact."""
    speed, found = 0.5, []
    for phase in np.arange(16) / 16:
        device = ideal(initial_position=0.004 + phase * speed * PERIOD, initial_velocity=speed)
        out, watch = rendered(headless.Scene(WALL, WALL.values({"stiffness": stiffness}), device), None, 0.2)
        assert out[-1, rows.TRUE_VELOCITY] < 0.0
        assert alarms(out)
        found.append(watch.given)
    brought = 0.5 * MASS * speed**2
    gain = math.exp(0.5 * math.pi * math.sqrt(stiffness / MASS) * PERIOD)
    assert (brought + np.mean(found)) / brought == pytest.approx(gain, rel=0.01)


# --- dissipation that follows from the sensor's counts


def least_squares_of_speed(counts, quantum):
    """Return the smallest possible sum of (change of position)² / PERIOD of motions with these counts.

    All motions start in the middle of the first count.
    """
    steps = np.diff(np.eye(len(counts)), axis=0)[:, 1:] / math.sqrt(PERIOD)
    middle = (counts - counts[0])[1:]
    found = lsq_linear(
        steps, np.zeros(len(steps)), (middle - 0.5 * quantum, middle + 0.5 * quantum), tol=1e-14
    )
    return 2.0 * found.cost


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_proven_dissipation_is_a_lower_bound(seed):
    """The proven dissipation is at least 90 % of the exact minimum.

    It may exceed the minimum only in the last, incomplete interval, by one count at the top speed.
    """
    rng, quantum, t = np.random.default_rng(seed), 20.7e-6, np.arange(300) * PERIOD
    hertz, phase = rng.uniform(1.0, 12.0, 3), rng.uniform(0.0, 6.0, 3)
    x = 0.7e-3 * np.sin(2.0 * np.pi * np.outer(t, hertz) + phase).sum(axis=1)
    counts = quantum * np.floor(x / quantum)
    harness = LoopHarness(CONSTANT, {"level": 0.0}, quantum=quantum)
    harness.r.block.settings.damper = 1.0
    harness.run(counts)
    least, top = least_squares_of_speed(counts, quantum), np.abs(np.gradient(x, PERIOD)).max()
    assert least < np.sum(np.diff(x) ** 2) / PERIOD
    proven = harness.r.watch.squares
    assert 0.9 * least < proven < least + 2.0 * top * quantum


# --- storable energy


@pytest.mark.parametrize("start", [0.0, 0.01, -0.02])
def test_a_spring_stores_the_energy_of_its_deflection(start):
    device = ideal(initial_position=start)
    values = SPRING.values({"stiffness": 300.0, "center": 0.0013})
    out, watch = rendered(headless.Scene(SPRING, values, device), Prescribed(lambda t: start), 0.2)
    stored = pytest.approx(0.5 * 300.0 * (start - 0.0013) ** 2, rel=1e-9)
    assert watch.alarm.limit == out[-1, rows.ENERGY_LIMIT] == stored


def test_the_motor_stores_no_more_than_its_force_limit_allows():
    device = ideal(initial_position=0.02, max_force=3.0)
    values = SPRING.values({"stiffness": 600.0})
    _, watch = rendered(headless.Scene(SPRING, values, device), Prescribed(lambda t: 0.02), 0.2)
    stored = 3.0 * 0.015 + 0.5 * 600.0 * 0.005**2
    assert watch.alarm.limit == pytest.approx(stored, rel=1e-3)


def test_a_fall_from_a_hill_is_no_alarm():
    """At the top the force is zero; the energy stored there follows only from the law at other positions."""
    hill = LIBRARY["bump_valley"]
    device = SimulatedHapkit(initial_position=-0.0246, coulomb_force=0.0)
    out, _ = rendered(headless.Scene(hill, hill.values(), device), None, 2.0)
    assert out[:, rows.ENERGY].max() > 1e-3
    assert not alarms(out)


CASES = [(key, hand) for key, e in LIBRARY.items() for hand in e.hands]


@pytest.mark.parametrize(("key", "hand"), CASES)
def test_no_alarm_if_no_energy_is_given(key, hand):
    scene = LIBRARY[key]
    for device in (SimulatedHapkit(), SimulatedHapkit().reduced(scene.needs)):
        out, _ = rendered(headless.Scene(scene, scene.values(), device), hand_named(hand), 4.0)
        assert not alarms(out)


@pytest.mark.parametrize(("share", "active"), [(0.98, False), (1.02, True)])
@pytest.mark.parametrize("delay", [0.0, 1e-3])
def test_the_alarm_occurs_at_the_passivity_limit_of_a_spring(share, active, delay):
    """The condition is b > K (T/2 + td), theory 1.1, for imposed strokes of 30 mm at 1 Hz.

    b is the paddle's damping.
    """
    viscous = 0.5
    stiffness = share * viscous / (0.5 * PERIOD + delay)
    device = ideal(damping=viscous)
    scene = headless.Scene(SPRING, SPRING.values({"stiffness": stiffness}), device, LoopSettings(delay=delay))
    out, _ = rendered(scene, Prescribed(lambda t: 0.03 * math.sin(2.0 * math.pi * t)), 12.0)
    assert bool(alarms(out)) == active


@pytest.mark.parametrize("delay", [0.0, 1e-3])
@pytest.mark.parametrize(("reach", "hertz"), [(0.3e-3, 15.0), (1e-3, 8.0), (10e-3, 3.0), (30e-3, 0.3)])
@pytest.mark.parametrize("quantum", [5e-6, 20.7e-6, 60e-6])
def test_quantisation_causes_no_false_alarm_for_a_passive_spring(quantum, reach, hertz, delay):
    """A spring of 90 % of the largest passive stiffness is moved for 20 s at various speeds."""
    device = SimulatedHapkit(damping=0.5, coulomb_force=0.0, quantum=quantum, max_force=math.inf)
    values = SPRING.values({"stiffness": 0.9 * 0.5 / (0.5 * PERIOD + delay)})
    scene = headless.Scene(SPRING, values, device, LoopSettings(delay=delay))
    out, _ = rendered(scene, Prescribed(lambda t: reach * math.sin(2.0 * math.pi * hertz * t)), 20.0)
    assert not alarms(out)


def test_earlier_damping_does_not_excuse_later_energy():
    """After a damper has taken 300 mJ in strokes, a spring beyond its passivity limit is detected at once."""
    values = SPRING.values({"stiffness": 1.3 * 2.0 * 0.5 / PERIOD, "damping": 2.0})

    def motion(t):
        return (
            0.02 * math.sin(12.0 * t)
            if t < 5.0
            else 0.02 * math.sin(60.0) + 2e-3 * math.sin(300.0 * (t - 5.0))
        )

    scene = headless.Scene(
        SPRING, values, ideal(damping=0.5), LoopSettings(estimator=("iir", {"cutoff": 20.0}))
    )
    out, _ = rendered(scene, Prescribed(motion), 5.3)
    assert out[4900, rows.ENERGY] < -0.3
    assert not alarms(out[:5000])
    assert alarms(out[5000:])


# --- restarts


def given(harness):
    return harness.r.watch.given


def strokes(harness, count):
    """Move to and fro under a force that always acts along the motion; return the rows."""
    x = 1e-3 * (np.arange(count) % 2)
    return harness.run(x, np.where(np.arange(count) % 2, 1.0, -1.0))


def busy(**wanted):
    harness = LoopHarness(CONSTANT, quantum=0.0, **wanted)
    strokes(harness, 200)
    assert given(harness) == pytest.approx(0.199, rel=1e-9)
    return harness


@pytest.mark.parametrize("change", ["number", "choice", "law", "rate", "estimator", "sensor", "damping"])
def test_it_restarts_after_a_change(change):
    harness = busy()
    if change == "number":
        harness.set(CONSTANT, {"level": 2.0})
    elif change == "choice":
        harness.set(CONSTANT, {"place": "d"})
    elif change == "law":
        harness.set(COUNTING)
    elif change == "rate":
        harness.rate = 2000.0
        harness.set(CONSTANT)
    else:
        other = {"estimator": {"estimator": "iir"}, "sensor": {"quantum": 1e-6}, "damping": {"viscous": 0.1}}
        harness.set(CONSTANT, **other[change])
    harness.tick(1e-3, 1.0)
    assert given(harness) == 0.0
    assert not int(harness.tick(1e-3)[rows.FLAGS]) & rows.ACTIVE


def test_it_continues_while_the_hand_moves():
    harness = busy()
    harness.set(CONSTANT, target=0.01)
    harness.tick(1e-3)
    assert given(harness) == pytest.approx(0.199, rel=1e-9)


def test_it_restarts_after_a_released_stop_and_a_cleared_fault():
    harness = busy()
    harness.stop()
    assert int(harness.tick(1e-3, 1.0)[rows.FLAGS]) == rows.STOPPED
    harness.stop(False)
    assert given(harness) == 0.0
    out = strokes(harness, 200)
    assert not np.any(out[:30, rows.FLAGS].astype(int) & rows.ACTIVE)
    assert given(harness) > 0.1
    harness.r.control.fault[0] = arrays.RUNAWAY
    harness.tick(1e-3, 1.0)
    harness.clear_fault()
    harness.tick(1e-3)
    assert given(harness) == 0.0


def test_it_calls_the_law_without_changing_its_state():
    harness = LoopHarness(COUNTING)
    counts = harness.ticks(0.2)[:, rows.STATE]
    np.testing.assert_array_equal(counts, np.arange(1.0, 201.0))
    assert harness.r.watch.cells_known > passivity.CELLS


@pytest.mark.parametrize("declared", [True, False])
def test_energy_stored_in_a_moving_object_may_be_given_back(declared):
    """A parameter is changed while a pushed puck flies. The handle yields when the puck returns."""
    puck = LIBRARY["puck"] if declared else replace(LIBRARY["puck"], stored=None)
    harness, force, found = LoopHarness(puck, quantum=0.0, viscous=0.5), 0.0, []
    for k in range(600):
        if k == 100:
            harness.set(puck, {"friction": 0.01})
        found.append(harness.tick(-0.005 + 0.3 * PERIOD * min(k, 60) - 0.1 * PERIOD * max(k - 160, 0), force))
        force = found[-1][rows.APPLIED_FORCE]
    out = np.array(found)
    assert out[-1, rows.ENERGY] - out[100, rows.ENERGY] > 5e-3
    assert bool(alarms(out)) == (not declared)


@pytest.mark.parametrize("start", [0.007, 0.012])
@pytest.mark.parametrize("rate", [500.0, 1000.0])
def test_a_handle_thrown_out_of_a_wall_stays_within_the_evaluated_cells(start, rate):
    """The handle crosses more and more cells per tick; the energy added by the sampled wall is detected."""
    device = SimulatedHapkit(
        mass=0.0625, damping=0.5, coulomb_force=0.0, quantum=0.0, max_force=math.inf, initial_position=start
    )
    values = WALL.values({"stiffness": 1541.0})
    out, _ = headless.render(headless.Scene(WALL, values, device, LoopSettings(rate, 0.0, "iir")), None, 300)
    stored = 0.5 * 1541.0 * (start - values["position"]) ** 2
    given = np.sum(out[:-1, rows.APPLIED_FORCE] * np.diff(out[:, rows.TRUE_POSITION]))
    assert given > 1.1 * stored
    assert alarms(out)

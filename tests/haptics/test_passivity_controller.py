"""The passivity controller bounds growing motion and changes nothing else; the safety checks follow it."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import arrays, headless, passivity, rows
from hapkit_studio.haptics.passivity import FELT, most_damping
from tests.haptics.support import BROKEN, CONSTANT, LoopHarness

LIBRARY = environments.discover()
SPRING = LIBRARY["spring"]
MASS, VISCOUS, PERIOD, START = 0.05, 0.5, 1e-3, 2e-3


def released(stiffness, damping=0.0, delay=0.0, controller=True, **changes):
    """Return the rows of 6 s of a handle that is released at START in a spring."""
    numbers = {"coulomb_force": 0.0, "quantum": 0.0, "max_force": math.inf, **changes}
    device = SimulatedHapkit(MASS, VISCOUS, initial_position=START, **numbers)
    values = {"stiffness": stiffness, "damping": damping, "center": 0.0}
    scene = headless.Scene(SPRING, values, device, LoopSettings(delay=delay, controller=controller))
    return headless.render(scene, None, 6000)[0]


def amplitude(out):
    return np.abs(out[-1000:, rows.TRUE_POSITION]).max()


def to_the_hand(out):
    """Return the maximum energy in J that the motor gives beyond the paddle's own dissipation."""
    taken = np.cumsum(VISCOUS * out[:-1, rows.TRUE_VELOCITY] ** 2) * PERIOD
    return (out[1:, rows.ENERGY] - taken).max()


# columns: damping in N·s/m, delay in s, exact limit of the stiffness in N/m (theory 1.4), stiffness / limit
BEYOND = [
    (0.0, 0.0, 1001.7, 1.2),
    (0.0, 0.0, 1001.7, 3.0),
    (5.0, 0.0, 9974.0, 1.3),
    (0.0, 1e-3, 334.3, 3.0),
    (2.0, 1e-3, 1597.4, 1.5),
]


@pytest.mark.parametrize(("damping", "delay", "limit", "factor"), BEYOND)
def test_a_spring_beyond_its_limit_stays_bounded(damping, delay, limit, factor):
    stiffness = factor * limit
    stored = 0.5 * stiffness * START**2
    without = released(stiffness, damping, delay, controller=False)
    assert amplitude(without) > 3.0 * START
    assert to_the_hand(without) > 10.0 * stored
    out = released(stiffness, damping, delay)
    assert np.count_nonzero(out[:, rows.FLAGS].astype(int) & rows.DAMPED) > 100
    assert amplitude(out) < 1.1 * START
    assert to_the_hand(out) < 1.1 * stored + 4.0 * FELT


# columns: rate in Hz, delay in s, sensor step in m, the handle's damping in N·s/m, stiffness in N/m, which is
# 2 to 4 times the passive stiffness
COUNTED = [
    (2000.0, 1e-3, 20.7e-6, 0.5, 1260.0),
    (2000.0, 1e-3, 40e-6, 0.2, 640.0),
    (1000.0, 0.0, 20.7e-6, 0.2, 1600.0),
    (1000.0, 1e-3, 40e-6, 1.0, 1400.0),
    (4000.0, 1.75e-3, 80e-6, 0.2, 240.0),
    (4000.0, 0.0, 5e-6, 0.5, 12000.0),
    (500.0, 2e-3, 10e-6, 0.5, 500.0),
    # the following delays are fractions of a period
    (500.0, 0.6e-3, 20.7e-6, 0.5, 1260.0),
    (500.0, 0.6e-3, 0.0, 0.5, 1260.0),
    (500.0, 1.0e-3, 0.0, 0.5, 1260.0),
    (2000.0, 0.15e-3, 0.0, 0.5, 1260.0),
]


def energies(device, stiffness, rate, delay, seconds, controller=True):
    """Return the true energy (n,) in J of a released spring, and the energy gain that theory allows.

    The gain is the threshold of an alarm, plus the energy that a delayed spring adds until the controller's
    answer takes effect: the power (K (T/2 + td) - b) v² in W (theory 1.1) for a delay and two periods.
    """
    values = {"stiffness": stiffness, "damping": 0.0, "center": 0.0}
    scene = headless.Scene(SPRING, values, device, LoopSettings(rate, delay, controller=controller))
    out, r = headless.render(scene, None, round(seconds * rate))
    energy = of_the_spring(out, device, stiffness)
    meant = FELT + passivity.COUNTS * device.quantum * r.watch.peak
    lost = stiffness * (0.5 / rate + delay) - device.damping
    return energy, meant + lost * 2.0 * (energy[0] + meant) / device.mass * (delay + 2.0 / rate)


def gained(energy):
    return (energy - np.minimum.accumulate(energy)).max()


@pytest.mark.parametrize(("rate", "delay", "quantum", "viscous", "stiffness"), COUNTED)
def test_counts_and_fractional_delays_cause_no_apparent_damping(rate, delay, quantum, viscous, stiffness):
    """For 40 s the true energy stays within the gain that theory allows, and decays."""
    device = SimulatedHapkit(damping=viscous, coulomb_force=0.0, quantum=quantum, initial_position=1.5e-3)
    energy, bound = energies(device, stiffness, rate, delay, 40.0)
    assert bound < 1e-3
    assert gained(energy) < bound
    first, last = np.array_split(energy, 4)[::3]
    assert last.max() < first.max()
    assert np.ptp(energies(device, stiffness, rate, delay, 10.0, controller=False)[0]) > 3.0 * bound


@pytest.mark.parametrize(("share", "holds"), [(0.75, True), (0.9, False)])
@pytest.mark.parametrize(("rate", "delay"), [(500.0, 0.6e-3), (1000.0, 0.0), (4000.0, 1e-3)])
def test_it_stabilises_a_spring_that_needs_up_to_three_quarters_of_its_damping(rate, delay, share, holds):
    device = SimulatedHapkit(coulomb_force=0.0, max_force=1e3, initial_position=1.5e-3)
    most = most_damping(device.mass, 1.0 / rate, delay)
    stiffness = (share * most + device.damping) / (0.5 / rate + delay)
    energy, bound = energies(device, stiffness, rate, delay, 20.0)
    assert (gained(energy) < bound) == holds
    assert holds or energy.max() > 100.0 * energy[0]


def of_the_spring(out, device, stiffness):
    """Return the energy (n,) in J of the handle and the spring, whose force is limited by the motor."""
    away = np.abs(out[:, rows.TRUE_POSITION] - 0.5 * device.quantum)
    pulled = np.minimum(away, device.max_force / stiffness)
    stored = 0.5 * stiffness * pulled**2 + device.max_force * (away - pulled)
    return 0.5 * device.mass * out[:, rows.TRUE_VELOCITY] ** 2 + stored


def test_it_damps_while_the_law_exceeds_the_force_limit():
    """A handle is released at 20 mm in a spring of 1,260 N/m.

    The force is at the motor's limit of 3 N, except at positions below 3 N / K = 2.4 mm.
    """
    device = SimulatedHapkit(coulomb_force=0.0, initial_position=0.02)
    values = {"stiffness": 1260.0, "damping": 0.0, "center": 0.0}
    scene = headless.Scene(SPRING, values, device, LoopSettings(2000.0, 1e-3, controller=True))
    out, _ = headless.render(scene, None, 20_000)
    flags = out[:, rows.FLAGS].astype(int)
    assert np.count_nonzero((flags & rows.CLAMPED > 0) & (flags & rows.DAMPED > 0)) > 20
    assert np.abs(out[:, rows.APPLIED_FORCE]).max() == 3.0
    assert amplitude(out) < 3.0 / 1260.0


@pytest.mark.parametrize("factor", [2.0, 3.0])
def test_with_friction_and_sensor_steps_it_settles(factor):
    numbers = {"coulomb_force": 0.1, "quantum": 20.7e-6, "max_force": 3.0}
    without = released(factor * 1001.7, delay=1e-3, controller=False, **numbers)
    assert amplitude(without) > 5e-3
    out = released(factor * 1001.7, delay=1e-3, **numbers)
    assert amplitude(out) < 0.2e-3
    assert np.abs(out[:, rows.APPLIED_FORCE]).max() <= 3.0
    assert not np.any(out[-1000:, rows.FLAGS].astype(int) & rows.DAMPED)


@pytest.mark.parametrize("key", LIBRARY)
def test_it_changes_nothing_if_no_energy_is_given(key):
    scene = LIBRARY[key]
    hand = hand_named(scene.hands[0])
    loops = LoopSettings(), LoopSettings(controller=True)
    one, other = (
        headless.render(headless.Scene(scene, scene.values(), loop=loop), hand, 2000)[0] for loop in loops
    )
    np.testing.assert_array_equal(one, other)


def test_its_damping_alone_is_stable():
    for late in (0.0, 0.5e-3, 1e-3, 2e-3):
        damping = most_damping(MASS, PERIOD, late)
        assert hs.stiffness_limit(MASS, 0.0, damping=damping, delay=late) > 1000.0
    assert most_damping(MASS, PERIOD, 0.0) == pytest.approx(0.25 * MASS / PERIOD)


@pytest.mark.parametrize("asked", [0.0, 1.5, -5.0])
def test_its_force_is_a_fraction_of_the_devices_limit(asked):
    """The damping force is subtracted from the clamped force, and the result is clamped again."""
    harness = LoopHarness(CONSTANT, {"level": asked}, quantum=0.0, max_force=2.0, max_speed=20.0)
    harness.r.block.settings.damper = most_damping(100.0, PERIOD, 0.0)
    x = 0.01 * (np.arange(300) % 2)
    out = harness.run(x, np.where(np.arange(300) % 2, 2.0, -2.0))
    damped = out[:, rows.FLAGS].astype(int) & rows.DAMPED > 0
    assert damped[-100:].all()
    np.testing.assert_array_equal(out[:, rows.FORCE], asked)
    taken = np.sign(np.diff(x, prepend=0.0)[damped]) * passivity.SHARE * 2.0
    np.testing.assert_allclose(out[damped, rows.APPLIED_FORCE], np.clip(max(asked, -2.0) - taken, -2.0, 2.0))
    np.testing.assert_array_equal(out[:, rows.FLAGS].astype(int) & rows.CLAMPED > 0, abs(asked) > 2.0)


# --- the checks of the force act after the controller


@pytest.mark.parametrize("how", ["nan", "inf", "minus inf", "index"])
def test_a_failing_law_is_still_stopped(how):
    harness = LoopHarness(BROKEN, {"how": how})
    harness.r.block.settings.damper = 10.0
    harness.ticks(0.2)
    row = harness.tick(0.01)
    assert row[rows.APPLIED_FORCE] == 0.0
    assert row[rows.FLAGS] == rows.FAULT
    assert harness.r.control.fault[0] in (arrays.NOT_A_NUMBER, arrays.LAW_INDEX)


def test_stop_and_over_speed_take_precedence():
    harness = LoopHarness(CONSTANT, {"level": 0.0}, quantum=0.0, max_speed=20.0)
    harness.r.block.settings.damper = 10.0
    x, effects = 0.01 * (np.arange(300) % 2), np.where(np.arange(300) % 2, 2.0, -2.0)
    assert harness.run(x, effects)[-1, rows.APPLIED_FORCE] != 0.0
    harness.stop()
    np.testing.assert_array_equal(harness.run(x, effects)[:, rows.APPLIED_FORCE], 0.0)
    harness.stop(False)
    assert harness.run(x, effects)[-1, rows.APPLIED_FORCE] != 0.0
    row = harness.tick(0.05, 2.0)
    assert row[rows.APPLIED_FORCE] == 0.0
    assert harness.r.control.fault[0] == arrays.OVER_SPEED


# --- access to the controller


def test_the_library_can_enable_it():
    device = hs.SimulatedHapkit(MASS, VISCOUS, initial_position=0.005)
    runs = [
        hs.simulate("spring", {"stiffness": 2000.0}, device=device, delay=1e-3, controller=on)
        for on in (False, True)
    ]
    ends = [np.abs(run.true_position[-200:]).max() for run in runs]
    assert ends[0] > 5e-3 > 1e-3 > ends[1]
    assert [run.settings["controller"] for run in runs] == [False, True]

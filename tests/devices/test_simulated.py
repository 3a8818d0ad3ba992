"""The simulated Hapkit agrees with matrix exponentials for any delay, with hands, and during changes."""

import itertools
import math

import numpy as np
import pytest

from hapkit_studio.devices import simulated
from hapkit_studio.devices.simulated import EFFECT, HAND_FORCE, SimulatedHapkit, V, X
from hapkit_studio.errors import ParameterError
from tests.dynamics import reference_paddle
from tests.wide import wide

NO_HAND = (0.0, 0.0, 0.0)
MEDIUM = (0.05, 4.0, 200.0)


def start(
    mass=0.044,
    viscous=0.5,
    coulomb=0.0,
    hand=NO_HAND,
    period=1e-3,
    delay=0.0,
    x=0.0,
    v=0.0,
    periods=1022,
    stops=math.inf,
):
    dev, queue = simulated.new_state(x, v, periods, stops)
    simulated.configure(dev, queue, mass, viscous, coulomb, *hand, period, delay)
    return dev, queue


def run(dev, queue, law, targets):
    """Return (x, v) at len(targets) samples under the force law(k, x)."""
    out = []
    for k in range(len(targets)):
        out.append((dev[X], dev[V]))
        simulated.command(dev, queue, law(k, dev[X]))
        if k + 1 < len(targets):
            simulated.advance(dev, queue, targets[k], targets[k + 1])
    return np.array(out)


def applied(dev, queue, forces):
    """Return the mean force of each period, as it acted on a free mass of 1 kg without damping."""
    mean = []
    for force in forces:
        before = dev[V]
        if force is not None:
            simulated.command(dev, queue, force)
        simulated.advance(dev, queue, 0.0, 0.0)
        mean.append((dev[V] - before) / dev[simulated._PERIOD])
    return mean


HANDS = (NO_HAND, MEDIUM, (0.0, 0.0, 90.0))
DELAYS = (0.0, 0.3, 0.999, 1.0, 3.7, 12.25)


@pytest.mark.parametrize(
    ("hand", "periods_late"),
    wide(
        itertools.product(HANDS, DELAYS), lambda hand, late: (HANDS.index(hand) + DELAYS.index(late)) % 3 == 0
    ),
)
def test_motion_is_exact_for_any_delay_and_hand(hand, periods_late, rng):
    for _ in range(4):
        period, mass, viscous = 10 ** rng.uniform(-4, -2), 10 ** rng.uniform(-2, 0), 10 ** rng.uniform(-2, 1)
        push, stiffness = rng.normal(0.0, 1.0, 80), 0.03 * mass / period**2 * rng.random()
        targets, delay = np.cumsum(rng.normal(0.0, 1e-3, 80)), periods_late * period
        x0, v0 = rng.normal(0.0, 0.01), rng.normal(0.0, 0.1)

        def law(k, x, push=push, stiffness=stiffness):
            return push[k] - stiffness * x

        want = reference_paddle.run(law, targets, mass, viscous, hand, period, delay, x0, v0)
        got = run(*start(mass, viscous, 0.0, hand, period, delay, x0, v0), law, targets)
        assert np.all(np.abs(got - want) <= 1e-9 * np.abs(want).max(axis=0))


def test_hand_force_is_spring_and_damper_to_the_moving_target():
    dev, queue = start(hand=MEDIUM)
    simulated.advance(dev, queue, 0.0, 2e-4)
    want = 200.0 * (2e-4 - dev[X]) + 4.0 * (0.2 - dev[V])
    assert dev[HAND_FORCE] == pytest.approx(want, rel=1e-12)
    assert dev[HAND_FORCE] > 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_end_stops_are_inelastic(side):
    """A mass of 1 kg with 2 N hits the stop at 20 mm after sqrt(2 · 20 mm / (2 m/s²)) = 0.1414 s.

    It rests there, and leaves the stop with F t² / 2 m when the force reverses.
    """
    dev, queue = start(1.0, 0.0, delay=0.3e-3, stops=0.02)
    found = run(dev, queue, lambda k, x: side * (2.0 if k < 300 else -2.0), np.zeros(401))
    x, v = (side * found).T
    assert np.argmax(x == 0.02) == 142
    assert np.all(x[142:301] == 0.02)
    assert not v[142:301].any()
    t = 1e-3 * np.arange(101) - 0.3e-3
    assert x[301:] == pytest.approx(0.02 - t[1:] ** 2, abs=1e-12)


def test_end_stops_that_are_not_reached_have_no_effect():
    swing = start(coulomb=0.1, hand=MEDIUM, delay=0.3e-3, v=0.2)
    free = run(*swing, lambda k, x: -500.0 * x, np.zeros(300))
    far = np.nextafter(np.abs(free[:, 0]).max(), 1.0)
    stopped = start(coulomb=0.1, hand=MEDIUM, delay=0.3e-3, v=0.2, stops=far)
    assert np.array_equal(run(*stopped, lambda k, x: -500.0 * x, np.zeros(300)), free)


def test_the_window_has_end_stops_and_simulate_has_none():
    assert simulated.DEVICE.entries()[0].make() == SimulatedHapkit(end_stops=0.055)
    assert SimulatedHapkit().end_stops == math.inf


def test_motor_is_off_until_the_first_command_arrives():
    dev, queue = start(1.0, 0.0, delay=2.25e-3)
    assert applied(dev, queue, [4.0, 8.0, 0.0, 0.0]) == pytest.approx([0.0, 0.0, 3.0, 7.0], abs=1e-9)
    assert dev[EFFECT] == pytest.approx(7.0, rel=1e-9)
    assert applied(dev, queue, [2.0, None, None])[-1] == pytest.approx(1.5)  # the last command remains active


@pytest.mark.parametrize(("late", "periods"), [(6, 6), (1000, 1022), (5000, 5000)])
def test_the_longest_delay_that_fits_is_still_exact(late, periods):
    dev, queue = start(1.0, 0.0, period=1e-4, delay=late * 1e-4, periods=periods)
    force = applied(dev, queue, [float(k) for k in range(late + 100)])
    assert force[:late] == pytest.approx([0.0] * late, abs=1e-9)
    assert force[late:] == pytest.approx(np.arange(100.0), abs=1e-6)


def test_releasing_the_handle_keeps_motion_and_pending_commands():
    dev, queue = start(1.0, 0.0, hand=MEDIUM, delay=3e-3, v=0.1)
    for force in (1.0, 2.0, 3.0):
        simulated.command(dev, queue, force)
        simulated.advance(dev, queue, 0.0, 0.0)
    x, v = dev[X], dev[V]
    simulated.configure(dev, queue, 1.0, 0.0, 0.0, *NO_HAND, 1e-3, 3e-3)
    assert (dev[X], dev[V], dev[HAND_FORCE]) == (x, v, 0.0)
    assert applied(dev, queue, [0.0] * 4) == pytest.approx([1.0, 2.0, 3.0, 0.0], abs=1e-9)


def test_a_released_hand_has_no_effect():
    dev, queue = start(v=0.1)
    simulated.advance(dev, queue, math.nan, math.nan)
    assert dev[V] == pytest.approx(0.1 * math.exp(-0.5e-3 / 0.044), rel=1e-12)
    assert dev[HAND_FORCE] == 0.0


def test_a_shorter_delay_drops_outdated_forces_and_a_longer_one_repeats_the_last():
    dev, queue = start(1.0, 0.0, delay=4e-3)
    applied(dev, queue, [1.0, 2.0, 3.0, 4.0, 5.0])
    simulated.configure(dev, queue, 1.0, 0.0, 0.0, *NO_HAND, 1e-3, 0.0)
    assert applied(dev, queue, [9.0, 9.0]) == pytest.approx([9.0, 9.0])
    simulated.configure(dev, queue, 1.0, 0.0, 0.0, *NO_HAND, 1e-3, 3e-3)
    assert applied(dev, queue, [7.0] * 5) == pytest.approx([9.0, 9.0, 9.0, 7.0, 7.0])


def test_a_faster_rate_keeps_pending_forces_at_their_times():
    dev, queue = start(1.0, 0.0, period=1e-3, delay=3e-3)
    applied(dev, queue, [1.0, 2.0, 3.0])
    simulated.configure(dev, queue, 1.0, 0.0, 0.0, *NO_HAND, 0.5e-3, 3e-3)
    assert applied(dev, queue, [8.0] * 8) == pytest.approx([1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 8.0, 8.0])


def test_random_changes_never_apply_an_uncommanded_force(rng):
    dev, queue = start(1.0, 0.0)
    for _ in range(300):
        period, delay = 10 ** rng.uniform(-4, -2), rng.choice([0.0, 1e-3, 0.1]) * rng.random()
        simulated.configure(dev, queue, 1.0, 0.0, 0.0, *NO_HAND, period, delay)
        force = applied(dev, queue, list(rng.uniform(0.5, 1.0, rng.integers(1, 40))))
        assert np.all(np.array(force) < 1.0 + 1e-9)
        assert np.all(np.array(force) > -1e-9)


def test_with_friction_the_delay_still_splits_the_period():
    dev, queue = start(1.0, 0.0, coulomb=1.0, delay=0.25e-3)
    simulated.command(dev, queue, 3.0)
    simulated.advance(dev, queue, 0.0, 0.0)
    assert dev[V] == pytest.approx(2.0 * 0.75e-3, rel=1e-12)


def test_motion_that_has_died_out_becomes_exactly_zero():
    dev, queue = start(viscous=5.0, hand=MEDIUM, v=0.1)
    for _ in range(20_000):
        simulated.advance(dev, queue, 0.0, 0.0)
    assert (dev[X], dev[V], dev[HAND_FORCE]) == (0.0, 0.0, 0.0)


def test_friction_of_the_handle_stops_a_soft_hand():
    dev, queue = start(coulomb=0.1, hand=MEDIUM)
    for _ in range(50):
        simulated.advance(dev, queue, 0.4e-3, 0.4e-3)
    assert (dev[X], dev[V]) == (0.0, 0.0)
    assert dev[HAND_FORCE] == pytest.approx(0.08)


@pytest.mark.parametrize(
    ("x", "counts"), [(0.0, 0), (20.6e-6, 0), (20.8e-6, 1), (-1e-9, -1), (-20.8e-6, -2), (1e-2, 483)]
)
def test_the_sensor_reads_the_next_lower_count(x, counts):
    assert simulated.quantise(x, 20.7e-6) == pytest.approx(counts * 20.7e-6, abs=1e-15)
    assert simulated.quantise(x, 0.0) == x


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"mass": 0.0}, "mass must be more than 0 kg, not 0 kg"),
        ({"mass": math.nan}, "mass must be a number in kg, not nan"),
        ({"damping": -0.1}, "damping must be 0 or more N·s/m, not −0.1"),
        ({"coulomb_force": "much"}, "Coulomb friction must be a number in N, not 'much'"),
        ({"quantum": -1e-6}, "quantum must be 0 or more m"),
        ({"max_force": 0.0}, "force limit must be more than 0 N"),
        ({"initial_position": math.inf}, "initial position"),
        ({"initial_velocity": math.nan}, "initial velocity"),
        ({"end_stops": 0.0}, "end stops must be more than 0 m"),
    ],
)
def test_impossible_devices_are_rejected(bad, names):
    with pytest.raises(ParameterError, match=names) as error:
        SimulatedHapkit(**bad)
    assert "\n" not in str(error.value)

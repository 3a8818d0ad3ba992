"""Rendering agrees with theory: motion, stability limits, energy, imposed motion, and hands."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import SCRIPTS, Hand, Prescribed
from tests.dynamics import reference_paddle

QUANTUM = 20.7e-6


def device(**given):
    """Return a linear device with an ideal sensor, without Coulomb friction and without a force limit."""
    return hs.SimulatedHapkit(**{"coulomb_force": 0.0, "quantum": 0.0, "max_force": math.inf, **given})


# --- motion agrees with matrix exponentials


@pytest.mark.parametrize("late", [0.0, 0.001, 0.5, 0.999, 1.0, 7.3])
def test_motion_is_exact_for_delays_of_any_fraction(late):
    """A medium hand moves against a spring and a damper, whose velocity is a backward difference.

    The motion agrees with theory to 1e-6.
    """
    stiffness, damping, mass, viscous = 30.0, 0.3, 0.06, 0.8
    for rate in (1000.0, 370.0):
        period = 1.0 / rate
        hand = Hand(0.05, 4.0, 200.0, lambda t: 0.01 * math.sin(9.0 * t) + 0.1 * t * t)
        values = {"stiffness": stiffness, "damping": damping, "center": 0.002}
        start = device(mass=mass, damping=viscous, initial_position=0.004, initial_velocity=-0.2)
        given = {"hand": hand, "device": start, "rate": rate, "delay": late * period, "seconds": 0.5}
        run = hs.simulate("spring", values, **given)
        last = [0.004]

        def law(k, x, last=last, period=period):
            force = -stiffness * (x - 0.002) - damping * (x - last[0]) / period
            last[0] = x
            return force

        targets = [hand.target(t) for t in np.arange(len(run.time)) * period]
        grip = (hand.mass, hand.damping, hand.stiffness)
        want = reference_paddle.run(law, targets, mass, viscous, grip, period, late * period, 0.004, -0.2)
        for got, wanted in ((run.true_position, want[:, 0]), (run.true_velocity, want[:, 1])):
            assert np.abs(got - wanted).max() <= 1e-6 * np.abs(wanted).max()


def test_spring_deflects_by_force_over_stiffness():
    """The hand's and the rendered spring are in series: x = k_h target / (k + k_h), and the force is k x."""
    for stiffness in (20.0, 80.0, 300.0):
        hand = Hand(0.05, 4.0, 200.0, lambda t: 0.01)
        run = hs.simulate("spring", {"stiffness": stiffness}, hand=hand, device=device(), seconds=6.0)
        x = 200.0 * 0.01 / (stiffness + 200.0)
        assert run.true_position[-1] == pytest.approx(x, rel=1e-9)
        assert run.applied_force[-1] == pytest.approx(-stiffness * x, rel=1e-9)
        assert run.hand_force[-1] == pytest.approx(stiffness * x, rel=1e-9)
        assert run.hand_force[-1] / stiffness == pytest.approx(run.true_position[-1], rel=1e-9)


def test_friction_and_counts_change_the_deflection_within_their_range():
    hand = Hand(0.05, 4.0, 200.0, lambda t: 0.01)
    run = hs.simulate("spring", {"stiffness": 80.0}, hand=hand, seconds=4.0)
    reach = (0.10 + 80.0 * QUANTUM) / 280.0
    assert abs(run.true_position[-1] - 2.0 / 280.0) <= reach
    assert np.ptp(run.true_position[-200:]) < QUANTUM


# --- stability at the exact boundary

LOOPS = [
    (0.05, 0.5, 1000.0, 0.0, "difference", 0.0),
    (0.05, 0.5, 1000.0, 1.0, "difference", 1.0),
    (0.03, 0.2, 1000.0, 0.5, "difference", 0.0),
    (0.10, 1.0, 500.0, 0.3, "difference", 0.0),
    (0.044, 0.5, 2000.0, 2.6, "difference", 0.0),
    (0.044, 1.3, 250.0, 0.0, "difference", 0.5),
    (0.05, 0.5, 1000.0, 0.0, "iir", 0.5),
    (0.20, 2.0, 1000.0, 3.0, ("iir", {"cutoff": 60.0}), 2.0),
]


@pytest.mark.parametrize("part", [0.99, 1.01])
@pytest.mark.parametrize(("mass", "viscous", "rate", "late", "estimator", "damping"), LOOPS)
def test_one_percent_inside_the_limit_decays_outside_grows(
    part, mass, viscous, rate, late, estimator, damping
):
    """A spring is released at 1 µm; the largest excursions of two intervals, 14 s apart, are compared."""
    loop = {"rate": rate, "delay": late / rate, "estimator": estimator}
    limit = hs.stiffness_limit(mass, viscous, damping=damping, **loop)
    assert limit < 2000.0
    start = device(mass=mass, damping=viscous, initial_position=1e-6)
    values = {"stiffness": part * limit, "damping": damping}
    run = hs.simulate("spring", values, device=start, seconds=18.0, **loop)
    size = np.abs(run.true_position)
    early, late_size = size[int(2 * rate) : int(4 * rate)].max(), size[int(16 * rate) :].max()
    assert early > 1e-9
    assert late_size < 0.9 * early if part < 1.0 else late_size > 1.1 * early
    assert not run.faults


# --- the wall's energy


def bounce(stiffness, rate, delay, phase):
    """Return the ratio of the energies after and before a bounce off a wall.

    ``phase`` is the time from the last sample to the contact, as a fraction of a period.
    """
    speed, mass = 0.1, 0.05
    before = 0.005 - (3.0 + phase) * speed / rate
    start = device(mass=mass, damping=0.0, initial_position=before, initial_velocity=speed)
    contact = math.pi * math.sqrt(mass / stiffness)
    seconds = 1.5 * contact + 20.0 / rate + 4.0 * delay
    run = hs.simulate("wall", {"stiffness": stiffness}, device=start, rate=rate, delay=delay, seconds=seconds)
    assert run.true_position[-1] < 0.005
    assert run.applied_force[-1] == 0.0
    assert run.true_velocity[-1] == run.true_velocity[-2] < 0.0
    return (run.true_velocity[-1] / speed) ** 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "rate", "late", "table"),
    [
        (100.0, 1000.0, 0, 1.0728),
        (3000.0, 1000.0, 0, 1.4647),
        (300.0, 250.0, 0, 1.6172),
        (100.0, 1000.0, 1, 1.2342),
        (1000.0, 1000.0, 1, 1.9298),
    ],
)
def test_the_energy_of_a_bounce_off_a_wall_agrees_with_the_formula(stiffness, rate, late, table):
    """The formula is exp(pi omega (T/2 + delay)), averaged over the sampling phase at contact."""
    phases = (np.arange(32) + 0.5) / 32
    gain = np.mean([bounce(stiffness, rate, late / rate, phase) for phase in phases])
    assert gain == pytest.approx(table, rel=2e-3)
    turn = math.sqrt(stiffness / 0.05) / rate
    if turn * (1 + 2 * late) <= 0.4:
        assert gain == pytest.approx(math.exp(math.pi * turn * (0.5 + late)), rel=0.01)


# --- imposed motion


def test_imposed_motion_gets_exactly_the_laws_force():
    """The motor cannot change the prescribed position, and the force is exactly -k times the depth."""

    def motion(t):
        return 0.012 * math.sin(7.0 * t)

    run = hs.simulate("wall", {"stiffness": 400.0}, hand=Prescribed(motion), device=device(), seconds=2.0)
    want = np.array([motion(t) for t in run.time])
    assert np.array_equal(run.true_position, want)
    depth = np.maximum(want - 0.005, 0.0)
    assert run.force == pytest.approx(-400.0 * depth, rel=1e-14)
    assert np.array_equal(run.force, run.applied_force)
    assert run.true_velocity == pytest.approx(0.084 * np.cos(7.0 * run.time), abs=1e-6)


def test_a_hand_that_imposes_a_motion_overcomes_mass_damping_and_motor():
    for delay, late in ((0.0, 0), (1e-3, 1), (2.4e-3, 3)):
        start = hs.SimulatedHapkit(mass=0.1, damping=0.5, coulomb_force=0.0, quantum=0.0)
        spring = {"stiffness": 100.0}
        hand = Prescribed(lambda t: 0.5 * t * t)
        run = hs.simulate("spring", spring, hand=hand, device=start, delay=delay, seconds=0.2)
        t = run.time[3:-2]
        acting = 100.0 * 0.5 * (t - late * 1e-3) ** 2
        assert run.hand_force[3:-2] == pytest.approx(0.1 + 0.5 * t + acting, abs=2e-4)


def test_imposed_motion_is_never_evaluated_before_its_start():
    asked = []
    hs.simulate("wall", hand=Prescribed(lambda t: asked.append(t) or math.sqrt(t) * 1e-3), seconds=0.01)
    assert min(asked) == 0.0


# --- hands


def test_the_hands_force_is_that_of_its_spring_and_damper():
    hand = Hand(0.05, 4.0, 200.0, lambda t: 0.02 + 0.01 * t)
    start = device(initial_position=0.002, initial_velocity=0.1)
    run = hs.simulate("free", hand=hand, device=start, seconds=0.2)
    want = 200.0 * (0.02 + 0.01 * run.time - run.true_position) + 4.0 * (0.01 - run.true_velocity)
    assert run.hand_force == pytest.approx(want, rel=1e-9)


def test_no_hand_equals_a_released_hand():
    start = hs.SimulatedHapkit(initial_position=0.02)
    runs = [hs.simulate("spring", hand=h, device=start) for h in (None, "released", Hand(release=0.0))]
    for run in runs:
        assert not run.hand_force.any()
        assert np.array_equal(run.true_position, runs[0].true_position)


def test_a_named_hand_gives_the_same_run_sample_by_sample():
    """A movement evaluated for arrays or single times gives the same run, bit for bit."""
    for name, hand in SCRIPTS.items():
        one_by_one = replace(hand, vectorised=False)
        first, second = (hs.simulate("wall", hand=h, seconds=3.0) for h in (name, one_by_one))
        assert np.array_equal(first.true_position, second.true_position), name
        assert np.array_equal(first.hand_force, second.hand_force), name


# --- energy


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 1.7e-3])
def test_the_energy_is_the_force_in_effect_times_the_path(delay):
    start = device(quantum=1e-4)
    run = hs.simulate("wall", hand="tap", device=start, delay=delay, seconds=1.0)
    whole = int(delay * 1e3)
    share = delay * 1e3 - whole
    late = np.concatenate([np.zeros(whole + 1), run.applied_force])
    acting = (1.0 - share) * late[1 : len(run.time)] + share * late[: len(run.time) - 1]
    want = np.concatenate([[0.0], np.cumsum(acting * np.diff(run.position))])
    assert run.energy == pytest.approx(want, abs=1e-12)
    assert np.abs(want).max() > 1e-4


def test_a_passive_scene_gives_no_more_energy_than_was_stored():
    """Damping dissipates; a spring deflected to 20 mm returns at most its k x^2 / 2."""
    assert hs.simulate("damping", hand="stroke", seconds=3.0).energy[-1] < -1e-3
    start = hs.SimulatedHapkit(initial_position=0.02)
    run = hs.simulate("spring", device=start, rate=8000.0, seconds=1.0)
    assert 0.95 * 0.5 * 80.0 * 0.02**2 < run.energy.max() < 1.02 * 0.5 * 80.0 * 0.02**2

"""The worst of all hands against the passivity line, random hands, and objects built mode by mode."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import hands
from hapkit_studio.analysis.stability.passivity import passive_damping, passive_stiffness
from hapkit_studio.dynamics.hand import Grip
from tests.analysis.stability.test_limits import closed_loop
from tests.wide import wide

FILTERS = ("difference", ("iir", {"cutoff": 20.0}), "iir", "kalman", "butterworth")


def some_setting(rng):
    rate = 10 ** rng.uniform(2.5, 3.7)
    delay = rng.choice([0.0, 1.0, rng.random(), 3.0 * rng.random()]) / rate
    mass, viscous = 10 ** rng.uniform(-1.7, -0.7), 10 ** rng.uniform(-0.7, 0.7)
    return Setting(mass, viscous, 0.0, 20.7e-6, rate, delay, FILTERS[rng.integers(len(FILTERS))])


def passivity(setting, shares):
    """Return dampings, as shares of the largest passive one, and the passivity line there."""
    sampling = setting.rate, setting.delay, setting.estimator, setting.quantum
    damping = passive_damping(setting.viscous, *sampling) * np.asarray(shares)
    return damping, passive_stiffness(setting.viscous, damping, *sampling)


@pytest.mark.parametrize("count", [10, pytest.param(40, marks=pytest.mark.slow)])
def test_what_is_drawn_is_never_below_the_passivity_line_and_within_a_tenth_of_it(count):
    """On drawn loops, up to nine tenths of the largest passive damping."""
    rng = np.random.default_rng(411)
    for _ in range(count):
        setting = some_setting(rng)
        damping, line = passivity(setting, (0.0, 0.25, 0.5, 0.75, 0.9))
        drawn = hands.springy(setting, damping)
        assert (drawn >= line * (1.0 - 1e-9)).all()
        assert (drawn <= 1.1 * line).all()
        assert (hands.springy(setting, damping, 1) >= drawn * (1.0 - 1e-9)).all()


@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_people_are_above_the_line_and_no_random_hand_is_worse(count):
    rng = np.random.default_rng(412)
    ranges = hands.MASS, hands.DAMPING, hands.STIFFNESS
    for _ in range(count):
        setting = some_setting(rng)
        damping, line = passivity(setting, (0.0, 0.5, 1.0))
        found = hands.family(setting, damping)
        assert (found.people > line).all()
        assert found.springy[:2] == pytest.approx(1.05 * line[:2], rel=0.05)
        loop = vars(setting) | {"quantum": None, "coulomb": None, "controller": None}
        loop = {key: value for key, value in loop.items() if value is not None}
        for b, limit, worst in zip(damping, found.people, found.worst, strict=True):
            grips = [Grip(*(10 ** rng.uniform(*np.log10(ends)) for ends in ranges)) for _ in range(30)]
            roots = [largest(loop, b, grip, 0.95 * limit) for grip in grips]
            assert max(roots) < 1.0
            assert largest(loop, b, worst, 0.99 * limit) < 1.0 < largest(loop, b, worst, 1.01 * limit)


def largest(loop, damping, grip, stiffness):
    matrices = closed_loop(**{**loop, "damping": damping, "hand": grip})
    return np.abs(np.linalg.eigvals(matrices(np.array(stiffness)))).max()


def object_root(setting, damping, stiffness, swing, heavy=200.0):
    """Return the largest root of the loop with masses on springs that swing at some rad/s on the handle.

    The structure's place is the sum of its modes, each of which the force moves as a mass of so many kg; the
    damper feels their sum. States: place and speed of each mode, the last place, two commands.
    """
    n, period = len(swing), 1.0 / setting.rate
    a = np.zeros((2 * n + 1, 2 * n + 1))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -np.diag(np.square(swing))
    a[n : 2 * n, n : 2 * n] = -setting.viscous / heavy
    a[n : 2 * n, -1] = 1.0 / heavy
    whole = int(setting.delay * setting.rate + 1e-9)
    first, second = (
        expm(a * (setting.delay - whole * period)),
        expm(a * (whole * period + period - setting.delay)),
    )
    size = 2 * n + 3 + whole
    place = np.r_[np.ones(n), np.zeros(size - n)]
    ask = -(stiffness + damping / period) * place
    ask[2 * n] += damping / period
    commands = [ask, *np.eye(size)[2 * n + 1 :]]
    moved = first[:-1, :-1] @ np.eye(size)[: 2 * n] + np.outer(first[:-1, -1], commands[whole + 1])
    moved = second[:-1, :-1] @ moved + np.outer(second[:-1, -1], commands[whole])
    whole_map = np.vstack([moved, place, *commands[: whole + 2]])
    return np.abs(np.linalg.eigvals(whole_map)).max()


LOOPS = [(0.0, 0.0), (0.0, 0.45), (0.7e-3, 0.3), (1e-3, 0.2), (1.4e-3, 0.0)]


@pytest.mark.parametrize(("delay", "damping"), wide(LOOPS, lambda delay, damping: delay == 1e-3))
def test_the_worst_mass_on_a_spring_swings_just_above_its_limit(delay, damping):
    setting = Setting(viscous=0.5, delay=delay)
    limit = hands.springy(setting, np.array([damping]), 1)[0]
    swings = np.r_[np.geomspace(3.0, 300.0, 20), np.linspace(300.0, math.pi * 1e3, 400)]
    inside, outside = (
        max(object_root(setting, damping, share * limit, [w]) for w in swings) for share in (0.98, 1.02)
    )
    assert inside < 1.0 < outside


@pytest.mark.slow
def test_two_masses_on_springs_tuned_to_each_other_swing_earlier():
    """At half the rate and three times that, but for the little by which the loop detunes them."""
    setting, damping, heavy = Setting(viscous=0.5), 0.4, 200.0
    one, two = (hands.springy(setting, np.array([damping]), modes)[0] for modes in (1, 2))
    assert two < 0.75 * one
    tuned, off = math.pi * setting.rate, np.linspace(-1.0, 1.0, 15) * setting.viscous / heavy
    inside, outside = (
        max(
            object_root(setting, damping, share * two, [tuned + p, 3.0 * tuned + q], heavy)
            for p in off
            for q in off
        )
        for share in (0.98, 1.02)
    )
    assert inside < 1.0 < outside

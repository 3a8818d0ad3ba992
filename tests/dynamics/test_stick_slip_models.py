"""Friction models on a mass by itself: what stops, what holds, what creeps, by how much."""

import math

import numpy as np
import pytest

from hapkit_studio.dynamics.stick_slip import MODELS, slide
from hapkit_studio.errors import ParameterError

STOPPING = ("karnopp", "projection", "karnopp_band", "stribeck")


def nothing(seconds, dt):
    return np.zeros(round(seconds / dt) + 1)


@pytest.mark.parametrize("model", STOPPING)
def test_slide_to_stop(model):
    """m v / F_c = 10 ms and m v^2 / (2 F_c) = 0.5 mm; from there on the velocity is exactly 0."""
    options = {"band": 1e-4} if model == "karnopp_band" else {}
    t, x, v = slide(
        model, nothing(0.05, 1e-6), mass=0.05, static=0.5, kinetic=0.5, v0=0.1, dt=1e-6, **options
    )
    stop = np.flatnonzero(v == 0.0)[0]
    assert t[stop] == pytest.approx(0.010, rel=2e-3)
    assert x[-1] == pytest.approx(0.5e-3, rel=1e-3)
    assert not v[stop:].any()
    assert (x[stop:] == x[stop]).all()


@pytest.mark.parametrize("model", ["karnopp", "projection"])
@pytest.mark.parametrize(
    ("kinetic", "start", "turns", "half"),
    [
        (0.1, 0.010, [0.01 * (-1) ** n * (1.0 - n / 15.0) for n in range(16)], 40.558e-3),
        (0.3, 0.020, [0.02 * (-1) ** n * (1.0 - n / 10.0) for n in range(11)], 40.558e-3),
    ],
)
def test_a_spring_released_against_friction(model, kinetic, start, turns, half):
    """Every half-cycle of pi sqrt(m / k) loses 2 F_c / k, until the spring can no longer break it away."""
    seconds = half * len(turns)
    t, x, v = slide(
        model,
        nothing(seconds, 1e-6),
        mass=0.05,
        spring=300.0,
        static=kinetic,
        kinetic=kinetic,
        x0=start,
        dt=1e-6,
    )
    at = np.flatnonzero((v[:-1] != 0.0) & ((v[1:] == 0.0) | (v[:-1] * v[1:] < 0.0))) + 1
    assert x[at] == pytest.approx(turns[1:], abs=2e-6)
    assert t[at] == pytest.approx(half * np.arange(1, len(turns)), abs=1e-4)
    assert v[-1] == 0.0
    assert abs(x[-1]) <= kinetic / 300.0


def creep(model, dt, frequency=20.0, mass=0.05, **options):
    """Return the drift in µm/s under 0.3 N that trembles by 0.15 N, half of what static friction holds."""
    t = np.arange(round(3.0 / dt) + 1) * dt
    pull = 0.3 + 0.15 * np.sin(2.0 * np.pi * frequency * t)
    _, x, _ = slide(model, pull, mass=mass, static=1.0, kinetic=0.5, dt=dt, **options)
    return 1e6 * (x[-1] - x[round(1.0 / dt)]) / 2.0


@pytest.mark.parametrize("dt", [1e-4, 1e-3])
@pytest.mark.parametrize("model", STOPPING)
def test_what_knows_rest_holds_without_any_drift(model, dt):
    assert creep(model, dt) == 0.0


@pytest.mark.parametrize("stiffness", [2e3, 2e4])
def test_a_tether_holds_without_drift(stiffness):
    assert abs(creep("tether", 1e-4, stiffness=stiffness)) < 0.1


@pytest.mark.parametrize(
    ("model", "options", "wanted"),
    [
        ("smoothed", {"smoothing": 0.001, "stribeck_velocity": 0.003}, 316.0),
        ("smoothed", {}, 3165.0),
        ("lugre", {}, 432.0),
    ],
)
def test_what_knows_the_speed_alone_never_holds(model, options, wanted):
    assert creep(model, 1e-4, **options) == pytest.approx(wanted, rel=0.02)


def test_smoothed_friction_too_steep_for_the_step_chatters():
    steep = {"smoothing": 0.001, "stribeck_velocity": 0.003}
    assert creep("smoothed", 1e-3, **steep) > 10.0 * creep("smoothed", 1e-4, **steep)


def test_dahl_creeps_by_what_its_curve_says():
    """Slowly: dx = dF / (K (1 -+ F / F_c)) up and down, summed over a cycle."""
    cycle = 0.5 / 1e4 * (math.log(1.0 - (0.15 / 0.5) ** 2) - math.log(1.0 - (0.45 / 0.5) ** 2))
    assert creep("dahl", 1e-4, frequency=2.0) == pytest.approx(2.0e6 * cycle, rel=0.02)


def test_hayward_and_armstrongs_anchor_hardly_creeps():
    assert 0.1 < abs(creep("hayward_armstrong", 1e-4, stiffness=2e4)) < 4.0


@pytest.mark.parametrize("start", [0.1234, 0.0377, -0.0999])
def test_the_sign_of_the_velocity_chatters_and_creeps(start):
    """A step takes F_c T / m = 10 mm/s: it never gets nearer to rest, and the mean of two is no rest."""
    _, x, v = slide("coulomb", nothing(2.0, 1e-3), mass=0.05, static=0.5, kinetic=0.5, v0=start)
    late = v[-1000:]
    assert np.abs(late).max() <= 0.01
    assert late[2:] == pytest.approx(late[:-2], abs=1e-12)
    assert (late[1:] * late[:-1] < 0.0).all()
    assert abs(x[-1] - x[-1001]) <= 0.005 + 1e-9
    if start == 0.1234:
        assert np.abs(late).max() == pytest.approx(6.6e-3)
        assert x[-1] - x[-1001] == pytest.approx(-1.6e-3)


@pytest.mark.parametrize("model", MODELS)
def test_every_model_brakes_a_free_mass_and_never_drives_it(model):
    """Within 2 mm and what is strained on the way; a strained anchor without damping may go on ringing."""
    _, x, v = slide(model, nothing(1.0, 1e-4), mass=0.05, static=0.5, kinetic=0.5, v0=0.2, dt=1e-4)
    assert np.abs(v).max() == 0.2
    assert np.abs(v[-100:]).max() <= (0.02 if model == "hayward_armstrong" else 1.1e-3)
    assert 1.0e-3 < x[-1] < 2.6e-3


@pytest.mark.parametrize(
    ("applied", "names"),
    [
        (["push"], "must be numbers of N"),
        ([[0.0], [1.0]], "one row of finite numbers"),
        ([0.0, math.nan], "one row of finite numbers"),
    ],
)
def test_refuses_forces_that_are_none(applied, names):
    with pytest.raises(ParameterError, match=names):
        slide("projection", applied, mass=1.0, static=1.0, kinetic=1.0)


def test_nothing_in_nothing_out():
    assert [a.size for a in slide("projection", [], mass=1.0, static=1.0, kinetic=1.0)] == [0, 0, 0]

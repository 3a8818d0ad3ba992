"""The pushed mass and the puck as scenes: momentum, energy, friction, growth by the integrator."""

import math

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.environments.base import Conditions
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA
from tests.dynamics import growth
from tests.environments import calling
from tests.environments.calling import LIBRARY, call, column, imposed, smoothly

MASS, PUCK = LIBRARY["mass_spring_damper"], LIBRARY["puck"]
CONTRACT = {"object", "object_velocity", "object_acceleration", "started"}


def pushed_and_held(t):
    """Return a slow motion from the rest position to 20 mm beyond it, which keeps contact."""
    return smoothly(t, 0.01, 0.03, 0.4)


def pushed_and_left(t):
    return smoothly(t, 0.0, 0.02, 0.1) if t < 0.1 else smoothly(t - 0.1, 0.02, -0.1, 0.2)


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize(
    ("case", "motion", "rate"),
    [(0, pushed_and_left, 1000.0), (1, pushed_and_held, 1000.0), (2, pushed_and_held, 230.0)],
)
def test_the_course_s_mass_grows_in_the_scene_as_in_its_table(method, case, motion, rate):
    """The mass has m = 2 kg, b = 1 N·s/m, k = 300 N/m, without contact or with a contact of 1000 N/m."""
    values = {"contact_stiffness": 1000.0, "integrator": method}
    run = imposed("mass_spring_damper", values, motion, 1.5, rate)
    after = run.time > 0.45
    held = 0.01 + (1000.0 * 0.02 / 1300.0 if case else 0.0)
    swing = column(run, "object")[after] - held
    assert np.all((run.force[after] < 0.0) == (case > 0))
    assert np.abs(swing).max() > 2e-5
    assert growth.rate(swing, 1.0 / rate) == pytest.approx(growth.COURSE_RATES[method][case], rel=0.02)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_the_scene_uses_the_integrator_exactly(method):
    """After the handle has left, every sample of the scene equals the integrator's.

    The acceleration in a row is the acceleration before the last step.
    """
    run = imposed("mass_spring_damper", {"integrator": method, "mass": 0.2}, pushed_and_left, 0.6)
    x, v = column(run, "object"), column(run, "object_velocity")
    first = 400
    given = {"mass": 0.2, "damping": 1.0, "stiffness": 300.0, "force": 3.0, "dt": 1e-3, "seconds": 0.199}
    _, want, speed = hs.integrate(method, x0=x[first], v0=v[first], **given)
    if method != "lecture":  # the lecture's rule starts with a stored acceleration
        assert x[first:] == pytest.approx(want, abs=1e-13)
        assert v[first:] == pytest.approx(speed, abs=1e-11)
    acceleration = (3.0 - v[first - 1] - 300.0 * x[first - 1]) / 0.2
    assert column(run, "object_acceleration")[first] == pytest.approx(acceleration, rel=1e-12)


def test_objects_start_at_rest_at_their_positions():
    for values in ({}, {"rest_position": -0.02}):
        run = imposed("mass_spring_damper", values, lambda t: -0.05, 0.01)
        assert np.all(column(run, "object") == values.get("rest_position", 0.01))
        assert np.all(column(run, "object_velocity") == 0.0)
    puck = ((-0.05, 0.010, 1.0), (0.05, 0.010, -1.0), (0.008, 0.013, 1.0), (0.01, 0.005, -1.0))
    for handle, begins, side in puck:
        run = imposed("puck", {}, lambda t, handle=handle: handle, 0.01)
        assert column(run, "object") == pytest.approx(np.full(10, begins), abs=1e-15)
        assert np.all(column(run, "side") == side)
        assert np.abs(run.force).max() < 1e-12
    assert set(MASS.state_names) >= CONTRACT
    assert set(PUCK.state_names) >= CONTRACT | {"side"}


def test_pushed_slowly_the_force_is_that_of_contact_and_spring_in_series():
    values = MASS.values({"damping": 20.0, "stiffness": 200.0, "contact_stiffness": 800.0})
    x = np.array([-0.02, 0.010, 0.012, 0.03])
    theory = MASS.over_position(values, x)
    assert theory == pytest.approx([0.0, 0.0, -160.0 * 0.002, -160.0 * 0.02], rel=1e-12)
    for where, want in zip(x, theory, strict=True):
        run = imposed(
            "mass_spring_damper", values, lambda t, where=where: smoothly(t, -0.02, where, 0.5), 4.0
        )
        assert run.force[-1] == pytest.approx(want, abs=1e-6)


def test_contact_damping_acts_only_on_approach():
    contact = {"contact_stiffness": 100.0, "contact_damping": 7.0}
    values = MASS.values(contact)
    for v, want in ((0.2, -100.0 * 0.003 - 7.0 * 0.2), (0.0, -0.3), (-0.2, -0.3)):
        assert call(MASS, values, 0.013, v)[0] == pytest.approx(want, rel=1e-12)
    assert call(MASS, values, 0.009, 0.2)[0] == 0.0
    assert MASS.impedance(values) == PUCK.impedance(PUCK.values(contact)) == (100.0, 7.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "method", "without", "damped"),
    [
        ("mass_spring_damper", "lecture", 2300, 1800),
        ("puck", "lecture", 2200, 1700),
        ("puck", "rk4", 1000, 800),
        ("puck", "verlet", 1600, 1000),
    ],
)
def test_the_board_is_faster_without_contact_damping(key, method, without, damped):
    for damping, expected in ((0.0, without), (0.001, damped)):
        values = LIBRARY[key].values({"integrator": method, "contact_damping": damping})
        rate = BoardPlanner(ARENA).plan(PlanRequest(LIBRARY[key], values)).rate
        assert rate == pytest.approx(expected, rel=1e-3)


def warned(key, period=1e-3, **values):
    """Return the warnings about the integrator; strong damping of the handle prevents other warnings."""
    return calling.warned(key, Conditions(1.0 / period, viscous=100.0), **values)


def test_an_unstable_integrator_gets_a_warning():
    """The lecture's mass in contact is stable for steps to 0.77 ms (explicit), 77.7 ms (semi-implicit)."""
    course = {"contact_stiffness": 1000.0}
    (line,) = warned("mass_spring_damper", integrator="explicit_euler", **course)
    assert line.startswith("Explicit Euler adds energy")
    assert "0.769 ms" in line
    assert "1 ms" in line
    assert not warned("mass_spring_damper", 0.76e-3, integrator="explicit_euler", **course)
    assert warned("mass_spring_damper", integrator="lecture", **course)
    assert not warned("mass_spring_damper", 0.077, **course)
    assert warned("mass_spring_damper", 0.078, **course)
    for method, name in (("explicit_euler", "Explicit Euler"), ("lecture", "Lecture's rule")):
        assert warned("puck", integrator=method) == [f"{name} adds energy during contact in every step."]
    for method in ("semi_implicit", "verlet", "rk4", "implicit_euler", "trapezoid", "exact"):
        assert not warned("puck", integrator=method)
        assert not warned("mass_spring_damper", integrator=method, **course)


@pytest.mark.parametrize("rate", [100.0, 1000.0])
@pytest.mark.parametrize("key", ["mass_spring_damper", "puck"])
@pytest.mark.parametrize("method", INTEGRATORS)
def test_diverging_objects_restart_and_the_force_stays_finite(key, method, rate):
    """For a light object between stiff springs, only explicit integrators diverge."""
    values = {"mass": 0.05, "contact_stiffness": 5000.0, "integrator": method}
    if key == "mass_spring_damper":
        values |= {"stiffness": 2000.0, "damping": 0.0}
    else:
        values |= {"wall_stiffness": 5000.0}
    run = imposed(key, values, lambda t: 0.012 + 0.01 * math.sin(20.0 * t), 2.0, rate)
    assert run.faults == ()
    assert all(np.isfinite(c).all() for c in run.columns().values())
    x, v = column(run, "object"), column(run, "object_velocity")
    assert np.abs(x).max() <= 1.0
    begins_anew = (np.abs(x[:-1]) > 0.1) & (x[1:] >= 0.0) & (x[1:] <= 0.03) & (v[1:] == 0.0)
    if method in ("implicit_euler", "trapezoid", "exact"):
        assert not begins_anew.any()
    if method in ("explicit_euler", "lecture"):
        assert begins_anew.any()


def shove(t):
    """Return the path of a hand that pushes the puck from the left, and retracts before the puck returns."""
    return smoothly(t, -0.01, 0.018, 0.12) if t < 0.12 else smoothly(t - 0.12, 0.018, -0.3, 0.1)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_push_gives_the_puck_its_impulse(method):
    """The momentum m v equals the sum of force times period, exactly if a step uses one force only."""
    run = imposed("puck", {"integrator": method}, shove, 0.16)
    momentum = 0.5 * column(run, "object_velocity")[-1]
    impulse = -run.force.sum() * 1e-3
    assert run.force[-1] == 0.0
    assert momentum > 0.03
    exactly = method in ("explicit_euler", "semi_implicit")
    assert impulse == pytest.approx(momentum, rel=1e-12 if exactly else 0.03)


def bounces(method, wall, rate=1000.0, seconds=8.0):
    """Return the energies of a puck of 0.05 kg between its bounces off two walls, after one push."""
    values = {"integrator": method, "mass": 0.05, "wall_stiffness": wall}
    run = imposed("puck", values, shove, seconds, rate)
    x, v = column(run, "object"), column(run, "object_velocity")
    free = (np.abs(x) < 0.03) & (run.time > 0.25)
    starts = np.flatnonzero(free & ~np.roll(free, 1))
    assert len(starts) > 8
    return 0.025 * v[starts[1:]] ** 2


@pytest.mark.parametrize(
    ("method", "gain", "tolerance"),
    [
        ("explicit_euler", 1.275, 0.01),
        ("lecture", 1.275, 0.01),
        ("semi_implicit", 1.0, 2e-3),
        ("verlet", 1.0, 2e-3),
        ("rk4", 1.0, 1e-3),
        ("implicit_euler", 0.784, 0.01),
        ("exact", 1.0, 1e-6),
    ],
)
def test_energy_of_a_bounce_between_the_walls(method, gain, tolerance):
    """A wall of 300 N/m at 1 kHz has omega dt = 0.0775."""
    energy = bounces(method, 300.0, seconds=1.6 if gain > 1.1 else 4.0)
    ratio = (energy[7] / energy[0]) ** (1.0 / 7.0) if gain != 1.0 else energy / energy[0]
    assert ratio == pytest.approx(gain, abs=tolerance)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_friction_stops_the_puck_permanently(method):
    """The puck slides by m v^2 / (2 F_c).

    The error of projected friction is at most half the distance of one step.
    """
    run = imposed("puck", {"integrator": method, "friction": 2.0, "mass": 0.1}, shove, 1.0)
    x, v = column(run, "object"), column(run, "object_velocity")
    off = np.flatnonzero(run.force)[-1] + 2
    assert v[off] > 0.1
    slides = 0.1 * v[off] ** 2 / 4.0
    assert x[off] + slides < 0.034
    assert x[-1] - x[off] == pytest.approx(slides, abs=1e-12 if method == "exact" else 0.51e-3 * v[off])
    assert np.all(v[-500:] == 0.0)
    assert np.all(x[-500:] == x[-1])


def test_the_handle_keeps_its_side_inside_the_puck():
    """Up to the far edge, the force is towards the handle's side.

    Beyond that edge, the handle is on the other side.
    """
    values = PUCK.values()
    for sign in (1.0, -1.0):
        _, state, _ = call(PUCK, values, 0.010 - sign * 0.006, 0.0)
        for offset, want in ((-0.004, 1.0), (0.002, 7.0), (0.0049, 9.9)):
            inside, still, _ = call(PUCK, values, 0.010 + sign * offset, 0.0, state.copy())
            assert inside == pytest.approx(-sign * 500.0 * want * 1e-3, rel=1e-9)
            assert still[PUCK.state_names.index("side")] == sign
        beyond, state, _ = call(PUCK, values, 0.010 + sign * 0.006, 0.0, state.copy())
        assert beyond == 0.0
        assert state[PUCK.state_names.index("side")] == -sign


@pytest.mark.parametrize("pad", [0.0, 4.0])
def test_action_equals_reaction_at_every_sample(pad):
    """The equation is m (v_k+1 - v_k) / dt = -F_k - b v_k - k (x_k - x_eq)."""
    run = imposed("mass_spring_damper", {"contact_damping": pad}, pushed_and_left, 0.5)
    x, v = column(run, "object"), column(run, "object_velocity")
    inertia = 2.0 * np.diff(v) / 1e-3
    assert run.force.min() < -1.0
    assert inertia == pytest.approx((-run.force - v - 300.0 * (x - 0.01))[:-1], abs=1e-10)

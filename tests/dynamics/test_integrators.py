"""The integrators agree with closed forms and with the exact motion."""

import math
from dataclasses import replace

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.integrators import INTEGRATORS, step
from tests.dynamics.reference_mass import World

SLIDER = {"mass": 0.05, "stiffness": 300.0, "x0": 0.010, "v0": 0.0}
STEPS = [4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.125e-3]
# largest error relative to x0 in 1 s of free decay with b = 0.4 N·s/m, for each step of STEPS
ERRORS = {
    "explicit_euler": (2180, 6.97, 0.473, 0.171, 0.0763, 0.0361),
    "lecture": (1920, 7.04, 0.476, 0.173, 0.0769, 0.0364),
    "semi_implicit": (0.168, 0.0794, 0.0390, 0.0194, 0.00967, 0.00483),
    "verlet": (0.0298, 7.39e-3, 1.84e-3, 4.61e-4, 1.15e-4, 2.88e-5),
    "trapezoid": (0.0568, 0.0142, 3.56e-3, 8.91e-4, 2.23e-4, 5.57e-5),
    "rk4": (5.5e-4, 3.4e-5, 2.1e-6, 1.3e-7, 8.4e-9, 5.2e-10),
    "implicit_euler": (0.473, 0.325, 0.203, 0.117, 0.0631, 0.0330),
    "exact": (0.0,) * 6,
}


def decay(t, damping, mass, stiffness, x0, v0):
    """Return the underdamped motion in closed form."""
    rate = damping / (2.0 * mass)
    omega = math.sqrt(stiffness / mass - rate * rate)
    return np.exp(-rate * t) * (x0 * np.cos(omega * t) + (v0 + rate * x0) / omega * np.sin(omega * t))


def largest_error(method, dt):
    t, x, _ = hs.integrate(method, damping=0.4, dt=dt, seconds=1.0, **SLIDER)
    return np.abs(x - decay(t, 0.4, **SLIDER)).max() / 0.010


@pytest.mark.parametrize("method", ERRORS)
def test_errors_agree_with_the_work_precision_chart(method):
    for dt, want in zip(STEPS, ERRORS[method], strict=True):
        assert largest_error(method, dt) == pytest.approx(want, rel=0.10, abs=1e-13), dt


@pytest.mark.parametrize("damping", [0.0, 1e-9, 0.3, 7.7459, 7.75, 40.0])
def test_exact_agrees_with_the_closed_form_from_no_damping_to_far_beyond_critical(damping):
    """The closed form solves x'' = (F - b x' - k x) / m by eigenvalues, which are complex or real."""
    given = {"mass": 0.05, "damping": damping, "stiffness": 300.0, "x0": 0.01, "v0": -0.2, "force": 0.9}
    t, x, v = hs.integrate("exact", **given, dt=3e-3, seconds=0.6)
    one, two = np.roots([0.05, damping, 300.0]).astype(complex)
    a = (-0.2 - two * (0.01 - 0.003)) / (one - two)
    b = 0.01 - 0.003 - a
    assert x == pytest.approx((0.003 + a * np.exp(one * t) + b * np.exp(two * t)).real, abs=1e-11)
    assert v == pytest.approx((a * one * np.exp(one * t) + b * two * np.exp(two * t)).real, abs=1e-9)


def test_rows_are_at_multiples_of_the_step_with_both_ends():
    t, x, v = hs.integrate("rk4", mass=1, damping=0, stiffness=1, x0=0.5, v0=-1, dt=0.1, seconds=1.0)
    assert t == pytest.approx(np.linspace(0.0, 1.0, 11), abs=1e-15)
    assert len(x) == len(v) == 11
    assert (x[0], v[0]) == (0.5, -1.0)
    assert len(hs.integrate("exact", mass=1, damping=0, stiffness=1, x0=0, v0=0, dt=0.1, seconds=0)[0]) == 1


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"mass": 0.0}, "Mass .*kg, not 0"),
        ({"damping": -1.0}, "Damping .*N·s/m, not −1"),
        ({"stiffness": math.nan}, "Stiffness .*N/m, not nan"),
        ({"dt": 0.0}, "dt .* s, not 0"),
        ({"seconds": 1e9}, "steps"),
        ({"x0": "far"}, "x0 must be a number in m"),
        *(({"method": name}, r"explicit_euler, lecture, .*exact, not") for name in ("euler", "", None, 2.5)),
    ],
)
def test_invalid_motions_give_a_one_line_error(wrong, text):
    given = {"method": "rk4", "damping": 0.0, "dt": 1e-3, "seconds": 0.1} | SLIDER | wrong
    with pytest.raises(hs.ParameterError, match=text) as caught:
        hs.integrate(**given)
    assert "\n" not in str(caught.value)


OF = {name: float(n) for n, name in enumerate(INTEGRATORS)}

# ratio of energies after and before a bounce off a spring, at three omega dt: (mean over the phase, range)
BOUNCES = {
    "explicit_euler": ((1.275, None), (1.624, None), (2.610, None)),
    "lecture": ((1.275, None), (1.618, None), (2.536, None)),
    "semi_implicit": ((1.0, 0.0015), (1.0, 0.0045), (1.0, 0.008)),
    "verlet": ((1.0, 0.0015), (1.0, 0.0045), (1.0, 0.008)),
    "rk4": ((1.0, 0.0006), (1.0, 0.003), (1.0, 0.007)),
    "implicit_euler": ((0.784, None), (0.616, None), (0.383, None)),
    "exact": ((1.0, 0.0), (1.0, 0.0), (1.0, 0.0)),
}


def bounce(method, dt, phase):
    """Return the energy of 0.05 kg after a bounce off a spring of 300 N/m, divided by the energy before."""
    world = World(m=0.05, reach=0.01, wall=300.0)
    x, v, before = 0.01 - (1.0 + phase) * 0.1 * dt, 0.1, 0.0
    for _ in range(round(0.1 / dt)):
        x, v, before = step(OF[method], x, v, before, dt, 0.0, *world.numbers)
    assert x < 0.01
    return (v / 0.1) ** 2


def bounces(method, dt):
    return np.array([bounce(method, dt, phase) for phase in np.arange(0.005, 1.0, 0.01)])


@pytest.mark.parametrize("method", BOUNCES)
def test_the_energy_of_a_bounce_agrees_with_the_table(method):
    for dt, (mean, reach) in zip((1e-3, 2e-3, 4e-3), BOUNCES[method], strict=True):
        found = bounces(method, dt)
        assert found.mean() == pytest.approx(mean, rel=2e-3), dt
        if reach is not None:
            off = [1.0 - found.min(), found.max() - 1.0]
            assert off == pytest.approx([reach, reach], rel=0.25, abs=1e-11), dt


@pytest.mark.parametrize("method", INTEGRATORS)
def test_friction_stops_it_permanently(method):
    """The mass stops after m v / F_c = 20 ms and v^2 m / (2 F_c) = 1 mm.

    A force below F_c does not move the mass again.
    """
    world = World(m=0.1, f=0.0)
    x, v, before, seen = 0.0, 0.1, 0.0, []
    for _ in range(40):
        x, v, before = step(OF[method], x, v, before, 1e-3, 0.5, *world.numbers)
        seen.append((x, v))
    assert seen[9][1] == pytest.approx(0.05, abs=1e-12)
    assert seen[25] == seen[-1]
    assert v == 0.0
    off = 0.0 if method not in ("explicit_euler", "semi_implicit", "implicit_euler") else 0.5 * 0.1 * 1e-3
    assert abs(x - 1e-3) == pytest.approx(off, abs=1e-9)
    pulled = replace(world, f=0.499)
    for _ in range(20):
        q, v, before = step(OF[method], x, v, before, 1e-3, 0.5, *pulled.numbers)
        assert (q, v) == (pytest.approx(x, abs=1e-12), 0.0)
    away = step(OF[method], x, 0.0, 0.501 / 0.1, 1e-3, 0.5, *replace(world, f=0.501).numbers)
    assert away[1] == pytest.approx(0.001 / 0.1 * 1e-3, rel=1e-6)

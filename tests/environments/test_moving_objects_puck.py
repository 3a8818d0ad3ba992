"""The puck as a scene: momentum, energy, friction, and on which side of it the handle is."""

import numpy as np
import pytest

from hapkit_studio.dynamics.integrators import INTEGRATORS
from tests.environments.calling import LIBRARY, call
from tests.environments.imposed import column, imposed, smoothly

PUCK = LIBRARY["puck"]


def shove(t):
    """Against the puck from the left, and far away before it comes back."""
    return smoothly(t, -0.01, 0.018, 0.12) if t < 0.12 else smoothly(t - 0.12, 0.018, -0.3, 0.1)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_push_gives_the_puck_its_impulse(method):
    """m v = the force summed over the samples; to the last digit where a step takes just that force."""
    run = imposed("puck", {"integrator": method}, shove, 0.16)
    momentum = 0.5 * column(run, "object_velocity")[-1]
    impulse = -run.force.sum() * 1e-3
    assert run.force[-1] == 0.0
    assert momentum > 0.03
    exactly = method in ("explicit_euler", "semi_implicit")
    assert impulse == pytest.approx(momentum, rel=1e-12 if exactly else 0.03)


def test_a_steady_push_throws_the_puck_off_at_twice_its_speed():
    """An elastic blow of something that does not slow down, in the limit of short periods."""
    for rate, off in ((1000.0, 0.08), (16_000.0, 0.005)):
        values = {"integrator": "exact", "contact_stiffness": 500.0}
        run = imposed("puck", values, lambda t: min(0.1 * t, 0.02), 0.15, rate)
        fastest = column(run, "object_velocity").max()
        assert fastest == pytest.approx(0.2, rel=off)


def bounces(method, wall, rate=1000.0, seconds=8.0):
    """Return the energies of a puck of 0.05 kg between its bounces off two walls, after one shove."""
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
    """Off 300 N/m at 1 kHz, omega dt = 0.0775."""
    energy = bounces(method, 300.0, seconds=1.6 if gain > 1.1 else 4.0)
    ratio = (energy[7] / energy[0]) ** (1.0 / 7.0) if gain != 1.0 else energy / energy[0]
    assert ratio == pytest.approx(gain, abs=tolerance)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_friction_stops_the_puck_and_it_stays(method):
    """Off the handle it slides on by m v^2 / (2 F_c); where a step is only projected, to half a step of v."""
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
    """Through the middle it pushes on to where it came from; beyond the far edge it is on the other side."""
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

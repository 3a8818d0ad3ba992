"""The stability limits of each integrator for a mass on a spring, and its growth beyond them."""

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio.dynamics.integrator_stability import longest_step, spectral_radius
from hapkit_studio.dynamics.integrators import INTEGRATORS
from tests.dynamics import growth

RATIOS = (0.01, 0.05, 0.2, 0.5, 1.0, 2.0)


# limits of ω dt, one for each of the damping ratios above
TABLE = {
    "explicit_euler": (0.02, 0.10, 0.40, 1.0, 2.0, 0.536),
    "lecture": (0.02, 0.0998, 0.384, 0.764, 0.764, 0.469),
    "semi_implicit": (1.980, 1.903, 1.640, 1.236, 0.828, 0.472),
    "verlet": (2.0, 2.0, 2.0, 2.0, 2.0, 2.0),
    "rk4": (2.849, 2.910, 2.940, 2.623, 2.785, 0.746),
}


def amplitudes(method, ratio, step, count=200_000):
    """Return the largest |(x, v)| of the first and of the last 100 samples of x'' = -x - 2 ratio x'."""
    given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "x0": 1.0, "v0": 0.3}
    _, x, v = hs.integrate(method, dt=step, seconds=step * count, **given)
    with np.errstate(over="ignore"):
        return np.hypot(x[:100], v[:100]).max(), np.hypot(x[-100:], v[-100:]).max()


@pytest.mark.slow
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("method", TABLE)
def test_motion_decays_just_below_the_limit_and_grows_just_above(method, ratio):
    limit = longest_step(method, 1.0, 2.0 * ratio, 1.0)
    before, after = amplitudes(method, ratio, 0.99 * limit)
    assert after < 0.9 * before
    before, after = amplitudes(method, ratio, 1.01 * limit)
    assert not after < 1.1 * before


@pytest.mark.parametrize("method", TABLE)
def test_limits_agree_with_the_table(method):
    """A mass of 0.2 kg on 500 N/m has omega = 50 1/s and b = 20 ratio."""
    got = [50.0 * longest_step(method, 0.2, 20.0 * ratio, 500.0) for ratio in RATIOS]
    assert got == pytest.approx(TABLE[method], abs=1.5e-3)


@pytest.mark.parametrize(
    ("method", "limit"),
    [("semi_implicit", 2.0), ("verlet", 2.0), ("rk4", 8**0.5), ("explicit_euler", 0.0), ("lecture", 0.0)],
)
def test_without_damping_motion_stays_bounded_up_to_the_limit(method, limit):
    if limit:
        before, after = amplitudes(method, 0.0, 0.99 * limit)
        assert after < 1.001 * before
    before, after = amplitudes(method, 0.0, 1.01 * limit or 0.01)
    assert not after < 1e3 * before


@pytest.mark.parametrize("ratio", [0.0, 0.05, 2.0])
@pytest.mark.parametrize("step", [0.1, 1000.0])
@pytest.mark.parametrize("method", ["implicit_euler", "trapezoid", "exact"])
def test_implicit_and_exact_integrators_never_grow(method, step, ratio):
    """With these integrators, the energy never increases, whatever the step."""
    given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "x0": 1.0, "v0": 0.3}
    _, x, v = hs.integrate(method, dt=step, seconds=2000 * step, **given)
    energy = x * x + v * v
    assert np.all(energy[1:] <= energy[:-1] * (1.0 + 1e-12))


@pytest.mark.parametrize(("ratio", "step"), [(0.0, 0.0775), (0.05, 0.3), (0.2, 0.5), (1.0, 0.9), (0.7, 0.82)])
def test_the_lectures_rule_agrees_with_its_characteristic_polynomial(ratio, step):
    """The growth is the largest root of z^3 + (h^2/4 + r h - 2) z^2 + (1 + h^2/2) z + (h^2/4 - r h) = 0.

    The samples satisfy the corresponding recurrence. h is the step, r the damping ratio.
    """
    h2 = step * step
    polynomial = [1.0, h2 / 4.0 + ratio * step - 2.0, 1.0 + h2 / 2.0, h2 / 4.0 - ratio * step]
    given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "x0": 1.0, "v0": 0.3}
    x = hs.integrate("lecture", dt=step, seconds=300 * step, **given)[1]
    rows = np.column_stack([x[3:], x[2:-1], x[1:-2], x[:-3]])
    assert np.abs(rows @ polynomial).max() < 1e-13 * np.abs(rows).max()
    largest = np.abs(np.roots(polynomial)).max()
    if ratio < 0.5:
        assert growth.per_sample(x[30:150]) == pytest.approx(largest, rel=1e-6)


COURSE = {"mass": 2.0, "damping": 1.0, "x0": 0.01, "v0": 0.0, "seconds": 4.0}


@pytest.mark.parametrize("method", INTEGRATORS)
@pytest.mark.parametrize(
    ("case", "stiffness", "dt"), [(0, 300.0, 1e-3), (1, 1300.0, 1e-3), (2, 1300.0, 1 / 230)]
)
def test_the_growth_of_the_course_s_mass_agrees_with_its_table(method, case, stiffness, dt):
    x = hs.integrate(method, stiffness=stiffness, dt=dt, **COURSE)[1]
    assert growth.rate(x[20:], dt) == pytest.approx(growth.COURSE_RATES[method][case], rel=0.02)


@pytest.mark.parametrize("ratio", [0.0, 0.0291, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("method", [method for method in INTEGRATORS if method != "lecture"])
def test_the_spectral_radius_is_that_of_one_rendered_step(method, ratio):
    """The columns of a step's matrix are the results of one step from (x, v) = (1, 0) and from (0, 1)."""
    for step in (0.05, 0.7, 1.9, 2.4, 3.5):
        given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "dt": step, "seconds": step}
        columns = [hs.integrate(method, x0=x0, v0=1.0 - x0, **given)[1:] for x0 in (1.0, 0.0)]
        largest = np.abs(np.linalg.eigvals([[x[-1] for x, _ in columns], [v[-1] for _, v in columns]])).max()
        assert spectral_radius(method, step, ratio) == pytest.approx(largest, rel=1e-7)


def test_the_spectral_radius_accepts_grids():
    step, ratio = np.linspace(0.1, 3.0, 7), np.array([[0.1], [0.5], [2.0]])
    for method in INTEGRATORS:
        grid = spectral_radius(method, step, ratio)
        assert grid.shape == (3, 7)
        assert grid[2, 4] == spectral_radius(method, step[4], 2.0)


@pytest.mark.parametrize(
    ("damping", "longest"), [(0.0582, 2.88139), (0.0, 8**0.5), (2.0, 2.785294), (10.0, 0.281372)]
)
def test_rk4_s_longest_step_is_the_root_of_its_amplification_polynomial(damping, longest):
    """The companion matrix solves |1 + z + z²/2 + z³/6 + z⁴/24|² = 1 as a polynomial in the step."""
    assert longest_step("rk4", 1.0, damping, 1.0) == pytest.approx(longest, rel=1e-6)
    roots = []
    for value in np.roots([1.0, damping, 1.0]):
        factor = np.array([value**4 / 24.0, value**3 / 6.0, value**2 / 2.0, value, 1.0])
        found = np.roots(np.polysub(np.polymul(factor, factor.conj()), [1.0])[:-1])
        roots += [z.real for z in found if abs(z.imag) < 1e-9 and z.real > 1e-3]
    assert longest_step("rk4", 1.0, damping, 1.0) == pytest.approx(min(roots), rel=1e-9)

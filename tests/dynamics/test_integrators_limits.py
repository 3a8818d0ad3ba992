"""Where each integrator of a mass on a spring stops decaying, and how fast it grows beyond."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import hapkit_studio as hs
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.step_limits import longest_step
from tests.dynamics import growth

RATIOS = (0.01, 0.05, 0.2, 0.5, 1.0, 2.0)


def explicit_euler(ratio):
    return 2.0 * ratio if ratio <= 1.0 else 2.0 / (ratio + math.sqrt(ratio * ratio - 1.0))


def lecture(ratio):
    return (1.0 + 2.0 * ratio**2 - math.sqrt(1.0 + 4.0 * ratio**4)) / ratio


def semi_implicit(ratio):
    return 2.0 * (math.sqrt(1.0 + ratio * ratio) - ratio)


def verlet(ratio):
    return 2.0


def rk4(ratio):
    """Return where 1 + z + z^2/2 + z^3/6 + z^4/24 leaves the unit circle, z = step times eigenvalue."""

    def beyond(step):
        z = step * np.roots([1.0, 2.0 * ratio, 1.0])
        return np.abs(1.0 + z + z**2 / 2.0 + z**3 / 6.0 + z**4 / 24.0).max() - 1.0

    longest = np.arange(0.01, 4.0, 0.01)
    first = longest[np.argmax([beyond(step) > 0.0 for step in longest])]
    return brentq(beyond, first - 0.01, first)


LIMITS = {f.__name__: f for f in (explicit_euler, lecture, semi_implicit, verlet, rk4)}


def amplitudes(method, ratio, step, count=200_000):
    """Return the largest |(x, v)| of the first and of the last 100 samples of x'' = -x - 2 ratio x'."""
    given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "x0": 1.0, "v0": 0.3}
    _, x, v = hs.integrate(method, dt=step, seconds=step * count, **given)
    with np.errstate(over="ignore"):
        size = np.hypot(x, v)
    return size[:100].max(), size[-100:].max()


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("method", LIMITS)
def test_decays_just_inside_its_limit_and_grows_just_outside(method, ratio):
    limit = LIMITS[method](ratio)
    before, after = amplitudes(method, ratio, 0.99 * limit)
    assert after < 0.9 * before
    before, after = amplitudes(method, ratio, 1.01 * limit)
    assert not after < 1.1 * before


def test_limits_are_those_of_the_table():
    """Columns 0.01, 0.05, 0.2, 0.5, 1, 2."""
    table = {
        "explicit_euler": (0.02, 0.10, 0.40, 1.0, 2.0, 0.536),
        "lecture": (0.02, 0.0998, 0.384, 0.764, 0.764, 0.469),
        "semi_implicit": (1.980, 1.903, 1.640, 1.236, 0.828, 0.472),
        "rk4": (2.849, 2.910, 2.940, 2.623, 2.785, 0.746),
    }
    for method, row in table.items():
        for ratio, want in zip(RATIOS, row, strict=True):
            assert LIMITS[method](ratio) == pytest.approx(want, abs=6e-4), (method, ratio)


@pytest.mark.parametrize("ratio", [1e-6, *RATIOS, 5.0])
@pytest.mark.parametrize("method", LIMITS)
def test_the_longest_step_is_the_limit(method, ratio):
    """Of 0.2 kg on 500 N/m: omega = 50 1/s, b = 20 ratio."""
    got = longest_step(method, 0.2, 20.0 * ratio, 500.0)
    tolerance = 1e-3 if method == "rk4" or ratio < 1e-3 else 1e-9
    assert got == pytest.approx(LIMITS[method](ratio) / 50.0, rel=tolerance)


@pytest.mark.parametrize("method", ["implicit_euler", "trapezoid", "exact"])
def test_there_is_no_longest_step_where_nothing_grows(method):
    assert longest_step(method, 0.2, 0.0, 500.0) == math.inf


@pytest.mark.parametrize(
    ("method", "limit"), [("semi_implicit", 2.0), ("verlet", 2.0), ("rk4", 2.0 * 2**0.5)]
)
def test_without_damping_they_stay_bounded_up_to_their_limit(method, limit):
    before, after = amplitudes(method, 0.0, 0.99 * limit)
    assert after < 1.001 * before
    before, after = amplitudes(method, 0.0, 1.01 * limit)
    assert not after < 1e3 * before


@pytest.mark.parametrize("method", ["explicit_euler", "lecture"])
def test_without_damping_the_explicit_ones_grow_at_any_step(method):
    before, after = amplitudes(method, 0.0, 0.01)
    assert after > 1e3 * before


@pytest.mark.parametrize("ratio", [0.0, *RATIOS])
@pytest.mark.parametrize("step", [0.1, 1.0, 10.0, 1000.0])
@pytest.mark.parametrize("method", ["implicit_euler", "trapezoid", "exact"])
def test_the_implicit_ones_and_exact_never_grow(method, step, ratio):
    """Their energy never rises, at any step."""
    given = {"mass": 1.0, "damping": 2.0 * ratio, "stiffness": 1.0, "x0": 1.0, "v0": 0.3}
    _, x, v = hs.integrate(method, dt=step, seconds=2000 * step, **given)
    energy = x * x + v * v
    assert np.all(energy[1:] <= energy[:-1] * (1.0 + 1e-12))


@pytest.mark.parametrize(("ratio", "step"), [(0.0, 0.0775), (0.05, 0.3), (0.2, 0.5), (1.0, 0.9), (0.7, 0.82)])
def test_lecture_follows_its_characteristic_polynomial(ratio, step):
    """z^3 + (h^2/4 + r h - 2) z^2 + (1 + h^2/2) z + (h^2/4 - r h) = 0, sample by sample and in its growth."""
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
def test_the_course_s_mass_grows_as_its_table_says(method, case, stiffness, dt):
    x = hs.integrate(method, stiffness=stiffness, dt=dt, **COURSE)[1]
    assert growth.rate(x[20:], dt) == pytest.approx(growth.COURSE_RATES[method][case], rel=0.02)


@pytest.mark.parametrize(
    ("method", "free", "contact"),
    [
        ("explicit_euler", 3.33e-3, 0.77e-3),
        ("lecture", 3.33e-3, 0.77e-3),
        ("semi_implicit", 160e-3, 77.7e-3),
        ("verlet", 163e-3, 78.4e-3),
        ("rk4", 234e-3, 112e-3),
    ],
)
def test_the_course_s_longest_steps(method, free, contact):
    for stiffness, longest in ((300.0, free), (1300.0, contact)):
        omega = math.sqrt(stiffness / 2.0)
        limit = LIMITS[method](0.5 / math.sqrt(2.0 * stiffness)) / omega
        assert limit == pytest.approx(longest, rel=6e-3)
        assert growth.rate(hs.integrate(method, stiffness=stiffness, dt=0.9 * limit, **COURSE)[1], 1.0) < 0.0

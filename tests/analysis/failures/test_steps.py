"""Integrators at their limits, and the course's mass–spring–damper as the tick renders it."""

import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.course import rate_of, swing
from hapkit_studio.analysis.failures.integrators import growth_per_radian
from hapkit_studio.dynamics.integrators import INTEGRATORS
from tests.dynamics.growth import COURSE_RATES

INTEGRATOR, COURSE = failures()["integrators"], failures()["course"]
# ω dt at ζ = 0.01, 0.05, 0.2, 0.5, 1, 2
TABLE = {
    "explicit_euler": (0.02, 0.10, 0.40, 1.0, 2.0, 0.536),
    "lecture": (0.02, 0.0998, 0.384, 0.764, 0.764, 0.469),
    "semi_implicit": (1.980, 1.903, 1.640, 1.236, 0.828, 0.472),
    "verlet": (2.0, 2.0, 2.0, 2.0, 2.0, 2.0),
    "rk4": (2.849, 2.910, 2.940, 2.623, 2.785, 0.746),
}


@pytest.mark.parametrize("method", TABLE)
def test_one_percent_inside_decays_and_outside_grows_at_six_damping_ratios(method):
    for ratio, want in enumerate(TABLE[method]):
        case = INTEGRATOR.case({"method": method, "ratio": ratio})
        assert INTEGRATOR.limit(case) == pytest.approx(want, abs=1.5e-3)
        assert INTEGRATOR.probe(INTEGRATOR.inside(case), case).holds, ratio
        assert not INTEGRATOR.probe(INTEGRATOR.outside(case), case).holds, ratio


def test_the_growth_without_error_is_the_damping_ratio():
    for ratio in (0.01, 0.3, 0.9):
        assert growth_per_radian("exact", ratio, 0.7) == pytest.approx(-ratio, rel=1e-12)
        assert growth_per_radian("verlet", ratio, 1e-3) == pytest.approx(-ratio, abs=1e-3)


@pytest.mark.parametrize("method", INTEGRATORS)
def test_the_course_s_mass_in_contact_grows_as_its_table_says(method):
    """Rendered, the handle held still: at 1 ms and at 230 Hz; the truth is −0.25 1/s."""
    for column, step in ((1, 1e-3), (2, 1.0 / 230.0)):
        rate = rate_of(swing(method, step), step)
        assert rate == pytest.approx(COURSE_RATES[method][column], rel=0.02, abs=2e-3), step


def test_at_1_ms_the_lecture_s_rule_grows_by_0_075_and_semi_implicit_holds():
    found = COURSE.try_at(1e-3, {"method": "lecture"})
    assert not found.holds
    assert found.measure == pytest.approx(0.075, abs=5e-4)
    assert COURSE.try_at(1e-3, {"method": "semi_implicit"}).measure == pytest.approx(-0.25, abs=1e-3)


@pytest.mark.parametrize(
    ("method", "longest"),
    [
        ("explicit_euler", 0.769e-3),
        ("lecture", 0.769e-3),
        ("semi_implicit", 77.7e-3),
        ("verlet", 78.4e-3),
        ("rk4", 112e-3),
    ],
)
def test_the_course_s_longest_steps_in_contact(method, longest):
    case = COURSE.case({"method": method})
    assert COURSE.limit(case) == pytest.approx(longest, rel=3e-3)
    assert COURSE.probe(COURSE.inside(case), case).holds
    assert not COURSE.probe(COURSE.outside(case), case).holds

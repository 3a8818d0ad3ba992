"""Integrators at their limits, and the course's mass–spring–damper as rendered by the tick."""

import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.course import rate_of, swing
from hapkit_studio.analysis.failures.integrators import growth_per_radian
from tests.dynamics.growth import COURSE_RATES

# longest stable steps in s of the course's mass in contact, by integrator
LONGEST = {
    "explicit_euler": 0.769e-3, "lecture": 0.769e-3, "semi_implicit": 77.7e-3, "verlet": 78.4e-3,
    "rk4": 112e-3,
}  # fmt: skip
INTEGRATOR, COURSE = failures()["integrators"], failures()["course"]


@pytest.mark.parametrize("method", ["explicit_euler", "lecture", "exact"])
def test_the_growth_of_the_course_s_mass_in_contact_agrees_with_its_table(method):
    """The rendered mass grows at 1 ms and at 230 Hz as in the table; its exact growth is −0.25 1/s.

    The handle is held still.
    """
    for column, step in ((1, 1e-3), (2, 1.0 / 230.0)):
        rate = rate_of(swing(method, step), step)
        assert rate == pytest.approx(COURSE_RATES[method][column], rel=0.02, abs=2e-3), step


def test_the_exact_growth_is_the_damping_ratio():
    for ratio in (0.01, 0.3, 0.9):
        assert growth_per_radian("exact", ratio, 0.7) == pytest.approx(-ratio, rel=1e-12)
        assert growth_per_radian("verlet", ratio, 1e-3) == pytest.approx(-ratio, abs=1e-3)


def test_the_longest_stable_steps_in_contact_are_those_of_the_course():
    for method, longest in LONGEST.items():
        case = COURSE.case({"method": method})
        assert COURSE.limit(case) == pytest.approx(longest, rel=3e-3)
        assert COURSE.probe(COURSE.inside(case), case).holds
        assert not COURSE.probe(COURSE.outside(case), case).holds

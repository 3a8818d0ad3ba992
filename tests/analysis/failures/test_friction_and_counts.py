"""Diolaiti's regions, the largest push that friction stops, and the chatter of friction."""

import math

import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.chatter import peak_to_peak
from hapkit_studio.analysis.failures.large_push import amplitude, measured, swing
from hapkit_studio.analysis.failures.spring import CYCLES, GROWS, RESTS, judged, released_with_friction
from hapkit_studio.environments.friction import COULOMB, PROJECTION

# A mass of 0.05 kg on a spring of 1000 N/m at 1 kHz with counts of 20 µm, released 3.3 counts from
# equilibrium. Columns: peak-to-peak motion at the end, in counts, at σ = 0, 0.1, 0.25, 0.4
REGIONS = {
    0.6: (1.68, 0.24, 0.02, 0.01),
    1.0: (0.94, 0.19, 0.03, 0.01),
    2.0: (0.50, 0.15, 0.03, 0.004),
}
SIGMAS = (0.0, 0.1, 0.25, 0.4)


def region(beta, sigma, counts):
    """Return the outcome of a release, and the peak-to-peak motion in counts at its end."""
    start = counts * 20e-6
    x = released_with_friction(0.05, beta, sigma * 1000.0 * 20e-6, 20e-6, 1000.0, 1000.0, start)
    word, size = judged(x, start, 1000.0)
    return word, size / 20e-6


@pytest.mark.parametrize("beta", [0.25, 0.4, 0.6, 1.0, 2.0])
def test_releases_end_as_in_diolaitis_regions(beta):
    """If friction exceeds the spring's force over half a count (σ > 1/2), the handle comes to rest.

    With too little damping, a large displacement grows at any friction.
    """
    for sigma, want in zip(SIGMAS, REGIONS.get(beta, ()), strict=False):
        word, size = region(beta, sigma, 3.3)
        assert word == CYCLES
        assert size == pytest.approx(want, rel=0.03, abs=0.01), sigma
    assert region(beta, 0.495, 3.3)[0] == CYCLES
    for sigma in (0.505, 0.55, 1.0, 2.0):
        assert region(beta, sigma, 3.3) == (RESTS, 0.0), sigma
    for sigma in (0.0, 0.25, 0.4, 0.55, 1.0, 2.0):
        word = GROWS if beta < 0.5 else RESTS if sigma > 0.5 else CYCLES
        assert region(beta, sigma, 200.3)[0] == word, sigma


def test_the_push_that_friction_stops_agrees_with_the_table():
    """The energy balance over a cycle gives a push that is 0.5 to 2 % smaller."""
    for stiffness, viscous, coulomb, simulated in (
        (2000.0, 0.5, 0.2, 2.573),
        (2000.0, 0.8, 0.2, 6.495),
        (4000.0, 1.0, 0.5, 2.297),
        (1000.0, 0.2, 0.1, 3.015),
    ):
        case = {"mass": 0.05, "viscous": viscous, "coulomb": coulomb, "rate": 1000.0}
        balance = 4.0 * coulomb / (math.pi * math.sqrt(stiffness / 0.05) * (0.5e-3 * stiffness - viscous))
        for found in (amplitude(case, stiffness), measured(case, stiffness)):
            assert 1e3 * found == pytest.approx(simulated, abs=6e-4)
            assert 0.979 * found < balance < found


@pytest.mark.parametrize(
    ("stiffness", "mass", "viscous", "coulomb", "rate"),
    [
        # the growth rate is 0.1 1/s, so settling 1 % beside the limit takes ln(100)/0.1 = 45 s
        (1020.0, 0.044, 0.5, 0.02, 1000.0),
        (1005.0, 1.0, 0.5, 0.02, 1000.0),  # the growth rate is 0.001 1/s, so 300 s show only the trend
        (8000.0, 0.005, 2.0, 0.1, 1000.0),  # the frequency is high: ω T = 1.1
    ],
)
def test_one_percent_less_push_settles_and_one_percent_more_grows(stiffness, mass, viscous, coulomb, rate):
    case = {"mass": mass, "viscous": viscous, "coulomb": coulomb, "rate": rate, "stiffness": stiffness}
    most = amplitude(case, stiffness)
    assert swing(0.99 * most, case)[1] == (RESTS if mass < 1.0 else CYCLES)
    assert swing(1.01 * most, case)[1] == GROWS


@pytest.mark.parametrize("late", ["none", "one_period"])
@pytest.mark.parametrize("mass", [0.02, 0.044, 0.1])
def test_friction_by_the_sign_of_counts_chatters_beyond_its_force_and_projection_sticks(mass, late):
    failure = failures()["chatter"]
    case = failure.case({"mass": mass, "late": late, "viscous": 10.0 * mass})
    assert failure.probe(failure.inside(case), case).holds
    assert not failure.probe(failure.outside(case), case).holds
    held, plain = (peak_to_peak(failure.outside(case), case, model)[0] for model in (PROJECTION, COULOMB))
    assert held <= 0.01
    assert plain > 2.0

"""Tests of undersampling in time and space, and of jitter: textures, bumps, repeated periods, bounces."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.failures import failures, stroking
from hapkit_studio.analysis.failures.bounce import off, rendered, stiffness_of
from hapkit_studio.analysis.failures.jitter import exact, nominal, pattern, worst
from hapkit_studio.analysis.failures.tunnelling import least_peak, throws
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.haptics import rows

JITTER = failures()["jitter"]


def sides(failure, case):
    """Return a failure's evidence just inside and just outside its limit."""
    return [failure.probe(value, case) for value in (failure.inside(case), failure.outside(case))]


def test_ridges_are_too_steep_from_the_theoretical_amplitude_on():
    failure = failures()["texture_steepness"]
    for wavelength, rate, amplitude in (
        (0.001, 1000.0, 0.159), (0.002, 1000.0, 0.318), (0.005, 1000.0, 0.796), (0.001, 4000.0, 0.637),
    ):  # fmt: skip
        case = failure.case({"wavelength": wavelength, "rate": rate})
        assert failure.limit(case) == pytest.approx(amplitude, rel=4e-3)
        assert [one.holds for one in sides(failure, case)] == [True, False]


def test_beyond_half_the_rate_the_pitch_falls_with_the_speed():
    failure = failures()["texture_speed"]
    found = [failure.try_at(speed).measure for speed in (0.3, 0.495, 0.505, 0.7, 0.9)]
    assert found == pytest.approx([300.0, 495.0, 495.0, 300.0, 100.0], abs=0.5)


def test_ten_counts_per_ridge_give_the_theoretical_steps_of_the_force():
    failure = failures()["texture_counts"]
    assert [one.measure for one in sides(failure, failure.case())] == [10.0, 9.0]
    out = stroking.stroke(0.005, 0.005, 1000.0, 15e-6, 5000)
    steps = np.abs(np.diff(out[:, rows.FORCE])).max()
    assert steps == pytest.approx(2.0 * math.pi * 0.25 * 15e-6 / 0.005, rel=1e-3)


def test_a_bump_of_width_w_needs_a_speed_below_w_over_4_t():
    """A width of 5 mm has a limit of 1.25 m/s at 1 kHz, and of 0.29 m/s at 230 Hz."""
    failure = failures()["tunnelling"]
    for rate, speed in ((1000.0, 1.25), (230.0, 0.2875)):
        case = failure.case({"rate": rate})
        assert failure.limit(case) == pytest.approx(speed, rel=1e-12)
        assert [one.measure for one in sides(failure, case)] == [4.0, 3.0]
    case = failure.case()
    assert least_peak(throws(1.25, case)) == pytest.approx(math.sqrt(0.5), abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(("usual", "long", "viscous"), [(1, 5, 0.5), (3, 2, 0.5), (60, 8, 0.5), (200, 20, 1)])
def test_a_pattern_decays_inside_its_exact_limit_and_grows_outside(usual, long, viscous):
    case = JITTER.case({"usual": usual, "long": long, "viscous": viscous})
    assert [one.holds for one in sides(JITTER, case)] == [True, False]
    assert worst(case) < JITTER.limit(case) < nominal(case)
    for part in (0.99, 1.01):
        rate = exact(part * JITTER.limit(case), case, pattern(case))
        assert (rate < 0.0) == (part < 1.0)


def test_below_the_limit_of_the_longest_period_every_order_of_periods_is_stable(rng):
    """A spring of 2 b/T, where T is the longest period, is stable in 200 random sequences of periods."""
    case, lengths = JITTER.case(), (1e-3, 1.5e-3, 2e-3, 5e-3)
    limits = {t: stiffness_limit(case["mass"], case["viscous"], rate=1.0 / t) for t in lengths}
    for _ in range(200):
        periods = tuple(rng.choice(lengths, size=rng.integers(1, 40)))
        assert exact(0.99 * limits[max(periods)], case, periods) < 0.0


BOUNCE = failures()["bounce"]
# Handle of 0.05 kg at 1 kHz. Columns: stiffness K in N/m; delay in periods; errors of the formula in % for a
# damping b of 0, 1/2, 1 and 3/2 times K (T/2 + td).
LEAVES = [
    (300.0, 0, (0.01, 0.3, 0.6, 0.9)),
    (300.0, 1, (0.15, 2.0, 3.7, 5.6)),
    (1000.0, 0, (0.06, 1.0, 2.1, 3.0)),
    (1000.0, 1, (0.9, 7.1, 13.3, 19.8)),
    (3000.0, 0, (0.3, 3.4, 6.5, 9.6)),
]


@pytest.mark.parametrize(("stiffness", "late", "table"), LEAVES)
def test_the_formulas_error_for_a_damped_handle_agrees_with_the_table(stiffness, late, table):
    """Without damping, the formula is within 1 % up to a lateness of 0.4 periods."""
    case = BOUNCE.case({"mass": 0.05, "late": late})
    lateness = math.sqrt(stiffness / 0.05) * 1e-3 * (1 + 2 * late)
    assert stiffness_of(lateness, case) == pytest.approx(stiffness)
    found = [100.0 * off(lateness, case, rendered(lateness, case, b), b) for b in (0.0, 0.5, 1.0, 1.5)]
    assert found == pytest.approx(table, rel=0.06, abs=0.02)
    assert lateness < 0.43
    assert abs(found[0]) < 1.0

"""The energy of a bounce: exact between events, rendered, and by the formula where that holds."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.failures import bounce, failures
from hapkit_studio.analysis.failures.bounce import exact, off, rendered, stiffness_of

BOUNCE = failures()["bounce"]
# 0.05 kg, 1 kHz: K, delay in periods, by how many % the formula is off at b = 0, 1/2, 1, 3/2 of K (T/2 + td)
LEAVES = [
    (300.0, 0, (0.01, 0.3, 0.6, 0.9)),
    (300.0, 1, (0.15, 2.0, 3.7, 5.6)),
    (1000.0, 0, (0.06, 1.0, 2.1, 3.0)),
    (1000.0, 1, (0.9, 7.1, 13.3, 19.8)),
    (3000.0, 0, (0.3, 3.4, 6.5, 9.6)),
]
SHARES = (0.0, 0.5, 1.0, 1.5)


def case_of(stiffness, late):
    """Return the case of 0.05 kg, and the lateness that is this stiffness."""
    case = BOUNCE.case({"mass": 0.05, "late": late})
    lateness = math.sqrt(stiffness / 0.05) * 1e-3 * (1 + 2 * late)
    assert stiffness_of(lateness, case) == pytest.approx(stiffness)
    return lateness, case


@pytest.mark.parametrize(("stiffness", "late", "table"), LEAVES)
def test_the_formula_leaves_a_damped_handle_by_what_the_table_says(stiffness, late, table):
    lateness, case = case_of(stiffness, late)
    found = [100.0 * off(lateness, case, rendered(lateness, case, share), share) for share in SHARES]
    assert found == pytest.approx(table, rel=0.06, abs=0.02)


@pytest.mark.parametrize(("stiffness", "late", "table"), LEAVES)
def test_it_is_within_1_percent_without_damping_up_to_a_lateness_of_0_4(stiffness, late, table):
    """With a damper in contact alone, too."""
    lateness, case = case_of(stiffness, late)
    assert lateness < 0.43
    assert abs(off(lateness, case, rendered(lateness, case))) < 0.01
    for share in SHARES[1:]:
        assert abs(off(lateness, case, exact(lateness, case, share), share)) < 0.01


@pytest.mark.parametrize("late", [0.0, 0.3, 1.0, 2.0])
def test_without_damping_the_tick_renders_the_exact_bounce(late):
    for stiffness in (300.0, 3000.0):
        for phase in (0.01, 0.4, 0.93):
            given = (stiffness, 1000.0, late * 1e-3, phase)
            want = bounce.exact_gain(0.05, 0.0, *given)
            assert bounce.rendered_gain(0.05, *given) == pytest.approx(want, rel=1e-11)


def test_a_fast_loop_takes_what_a_damper_in_contact_takes():
    """In the limit of no sampling: exp(−π ζ/√(1−ζ²)) of speed, times the way to zero depth."""
    mass, stiffness, damping = 0.05, 300.0, 0.4
    gain = bounce.exact_gain(mass, damping, stiffness, 200_000.0, 0.0, 0.5)
    omega = math.sqrt(stiffness / mass)
    ratio = damping / (2.0 * mass * omega)
    want = math.exp(-2.0 * math.pi * ratio / math.sqrt(1.0 - ratio * ratio))
    assert gain == pytest.approx(want, rel=1e-3)


def test_it_leaves_the_formula_beyond():
    for late in ("none", "one_period"):
        case = BOUNCE.case({"late": late})
        assert BOUNCE.probe(0.34, case).holds
        assert not BOUNCE.probe(0.46, case).holds


def test_a_bounce_without_loss_keeps_its_energy_between_the_samples():
    """b = K T/2 in contact: energy in is energy out, to the phase."""
    gains = [bounce.exact_gain(0.05, 0.15, 300.0, 1000.0, 0.0, p) for p in bounce.phases(32)]
    assert np.mean(gains) == pytest.approx(1.0, abs=2e-3)

"""Friction against sensor steps: Abbott & Okamura's line, Diolaiti's regions, and what the tick does."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import limits
from hapkit_studio.analysis.stability.kb_plane import exact_boundary
from hapkit_studio.haptics import headless, rows

QUANTUM = 20e-6
STIFFNESS = 1000.0
PERIOD = 1e-3
WORKED = Setting(mass=0.05, viscous=0.5, coulomb=0.1, quantum=15e-6)


@pytest.mark.parametrize(
    ("quantum", "coulomb", "stiffness"),
    [
        (5e-6, 0.02, 8000), (5e-6, 0.1, 40000), (15e-6, 0.02, 2667), (15e-6, 0.05, 6667), (15e-6, 0.1, 13333),
        (15e-6, 0.3, 40000), (20.7e-6, 0.25, 24155), (61.4e-6, 0.02, 651), (61.4e-6, 0.1, 3257),
        (61.4e-6, 0.5, 16287), (0.78e-3, 0.1, 256),
    ],
)  # fmt: skip
def test_the_stiffness_up_to_which_friction_hides_the_steps(quantum, coulomb, stiffness):
    found = limits.coulomb_line(replace(WORKED, quantum=quantum, coulomb=coulomb))
    assert found == pytest.approx(stiffness, abs=0.5)


def test_an_ideal_sensor_has_no_such_line():
    assert limits.coulomb_line(replace(WORKED, quantum=0.0)) == math.inf


@pytest.mark.parametrize(("late", "factor"), [(0.0, 0.333), (0.5, 0.208), (1.0, 0.184), (2.0, 0.172)])
def test_the_simple_rule_is_short_by_a_share_of_b_squared_over_m_without_virtual_damping(late, factor):
    setting = replace(WORKED, delay=late * PERIOD)
    none = np.zeros(1)
    missing = exact_boundary(setting, none) - limits.simple_rule(setting, none)
    assert missing[0] == pytest.approx(factor * setting.viscous**2 / setting.mass, rel=0.01)


@pytest.mark.parametrize(
    ("late", "shares"), [(0.0, (-0.047, -0.09, -0.18, -0.26)), (1.0, (-0.053, -0.11, -0.22, -0.34))]
)
def test_the_simple_rule_is_hopeful_with_virtual_damping(late, shares):
    """Damping of 0.05, 0.1, 0.2, 0.3 times m/T on a handle that has next to none."""
    setting = replace(WORKED, viscous=1e-6 * WORKED.mass / PERIOD, delay=late * PERIOD)
    damping = np.array([0.05, 0.1, 0.2, 0.3]) * setting.mass / PERIOD
    found = exact_boundary(setting, damping) / limits.simple_rule(setting, damping) - 1.0
    assert found == pytest.approx(shares, abs=0.006)


def test_a_hands_damping_counts():
    firm = replace(WORKED, hand="firm")
    assert limits.simple_rule(firm, [1.0])[0] == pytest.approx((0.5 + 8.0 + 1.0) / 0.5e-3)
    assert limits.dimensionless(firm, 1.0, 2000.0) == pytest.approx((9.5 / 2.0, 0.1 / (2000.0 * 15e-6)))


def rendered(beta, sigma, counts):
    """Return how far, in counts, a spring of STIFFNESS lets the handle move in the last fifth of 6 s.

    It pulls by half a step on both sides of the edge between two counts: the worst place to come to rest.
    """
    setting = Setting(
        mass=0.05,
        viscous=beta * STIFFNESS * PERIOD,
        coulomb=sigma * STIFFNESS * QUANTUM,
        quantum=QUANTUM,
    )
    values = {"stiffness": STIFFNESS, "damping": 0.0, "center": 0.5 * QUANTUM}
    device = setting.device(position=counts * QUANTUM)
    out = headless.spring_rows(environments.named("spring"), values, device, setting.loop, None, 6000)
    return setting, float(np.ptp(out[4800:, rows.TRUE_POSITION])) / QUANTUM


NEAR, FAR = 3.3, 200.3


@pytest.mark.parametrize("beta", [0.25, 0.4, 0.6, 1.0, 2.0])
@pytest.mark.parametrize("sigma", [0.1, 0.25, 0.4, 0.55, 1.0])
def test_the_tick_does_what_the_regions_say(beta, sigma):
    setting, near = rendered(beta, sigma, NEAR)
    far = rendered(beta, sigma, FAR)[1]
    stiffness, none = np.array([STIFFNESS]), np.zeros(1)
    for limit in (limits.simple_rule(setting, none), exact_boundary(setting, none)):
        region = int(limits.classes(setting, stiffness, limit)[0, 0])
        if region == limits.RESTS:
            assert near == far == 0.0
        elif region == limits.BUZZES:
            assert 0.0 < near < 2.0
            assert 0.0 < far < 2.0
        elif region == limits.NEAR:
            assert near == 0.0
            assert far > FAR
        else:
            assert near > 0.0
            assert far > FAR


@pytest.mark.parametrize(
    ("stiffness", "viscous", "coulomb", "reach"),
    [
        (2000.0, 0.5, 0.2, 2.546),
        (2000.0, 0.8, 0.2, 6.366),
        (4000.0, 1.0, 0.5, 2.251),
        (1000.0, 0.2, 0.1, 3.001),
    ],
)
def test_friction_holds_what_is_let_go_near_enough(stiffness, viscous, coulomb, reach):
    setting = Setting(mass=0.05, viscous=viscous, coulomb=coulomb, quantum=0.0)
    found = limits.resting_reach(setting, 0.0, stiffness)
    assert 1e3 * found == pytest.approx(reach, abs=6e-4)
    values = {"stiffness": stiffness, "damping": 0.0, "center": 0.0}
    ends = []
    for share in (0.97, 1.04):
        device = setting.device(position=share * found)
        out = headless.spring_rows(environments.named("spring"), values, device, setting.loop, None, 6000)
        ends.append(float(np.ptp(out[-500:, rows.TRUE_POSITION])))
    assert ends[0] < found < ends[1]


def test_what_is_stable_comes_to_rest_from_anywhere():
    assert limits.resting_reach(WORKED, 0.0, 900.0) == math.inf
    assert limits.resting_reach(replace(WORKED, delay=PERIOD), 0.0, 900.0) < math.inf
    assert set(limits.REGION_WORDS) == {limits.RESTS, limits.BUZZES, limits.NEAR, limits.GROWS}

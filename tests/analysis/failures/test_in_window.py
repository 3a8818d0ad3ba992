"""Each failure's instruction states what the complete device does if a mouse pulls and releases it."""

import math

import pytest

from hapkit_studio.analysis.failures import failures
from hapkit_studio.analysis.failures.base import short
from hapkit_studio.analysis.failures.in_window import SEEN, behind, let_go


def live(key, share):
    """Return a failure's scene for the window, with the varied value at ``share`` times its limit."""
    failure = failures()[key]
    case = failure.case()
    return failure.live(share * failure.limit(case), case)


def test_a_spring_keeps_oscillating_only_beyond_the_damping_of_friction_and_the_motors_limit():
    """Motion beyond A = 4 F_c/(π ω (K T/2 − b)) grows if A is below 3 N/K, the motor's limit."""

    def holds(k):
        a = 4.0 * 0.1 / (math.pi * math.sqrt(k / 0.044) * (0.5e-3 * k - 0.5))
        return a > 3.0 / k

    just = next(k for k in range(1010, 2000) if not holds(k))
    assert live("sampled_spring", 0.99).advice.endswith("let go. The handle comes to rest.")
    assert (
        "let go. The handle comes to rest. Dry friction and the motor's force limit of 3 N calm the handle"
        in live("sampled_spring", 1.01).advice
    )
    for share, swings in ((0.93 * just / 1001.9, False), (1.12 * just / 1001.9, True)):
        found = live("sampled_spring", share)
        assert (let_go(found) > SEEN) == swings == ("it buzzes at " in found.advice)


def test_a_push_beyond_its_amplitude_oscillates_and_one_below_settles():
    for share, text in ((0.96, "the handle comes to rest."), (1.04, "the handle keeps oscillating.")):
        assert live("large_push", share).advice.endswith(text)
    assert behind(1e-3, 2000.0) == pytest.approx(11e-3)
    # the grip of 200 N/m has to pull with the motor's limit of 3 N, so the pointer is 15 mm ahead of the
    # handle
    assert behind(5e-3, 2000.0) == pytest.approx(20e-3)


def test_the_window_shows_the_step_of_its_integrator():
    """A mass on a spring advances by ω dt per step, and the window must show this step."""
    failure = failures()["integrators"]
    for method in range(5):
        case = failure.case() | {"method": float(method)}
        for share in (0.99, 1.01):
            step = share * failure.limit(case)
            found = failure.live(step, case)
            turn = math.sqrt(found.values["stiffness"] / found.values["mass"]) / found.loop["rate"]
            if step < 2.0:
                assert turn == pytest.approx(step, rel=1e-3)
                assert ("comes to rest" in found.advice) == (share < 1.0)


def test_values_for_the_window_have_four_digits_and_stay_on_their_side_of_the_limit():
    assert short(1302.4668, 1001.9) == 1302.0
    assert short(1002.0004, 1002.0) == 1002.0004
    assert short(1001.9996, 1002.0) == 1001.9996
    assert short(0.0, 1.0) == 0.0

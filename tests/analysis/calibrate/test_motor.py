"""The result on pulses."""

import pytest

from hapkit_studio.analysis.calibrate.motor import MOVED, judge_pulses


@pytest.mark.parametrize(
    ("pulses", "agrees", "key"),
    [
        ([(0.1, 0.002), (-0.1, -0.002)], True, ""),
        ([(0.1, -0.002), (-0.1, 0.002)], False, "opposite"),
        ([(0.1, 0.002), (-0.1, 0.002)], None, "one way"),
        ([(0.1, 0.002), (-0.1, 0.0)], None, "one way"),
        ([(0.3, 0.0), (-0.3, 0.0)], None, "no motion"),
        ([(0.1, 0.99 * MOVED), (-0.1, -0.99 * MOVED)], None, "no motion"),
        ([(0.1, 1.01 * MOVED), (-0.1, -1.01 * MOVED)], True, ""),
        ([], None, "no motion"),
    ],
)
def test_pulses_are_judged(pulses, agrees, key):
    found = judge_pulses(pulses)
    assert (found.agrees, found.result.key) == (agrees, key)


def test_no_motion_asks_for_supply_and_cable():
    remedy = judge_pulses([(0.3, 0.0), (-0.3, 0.0)]).result.remedy
    assert "supply" in remedy
    assert "cable" in remedy

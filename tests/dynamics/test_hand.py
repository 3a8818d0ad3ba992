"""Hands have grips and named movements, and reject invalid values."""

import json
import math

import numpy as np
import pytest

from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.dynamics.hand import ALL_GRIPS, RUBBER_BAND, Hand, grip_named, hand_named
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP, from_table, recorded, to_table
from hapkit_studio.errors import ParameterError

TIMES = np.arange(0.0, 12.0, 1e-3)
MOVEMENTS = ("press", "tap", "stroke", "sweep", "hold", "pluck", "shake", "pet", "rub")


def path(name):
    return hand_named(name).target(TIMES)


@pytest.mark.parametrize("name", MOVEMENTS)
def test_movements_start_at_the_centre_at_human_speeds(name):
    """Movements do not jump, stay within the paddle's 40 mm, and are never faster than 1 m/s."""
    x = path(name)
    assert x[0] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(x).max() <= 0.040
    assert np.abs(x).max() >= 0.010
    assert np.abs(np.diff(x)).max() <= 1e-3


@pytest.mark.parametrize(
    ("name", "speed", "low", "high"),
    [("stroke", 0.05, -0.03, 0.03), ("pet", 0.05, -0.03, 0.03), ("rub", 0.20, -0.03, 0.03)],
)
def test_there_and_back_has_a_constant_speed(name, speed, low, high):
    x = path(name)
    assert (x.min(), x.max()) == pytest.approx((low, high), abs=speed * 1e-3)
    turning = np.abs(np.diff(np.sign(np.diff(x)))) > 0
    steps = np.abs(np.diff(x))[1:][~turning]
    assert np.median(steps) == pytest.approx(speed * 1e-3, rel=1e-9)
    assert np.mean(np.abs(steps - speed * 1e-3) < 1e-12) > 0.98


def test_press_stays_below_the_force_limit_against_any_wall():
    """Against a rigid wall at 5 mm, the grip pulls with k (target - 5 mm)."""
    press = hand_named("press")
    assert press.target(2.0) == press.target(10.0)
    assert 1.0 < press.stiffness * (press.target(2.0) - 0.005) <= 3.0 + 1e-12


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"mass": -1.0}, "mass must be 0 or more kg, not −1 kg"),
        ({"damping": math.nan}, "damping"),
        ({"stiffness": math.inf}, "stiffness"),
        ({"release": -0.1}, "not -0.1 s"),
    ],
)
def test_impossible_hands_are_rejected(bad, names):
    with pytest.raises(ParameterError, match=names):
        Hand(**bad)


def test_unknown_names_are_rejected():
    with pytest.raises(ParameterError, match="press, tap"):
        hand_named("punch")
    with pytest.raises(ParameterError, match="light, medium"):
        grip_named("iron")


@pytest.mark.parametrize("name", ALL_GRIPS)
def test_a_grip_in_a_file_is_read_again(name):
    loop = USUAL_LOOP.changed(hand=name)
    for table in (to_table(loop), recorded(loop)):
        found = from_table(json.loads(json.dumps(table)), USUAL_LOOP, reject=pytest.fail)
        assert found["hand"] == name


def test_a_rubber_band_has_the_limit_of_its_damper():
    """The period T of 1 ms delays a virtual spring by T / 2, so the damping b permits up to 2 b / T."""
    band = grip_named(RUBBER_BAND)
    assert band.mass == 0.0
    limit = stiffness_limit(0.044, 0.5, hand=RUBBER_BAND)
    assert limit == pytest.approx(2e3 * (0.5 + band.damping), rel=0.02)

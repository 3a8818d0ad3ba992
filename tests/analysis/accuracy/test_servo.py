"""Servo rate: the stable stiffness in closed form, the tap on a wall that has no samples."""

import math

import numpy as np
import pytest

from hapkit_studio.analysis.accuracy import servo
from hapkit_studio.analysis.accuracy.servo import PLAN

STIFFNESS, CONTACT = PLAN.scenes


def closed_form(mass, damping, period):
    """Return the largest stable stiffness of a spring without delay."""
    e = math.exp(-damping / mass * period)
    return damping**2 * (1.0 - e) / (mass * (1.0 - e) - damping * period * e)


def test_the_stable_stiffness_is_the_closed_form():
    for rate in servo.RATES:
        assert servo.wall_limit(rate, 0.0) == pytest.approx(closed_form(0.044, 0.5, 1.0 / rate), rel=1e-6)


def test_a_tap_comes_as_near_to_the_continuous_wall_as_samples_are_short():
    """Held forces are late by half a period: half of it, half the error; late ones by a millisecond more."""
    prompt = {run.step_s: run.error for run in servo.runs(CONTACT) if run.method == "prompt"}
    errors = [prompt[1.0 / rate] for rate in (500.0, 1000.0, 2000.0, 4000.0, 8000.0)]
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx(2.0, rel=0.1)
    assert servo.contact_error(servo.FINE_RATE, 0.0) < 6e-4
    late = {run.step_s: run.error for run in servo.runs(CONTACT) if run.method == "late"}
    assert late[1e-3] == pytest.approx(3.0 * prompt[1e-3], rel=0.15)

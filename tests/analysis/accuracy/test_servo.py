"""Servo rate: the tap on a wall comes nearer as samples are short."""

import numpy as np
import pytest

from hapkit_studio.analysis.accuracy import servo


def test_a_tap_comes_as_near_to_the_continuous_wall_as_samples_are_short():
    """Held forces are late by half a period: half of it, half the error; late ones by a millisecond more."""
    errors = [servo.contact_error(rate, 0.0) for rate in (500.0, 1000.0, 2000.0, 4000.0, 8000.0)]
    assert np.array(errors[:-1]) / errors[1:] == pytest.approx(2.0, rel=0.1)
    assert servo.contact_error(1000.0, 1e-3) == pytest.approx(3.0 * errors[1], rel=0.15)

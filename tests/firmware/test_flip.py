"""The error and the speed limit of the flip tracker agree with theory, and beat the class template."""

import shutil

import numpy as np
import pytest

from tests.firmware import flips

pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="no g++")


@pytest.mark.parametrize("rate", [230.0, 500.0, 1000.0, 2000.0, 4000.0])
def test_the_error_is_within_a_count_at_any_position_of_the_magnet(rate):
    assert max(flips.worst_error(flips.ours, flips.sine(rate, m)) for m in range(0, flips.COUNTS, 13)) <= 1.0


@pytest.mark.parametrize(("rate", "millimetres"), [(1000.0, 0.8), (500.0, 1.6), (230.0, 3.3)])
def test_the_templates_error_grows_with_the_speed(rate, millimetres):
    # the template's description gives the expected error, to 0.1 mm
    errors = [flips.worst_error(flips.template, flips.sine(rate, m)) for m in range(0, flips.COUNTS, 37)]
    assert 1e3 * flips.QUANTUM * np.median(errors) == pytest.approx(millimetres, abs=0.15)


@pytest.mark.parametrize(
    ("tracker", "limit"), [(flips.ours, flips.LIMIT), (flips.template, flips.TEMPLATE_LIMIT)]
)
def test_flips_are_lost_from_the_theoretical_speed_on(tracker, limit):
    assert not flips.loses_flips(tracker, 0.99 * limit)
    assert flips.loses_flips(tracker, 1.01 * limit)
    assert flips.fastest(tracker) == pytest.approx(limit, rel=0.01)


def test_an_angle_of_14_bits_is_unwrapped_too():
    counts = 7000.0 * np.sin(np.linspace(0.0, 12.0, 4000)) * 9.0
    found = flips.ours(np.mod(np.floor(counts), 16384), 16384)
    np.testing.assert_array_equal(found - found[0], np.floor(counts) - np.floor(counts[0]))

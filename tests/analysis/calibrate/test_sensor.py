"""The sensor check and the judgement of pulses are correct for good kits and for each fault."""

import numpy as np
import pytest

from hapkit_studio.analysis.calibrate import sensor
from hapkit_studio.analysis.calibrate.motor import MOVED, judge_pulses
from tests.analysis.calibrate.student import end_to_end, session
from tests.devices.paddle_kit import PaddleKit


@pytest.mark.parametrize("counts", [902, 980])
def test_the_counts_between_repeats_are_measured_to_one_count(counts):
    kit = PaddleKit(counts=counts, lowest=20)
    work = session(kit)
    assert end_to_end(kit, work).good
    assert work.sensor.period == pytest.approx(counts, abs=1.0)
    assert work.board.counts_per_flip == pytest.approx(counts, abs=1)
    assert work.board.quantum == pytest.approx(kit.count_length, rel=0.002)


@pytest.mark.parametrize(
    ("kit", "reach", "key"),
    [
        ({"stuck": True}, 0.048, "stuck"),
        ({"noise": 8.0}, 0.048, "noisy"),
        ({}, 0.020, "little"),
        ({"counts": 700}, 0.048, "range"),
        ({"sense": -1}, 0.048, "inverted"),
        ({"noise": 1.0}, 0.048, ""),
    ],
)
def test_each_fault_has_its_result(kit, reach, key):
    made = PaddleKit(**kit)
    work = session(made)
    result = end_to_end(made, work, reach=reach)
    assert result.key == key
    assert bool(result.remedy) is not result.good


def test_noise_is_that_of_the_readings_without_the_motion(rng):
    n = 4000
    moving = 300.0 * np.sin(2.0 * np.pi * 2.0 * np.arange(n) * 1e-3)
    noisy = np.floor(500.0 + moving + 5.0 * rng.standard_normal(n))
    assert sensor.noise_of(noisy) == pytest.approx(5.0, rel=0.1)
    assert sensor.noise_of(np.floor(500.0 + moving)) < 1.0


def test_a_jump_during_a_reading_gives_the_same_period():
    place = np.linspace(0.0, 6.0 * 921.0, 900)
    raw = 51.0 + place % 921.0
    jumps = np.flatnonzero(np.abs(np.diff(raw)) > 400) + 1
    raw[jumps] = 500.0
    np.testing.assert_allclose(sensor.periods(np.floor(raw)), 921.0, atol=14.0)


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

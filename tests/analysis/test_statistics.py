"""Statistics of samples agree with closed forms."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from hapkit_studio.analysis.statistics import dominant, line, statistics

TIME = np.arange(2000) / 1000.0
ALL = np.ones(len(TIME), dtype=bool)


def test_statistics_of_a_sine_agree_with_closed_forms():
    found = statistics(TIME, 0.5 + 2.0 * np.sin(2.0 * math.pi * 5.0 * TIME))
    assert (found.minimum, found.maximum) == pytest.approx((-1.5, 2.5), abs=1e-4)
    assert found.mean == pytest.approx(0.5, abs=1e-9)
    assert found.rms == pytest.approx(math.sqrt(0.25 + 2.0), rel=1e-9)
    assert found.frequency == pytest.approx(5.0, rel=2e-3)


@pytest.mark.parametrize("hertz", [3.3, 17.77, 43.21, 120.4])
def test_a_frequency_between_bins_is_found_in_noise(hertz):
    rng = np.random.default_rng(4)
    jitter = np.sort(TIME + rng.uniform(0.0, 3e-4, len(TIME)))
    values = np.sin(2.0 * math.pi * hertz * jitter) + rng.normal(0.0, 0.2, len(TIME))
    assert dominant(jitter, values) == pytest.approx(hertz, rel=5e-3)


def test_aperiodic_signals_have_no_frequency():
    rng = np.random.default_rng(4)
    assert math.isnan(dominant(TIME, np.zeros(len(TIME))))
    assert math.isnan(dominant(TIME, 3.0 * TIME))
    assert math.isnan(dominant(TIME, rng.normal(size=len(TIME))))
    assert math.isnan(dominant(TIME, np.sin(2.0 * math.pi * 0.6 * TIME)))  # the signal has only 1.2 cycles
    assert math.isnan(dominant(TIME[:7], TIME[:7]))


QUANTUM = 20.7e-6


@pytest.mark.parametrize("rate", [1000.0, 4000.0])
@pytest.mark.parametrize("speed", [1e-4, 1.2e-3, 0.012, 0.1, 1.0])
def test_a_ramp_has_no_frequency_in_counts_in_rounding_or_in_force(speed, rate):
    """Neither the sensor's steps nor the rounding errors of a ramp of 0.66 s are a periodic motion."""
    time = 1234.5 + np.arange(round(0.66 * rate)) / rate
    position = 0.003 + speed * (time - time[0])
    counted = QUANTUM * np.floor(position / QUANTUM)
    for values in (position, counted, -300.0 * counted, np.full(len(time), speed)):
        assert math.isnan(dominant(time, values))


@pytest.mark.parametrize("seconds", [0.2, 0.66, 2.0])
def test_movements_steps_and_noise_have_no_frequency(seconds, rng):
    """At most 5 % of noise samples have a frequency, and no single movement has one."""
    time = np.arange(round(1000.0 * seconds)) / 1000.0
    counts = {name: 0 for name in ("move", "bend", "pulse", "release", "white", "red", "walk")}
    for _ in range(100):
        at, length = rng.uniform(0.0, seconds), rng.uniform(0.1, 1.0) * seconds
        share = np.clip((time - at) / length, 0.0, 1.0)
        white = rng.normal(size=len(time))
        for name, values in (
            ("move", QUANTUM * np.floor(0.01 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2) / QUANTUM)),
            ("bend", rng.normal() * time + rng.normal() * np.maximum(time - at, 0.0)),
            ("pulse", np.exp(-(((time - at) / (0.2 * length)) ** 2))),
            ("release", np.where(time < at, 1.0, np.exp(-(time - at) / length))),
            ("white", white),
            ("red", lfilter([1.0], [1.0, -0.9], white)),
            ("walk", np.cumsum(white)),
        ):
            counts[name] += not math.isnan(dominant(time, values))
    assert max(counts["move"], counts["bend"], counts["pulse"], counts["release"]) == 0
    assert max(counts.values()) <= 5


@pytest.mark.parametrize(
    ("shape", "cycles"),
    [(shape, n) for shape in ("sine", "square", "ringing", "slope", "counts") for n in (4.5, 9.3, 40.0)]
    + [("sawtooth", 9.3), ("sawtooth", 40.0)],
)
def test_few_cycles_of_any_shape_suffice(shape, cycles):
    turns = cycles * TIME / TIME[-1]
    sine = np.sin(math.tau * turns + 0.4)
    values = {
        "sine": sine,
        "square": np.sign(sine),
        "sawtooth": turns % 1.0,
        "ringing": sine * np.exp(-TIME / TIME[-1]),
        "slope": sine + 10.0 * TIME,
        "counts": np.floor(2.5 * sine),
    }[shape]
    assert dominant(TIME, values) * TIME[-1] == pytest.approx(cycles, rel=0.02, abs=0.1)


def test_too_few_cycles_or_two_equal_tones_have_no_frequency():
    assert math.isnan(dominant(TIME, np.sin(math.tau * 3.4 * TIME / TIME[-1])))
    assert math.isnan(dominant(TIME, np.sin(math.tau * 21.0 * TIME) + 0.9 * np.sin(math.tau * 34.0 * TIME)))


def test_the_interval_of_a_slope_contains_the_truth_with_autocorrelated_residuals():
    rng, covered = np.random.default_rng(7), 0
    x = 0.01 * np.sin(2.0 * math.pi * 1.3 * TIME)
    for _ in range(300):
        noise = lfilter([0.05], [1.0, -0.9], rng.normal(size=len(TIME)))
        found = line(x, -300.0 * x + 0.2 + noise, ALL)
        covered += abs(found.slope + 300.0) <= found.half
    assert 0.91 <= covered / 300 <= 0.98


def test_a_slope_needs_motion():
    assert line(np.full(500, 0.01), np.ones(500), ALL[:500]) is None
    assert line(TIME[:5], TIME[:5], ALL[:5]) is None


def test_the_residual_of_a_regression_line_agrees_with_the_closed_form():
    """The best line of x² from 0 to 1 is x − 1/6, so the residual's RMS is 1/√180; the RMS of x² is 1/√5."""
    x = np.linspace(0.0, 1.0, 4001)
    every = np.ones(len(x), dtype=bool)
    found = line(x, x**2, every)
    assert found.slope == pytest.approx(1.0, rel=1e-6)
    assert found.left == pytest.approx(1.0 / 6.0, rel=1e-3)
    assert line(x, np.where(x < 0.5, 7.0, 3.0 * x), x >= 0.5).left == pytest.approx(0.0, abs=1e-9)

"""Compares errors and lags of the tick's velocity estimators with those of scipy's filters."""

import math

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from hapkit_studio.analysis.accuracy import velocity
from hapkit_studio.analysis.accuracy.plan import error
from hapkit_studio.analysis.accuracy.velocity import PLAN, SIGNALS, VARIANTS
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import USUAL_LOOP
from tests.analysis.accuracy.reference_loop import Kalman

QUANTUM, T = 20.7e-6, 1e-3


def longest_line(counts, noise):
    """Return the slope of the longest line of up to 17 samples that fits all its samples within the noise."""
    found, fits = np.zeros(len(counts)), [np.vander(T * np.arange(size), 2) for size in range(2, 18)]
    solve = [np.linalg.pinv(line) for line in fits]
    for n in range(16, len(counts)):
        for line, solution in zip(fits, solve, strict=True):
            y = counts[n - len(line) + 1 : n + 1] - counts[n]
            slope = solution @ y
            if len(line) > 2 and np.abs(line @ slope - y).max() > (1.0 - 1e-9) * noise * QUANTUM:
                break
            found[n] = slope[0]
    return found


def filtered(spec, position):
    """Return the velocities that an estimator computes, from the formulas of textbooks."""
    key, options = spec
    counts = QUANTUM * np.floor(position / QUANTUM)
    if key == "foaw":
        return longest_line(counts, options["noise"])
    if key == "kalman":
        kalman = Kalman(T, QUANTUM, options["q"])
        alpha, beta = kalman.alpha, kalman.beta * T
        return lfilter([beta / T, -beta / T], [1.0, alpha + beta - 2.0, 1.0 - alpha], counts)
    raw = np.diff(counts, prepend=counts[0]) / T
    if key == "butterworth":
        return lfilter(*butter(2, options["cutoff"], fs=1000.0), raw)
    pole = math.exp(-2.0 * math.pi * options["cutoff"] * T) if options else 0.0
    return lfilter([1.0 - pole], [1.0, -pole], raw)


@pytest.mark.slow
@pytest.mark.parametrize("scene", PLAN.scenes, ids=lambda scene: scene.key)
def test_errors_agree_with_independent_filters_on_the_products_sensor(scene):
    assert SimulatedHapkit().quantum == QUANTUM
    found = {point.label: error(prepare) for point, prepare, _ in velocity.runs(scene)}
    position, true = SIGNALS[scene.key][1]
    for key, options in VARIANTS:
        off = (filtered((key, options), position) - true)[300:]
        assert found[velocity.label(key, options)] == pytest.approx(math.sqrt(np.mean(off**2)), rel=1e-3)


def test_no_estimator_is_within_tolerance_in_every_motion_and_the_default_is_in_most():
    passed = {}
    for scene in PLAN.scenes:
        for point, prepare, _ in PLAN.runs(scene):
            passed[point.label] = passed.get(point.label, 0) + (error(prepare) <= scene.tolerance)
    assert USUAL_LOOP.estimator == "kalman"
    assert passed["Kalman q = 0.01"] == max(passed.values()) == 5

"""Velocity estimators: their coefficients, their start, their error on quantised ramps, what they refuse."""

import math

import numpy as np
import pytest

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.estimators import ESTIMATORS, estimate_velocity
from hapkit_studio.errors import ParameterError

SPECS = ["difference", "iir", ("iir", {"cutoff": 100.0})]


def ramp(speed, quantum=15e-6, rate=1000.0, seconds=1.0):
    """Return a floored ramp, begun off the sensor's edges, where rounding would decide the count."""
    return quantum * np.floor(0.4 + speed * np.arange(seconds * rate) / rate / quantum)


@pytest.mark.parametrize("spec", SPECS)
def test_starts_as_if_it_had_rested_at_its_first_position(spec):
    velocity = estimate_velocity(np.full(50, 0.0123), 1000.0, spec)
    assert np.array_equal(velocity, np.zeros(50))
    assert estimate_velocity([0.01, 0.02], 1000.0, spec)[0] == 0.0


def test_difference_is_the_step_over_the_period():
    velocity = estimate_velocity([0.0, 1e-3, 1e-3, -1e-3], 500.0)
    assert velocity == pytest.approx([0.0, 0.5, 0.0, -1.0], abs=1e-15)


@pytest.mark.parametrize(("cutoff", "alpha"), [(35.5, 0.2), (20.0, 0.118), (100.0, 0.4665), (200.0, 0.7154)])
def test_iir_takes_up_alpha_of_a_step_per_sample(cutoff, alpha):
    """alpha = 1 - exp(-2 pi f_c T); 35.5 Hz at 1 kHz is 0.2."""
    position = np.arange(40) * 1e-4
    velocity = estimate_velocity(position, 1000.0, ("iir", {"cutoff": cutoff}))
    assert velocity[1] / 0.1 == pytest.approx(alpha, abs=5e-4)
    pole = math.exp(-2.0 * math.pi * cutoff / 1000.0)
    assert velocity == pytest.approx(0.1 * (1.0 - pole ** np.arange(40)), rel=1e-10)


def test_iir_default_is_35_5_hz():
    position = ramp(0.05)
    assert np.array_equal(
        estimate_velocity(position, 1000.0, "iir"),
        estimate_velocity(position, 1000.0, ("iir", {"cutoff": 35.5})),
    )


@pytest.mark.parametrize("speed", [0.005, 0.100])
@pytest.mark.parametrize(
    ("spec", "rms", "largest"), [("difference", 7.1e-3, 10e-3), ("iir", 0.90e-3, 1.2e-3)]
)
def test_error_on_a_quantised_ramp(speed, spec, rms, largest):
    """RMS and largest error with 15 µm at 1 kHz after 0.3 s."""
    error = estimate_velocity(ramp(speed), 1000.0, spec, 15e-6)[300:] - speed
    assert np.sqrt(np.mean(error**2)) == pytest.approx(rms, rel=0.1)
    assert np.abs(error).max() == pytest.approx(largest, rel=0.1)


def test_uses_the_period_that_passed_not_the_one_it_was_designed_for():
    code, coefs = estimators.design("difference", 1000.0)
    memory = np.zeros(estimators.MEMORY)
    estimators.reset(memory, 0.0)
    assert estimators.step(code, coefs, memory, 1e-3, 0.002) == pytest.approx(0.5)


@pytest.mark.parametrize("spec", SPECS)
def test_transfer_function_is_that_of_the_compiled_step(spec):
    """Drive with a sine and compare the settled answer with H(e^jw) times it."""
    w, k = 0.3, np.arange(2000)
    velocity = estimate_velocity(1e-3 * np.sin(w * k), 1000.0, spec)
    estimator, _ = estimators.parse(spec)
    h = estimator.response(estimators.design(spec, 1000.0)[1], 1e-3, np.exp(1j * w))
    want = 1e-3 * np.imag(h * np.exp(1j * w * k))
    assert velocity[1000:] == pytest.approx(want[1000:], abs=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS.values(), ids=ESTIMATORS.keys())
def test_every_estimator_follows_a_steady_motion(estimator):
    code, coefs = estimators.design(estimator.key, 1000.0, 20.7e-6)
    assert coefs.shape == (estimators.COEFFICIENTS,)
    assert coefs.dtype == np.float64
    assert code == estimator.code
    assert estimate_velocity(np.arange(1500) * 2e-4, 1000.0, estimator.key)[-1] == pytest.approx(
        0.2, rel=1e-6
    )


@pytest.mark.parametrize(
    ("spec", "names"),
    [
        ("kalmann", "difference"),
        (("iir", {"cutoff": 0.0}), "1 to 2000 Hz"),
        (("iir", {"cutof": 20.0}), "cutoff"),
        (("difference", {"cutoff": 20.0}), "cutoff"),
    ],
)
def test_refuses_what_it_does_not_know(spec, names):
    with pytest.raises(ParameterError, match=names):
        estimators.design(spec, 1000.0)


def test_refuses_a_rate_of_zero():
    with pytest.raises(ParameterError, match="0 Hz"):
        estimators.design("iir", 0.0)


def test_nothing_in_nothing_out():
    assert estimate_velocity([], 1000.0).size == 0


@pytest.mark.parametrize(
    ("position", "rate", "names"),
    [
        ([[1.0, 2.0], [3.0, 4.0]], 1000.0, r"one row of numbers, not of shape \(2, 2\)"),
        (["here"], 1000.0, "must be numbers of m"),
        ([0.0, 1.0], "fast", "rate takes a number in Hz, not 'fast'"),
    ],
)
def test_refuses_what_is_no_row_of_numbers(position, rate, names):
    with pytest.raises(ParameterError, match=names):
        estimate_velocity(position, rate)

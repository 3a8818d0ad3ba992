"""Formulas, errors and noise of the velocity estimators."""

import math

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from scipy.signal import butter, lfilter

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.estimators import estimate_velocity
from hapkit_studio.errors import ParameterError

LINEAR = [
    "difference",
    "iir",
    ("iir", {"cutoff": 100.0}),
    "butterworth",
    ("butterworth", {"cutoff": 2000.0}),
    "kalman",
    ("kalman", {"q": 1e-3}),
]
SPECS = [*LINEAR, "foaw", ("foaw", {"window": 2.0})]


@pytest.mark.parametrize("spec", SPECS)
def test_starts_at_rest_at_the_first_position(spec):
    velocity = estimate_velocity(np.full(50, 0.0123), 1000.0, spec)
    assert np.array_equal(velocity, np.zeros(50))
    assert estimate_velocity([0.01, 0.02], 1000.0, spec)[0] == 0.0


@pytest.mark.parametrize(("cutoff", "alpha"), [(35.5, 0.2), (20.0, 0.118), (100.0, 0.4665), (200.0, 0.7154)])
def test_iir_adds_alpha_of_a_step_per_sample(cutoff, alpha):
    """The formula is alpha = 1 - exp(-2 pi f_c T), which is 0.2 for 35.5 Hz at 1 kHz."""
    position = np.arange(40) * 1e-4
    velocity = estimate_velocity(position, 1000.0, ("iir", {"cutoff": cutoff}))
    assert velocity[1] / 0.1 == pytest.approx(alpha, abs=5e-4)
    pole = math.exp(-2.0 * math.pi * cutoff / 1000.0)
    assert velocity == pytest.approx(0.1 * (1.0 - pole ** np.arange(40)), rel=1e-10)


@pytest.mark.parametrize("spec", SPECS)
def test_a_resumed_velocity_has_no_jump_and_late_samples_do_not_affect_it(spec):
    """Two of the periods are three times as long."""
    code, coefs = estimators.design(spec, 1000.0, 20.7e-6)
    memory, x = np.full(estimators.MEMORY, 7.0), 0.02
    estimators.resume(memory, x, 0.1)
    for k in range(60):
        period = 3e-3 if k in (20, 30) else 1e-3
        x += 0.1 * period
        assert estimators.step(code, coefs, memory, x, period) == pytest.approx(0.1)


@pytest.mark.parametrize("rate", [100.0, 1000.0, 10_000.0])
def test_butterworth_agrees_with_scipy(rate):
    position = np.cumsum(np.sin(np.arange(400.0)))
    b, a = butter(2, min(40.0, 0.45 * rate), fs=rate)
    want = lfilter(b, a, np.diff(position, prepend=position[0]) * rate)
    assert estimate_velocity(position, rate, ("butterworth", {"cutoff": 40.0})) == pytest.approx(
        want, rel=1e-9
    )


@pytest.mark.parametrize("rate", [100.0, 1000.0, 10_000.0])
@pytest.mark.parametrize("quantum", [1e-7, 20.7e-6, 1e-3])
def test_kalman_gains_solve_the_riccati_equation(rate, quantum):
    t, q, noise = 1.0 / rate, 0.02, quantum**2 / 12.0
    move = np.array([[1.0, t], [0.0, 1.0]])
    spread = q * np.array([[t**3 / 3.0, t**2 / 2.0], [t**2 / 2.0, t]])
    p = solve_discrete_are(move.T, np.array([[1.0], [0.0]]), spread / noise, np.eye(1))
    want = p[:, 0] / (p[0, 0] + 1.0) * [1.0, t]
    assert estimators.design(("kalman", {"q": q}), rate, quantum)[1][:2] == pytest.approx(want, rel=1e-6)


@pytest.mark.parametrize("key", ["kalman", "foaw"])
def test_an_ideal_sensor_is_assigned_the_usual_noise(key):
    ideal, usual = (estimators.design(key, 1000.0, quantum)[1] for quantum in (0.0, 20.7e-6))
    assert np.array_equal(ideal, usual)


def test_foaw_responds_to_a_kink_with_the_samples_after_it():
    """No line fits across the kink; two samples after it, the window contains only the new motion."""
    x = np.concatenate([np.full(40, 0.01), 0.01 + 0.4e-3 * np.arange(1, 20)])
    velocity = estimate_velocity(x, 1000.0, "foaw", 20.7e-6)
    assert velocity[:40] == pytest.approx(0.0, abs=1e-12)
    assert velocity[40:] == pytest.approx(0.4)


def test_foaw_uses_the_whole_window_if_the_line_fits():
    """With jitter of a count, all 17 samples give the slope; with a smaller noise limit, only two do."""
    x = 20e-6 * (np.arange(60) % 2)
    ages = np.arange(17)
    whole = -np.polyfit(ages * 1e-3, x[59 - ages], 1)[0]
    assert estimate_velocity(x, 1000.0, ("foaw", {"noise": 0.7}), 20e-6)[59] == pytest.approx(whole)
    assert estimate_velocity(x, 1000.0, ("foaw", {"noise": 0.1}), 20e-6)[59] == pytest.approx(20e-3)


@pytest.mark.parametrize("spec", LINEAR)
def test_the_transfer_function_agrees_with_the_compiled_step(spec):
    """The steady-state response to a sine is compared with H(e^jw)."""
    w, k = 0.3, np.arange(2000)
    velocity = estimate_velocity(1e-3 * np.sin(w * k), 1000.0, spec)
    estimator, _ = estimators.parse(spec)
    h = estimator.response(estimators.design(spec, 1000.0)[1], 1e-3, np.exp(1j * w))
    want = 1e-3 * np.imag(h * np.exp(1j * w * k))
    assert velocity[1000:] == pytest.approx(want[1000:], abs=1e-9)


NO_QUANTUM = r"quantum (must be 0 or more m|must be a number in m)"


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        ({"estimator": "kalmann"}, "difference"),
        ({"estimator": ("iir", {"cutoff": 0.0})}, "1 and 2,000 Hz"),
        ({"estimator": ("iir", {"cutof": 20.0})}, "cutoff"),
        ({"estimator": ("difference", {"cutoff": 20.0})}, "cutoff"),
        ({"estimator": ("foaw", {"window": 17.0})}, "Window must be between 2 and 16, not 17"),
        ({"estimator": ("kalman", {"q": 0.0})}, "0.001 and 1 m²/s³"),
        ({"position": [[1.0, 2.0], [3.0, 4.0]]}, r"one row of numbers, not of shape \(2, 2\)"),
        ({"position": ["here"]}, "must be numbers in m"),
        ({"rate": "fast"}, "rate must be a number in Hz, not 'fast'"),
        *(({"quantum": quantum}, NO_QUANTUM) for quantum in (-1.0, math.nan, math.inf, "fine", None)),
    ],
)
def test_invalid_estimators_are_rejected(bad, names):
    with pytest.raises(ParameterError, match=names):
        estimate_velocity(**({"position": [0.0, 1.0], "rate": 1000.0} | bad))


QUANTUM, RATE, FROM = 15e-6, 1000.0, 300
T = np.arange(3000) / RATE


def sine(amplitude, frequency, start=0.0):
    w = 2.0 * np.pi * frequency
    return start + amplitude * np.sin(w * T), amplitude * w * np.cos(w * T)


def ramp(speed):
    return 0.3 * QUANTUM + speed * T, np.full_like(T, speed)


def reversal(speed=0.2, at=1.0, lasting=0.02):
    share = np.clip((T - at) / lasting, 0.0, 1.0)
    turn = speed * lasting / np.pi * np.sin(np.pi * share)
    x = speed * np.minimum(T, at) + turn - speed * np.maximum(T - at - lasting, 0.0)
    return x, speed * np.cos(np.pi * share)


MOTIONS = (
    sine(0.6 * QUANTUM, 8.0, 0.3 * QUANTUM),
    ramp(0.005),
    ramp(0.1),
    sine(0.02, 1.0),
    sine(0.002, 8.0),
    reversal(),
)
FOAW_1 = ("foaw", {"noise": 1.0})
# columns: estimator, (RMS, largest) error in mm/s for each motion, lag in ms at 8 Hz. Linear estimators are
# also compared with scipy's filters, and the chart's tests check their errors.
TABLE = [
    (FOAW_1, (0.43, 1.1), (0.05, 0.07), (0.05, 0.07), (4.0, 6.7), (11, 18), (2.2, 37), 3.1),
    ("foaw", (0.47, 1.8), (0.05, 0.07), (0.05, 0.07), (2.3, 5.2), (7.1, 13), (1.5, 28), 1.7),
    ("kalman", (1.1, 5.6), (1.7, 2.2), (1.7, 2.2), (2.0, 5.6), (4.9, 10), (3.2, 41), 1.26),
]


def estimated(spec, position):
    return estimate_velocity(QUANTUM * np.floor(position / QUANTUM), RATE, spec, QUANTUM)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: str(row[0]))
def test_errors_and_lag_at_8_hz(row):
    """The lag follows from the phase of the response to a sine of 2 mm, over whole cycles."""
    spec, *wanted, lag = row
    for (position, velocity), (rms, largest) in zip(MOTIONS, wanted, strict=True):
        error = 1e3 * (estimated(spec, position) - velocity)[FROM:]
        found = np.sqrt(np.mean(error**2)), np.abs(error).max()
        assert found == pytest.approx((rms, largest), rel=0.12, abs=0.005)
    turns = slice(500, 2500)
    seen, velocity = estimated(spec, MOTIONS[4][0])[turns], MOTIONS[4][1][turns]
    wave = np.exp(-16j * np.pi * T[turns])
    ratio = np.sum(seen * wave) / np.sum(velocity * wave)
    assert -1e3 * np.angle(ratio) / (16.0 * np.pi) == pytest.approx(lag, rel=0.1)


def test_results_do_not_depend_on_rounding(rng):
    """Residuals of exactly half a count are common; their rounding must not depend on the position."""
    counts = np.cumsum(rng.integers(-1, 2, 6000))
    here = estimate_velocity(20.7e-6 * counts, 1000.0, "foaw", quantum=20.7e-6)
    for place in (1, 1234, -77777):
        there = estimate_velocity(20.7e-6 * (counts + place), 1000.0, "foaw", quantum=20.7e-6)
        assert there == pytest.approx(here, abs=1e-9)

"""Error and lag of the velocity estimators on six motions seen by a sensor of 15 µm at 1 kHz.

The motions: a tremor of 0.6 counts at 8 Hz and the ramps begin 0.3 of a count above an edge of the sensor;
sines of 20 mm and 2 mm; 0.2 m/s turned round along a cosine in 20 ms. Three seconds, judged after 0.3 s.
"""

import numpy as np
import pytest

from hapkit_studio.dynamics.estimators import estimate_velocity

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
IIR_20, IIR_60 = ("iir", {"cutoff": 20.0}), ("iir", {"cutoff": 60.0})
BUTTERWORTH_20, FOAW_1 = ("butterworth", {"cutoff": 20.0}), ("foaw", {"noise": 1.0})
KALMAN_SLOW = ("kalman", {"q": 1e-3})
# estimator, (RMS, largest) error in mm/s for each motion, lag in ms at 8 Hz
TABLE = [
    ("difference", (1.9, 14.6), (7.1, 10), (7.1, 10), (6.1, 14.6), (6.3, 16), (7.1, 28), 0.50),
    (IIR_20, (0.41, 1.4), (0.51, 0.64), (0.51, 0.64), (4.5, 7.1), (26, 38), (11.8, 174), 7.6),
    ("iir", (0.57, 2.6), (0.90, 1.2), (0.90, 1.2), (2.7, 5.0), (15.7, 23), (7.6, 120), 4.4),
    (IIR_60, (0.77, 4.3), (1.5, 2.0), (1.5, 2.0), (2.1, 4.8), (9.6, 16), (5.1, 79), 2.7),
    (BUTTERWORTH_20, (0.34, 0.6), (0.01, None), (0.01, None), (6.5, 9.5), (43, 61), (19, 277), 12.3),
    ("butterworth", (0.63, 2.2), (0.09, None), (0.09, None), (2.4, 4.1), (15, 22), (8.1, 133), 4.2),
    (FOAW_1, (0.43, 1.1), (0.05, 0.07), (0.05, 0.07), (4.0, 6.7), (11, 18), (2.2, 37), 3.1),
    ("foaw", (0.47, 1.8), (0.05, 0.07), (0.05, 0.07), (2.3, 5.2), (7.1, 13), (1.5, 28), 1.7),
    (KALMAN_SLOW, (0.75, 2.9), (0.54, 0.75), (0.54, 0.75), (1.6, 3.7), (9.0, 14), (4.9, 81), 2.5),
    ("kalman", (1.1, 5.6), (1.7, 2.2), (1.7, 2.2), (2.0, 5.6), (4.9, 10), (3.2, 41), 1.26),
]  # fmt: skip


def close(spec, value, wanted):
    """Within 10 %, and the last digit that the table gives.

    With a tolerance of a whole count many samples lie just at it; there rounding made the table, not a rule.
    """
    return value == pytest.approx(wanted, rel=0.12 if spec == FOAW_1 else 0.1, abs=0.005)


def estimated(spec, position):
    return estimate_velocity(QUANTUM * np.floor(position / QUANTUM), RATE, spec, QUANTUM)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: str(row[0]))
def test_errors(row):
    spec, *wanted, _ = row
    for (position, velocity), (rms, largest) in zip(MOTIONS, wanted, strict=True):
        error = 1e3 * (estimated(spec, position) - velocity)[FROM:]
        assert close(spec, np.sqrt(np.mean(error**2)), rms), (rms, largest)
        if largest is not None:
            assert close(spec, np.abs(error).max(), largest), (rms, largest)


@pytest.mark.parametrize("row", TABLE, ids=lambda row: str(row[0]))
def test_lag_at_8_hz(row):
    """The phase of the fundamental of 2 mm, over whole turns."""
    position, velocity = MOTIONS[4]
    turns = slice(500, 2500)
    wave = np.exp(-16j * np.pi * T[turns])
    ratio = np.sum(estimated(row[0], position)[turns] * wave) / np.sum(velocity[turns] * wave)
    assert -1e3 * np.angle(ratio) / (16.0 * np.pi) == pytest.approx(row[-1], rel=0.1)

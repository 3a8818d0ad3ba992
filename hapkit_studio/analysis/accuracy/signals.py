"""The motions that velocity estimators are judged by, as a sensor of 15 µm sees them for 3 s at 1 kHz.

A tremor and the ramps begin 0.3 of a count above an edge of the sensor, so that counts come in no rhythm.
"""

from collections.abc import Callable
from functools import cache

import numpy as np

QUANTUM, RATE, SECONDS = 15e-6, 1000.0, 3.0
_START = 0.3 * QUANTUM
_TURNED_AT, _TURNING = 1.0, 0.02

Signal = tuple[np.ndarray, np.ndarray]
T = np.arange(round(SECONDS * RATE)) / RATE


def sine(amplitude: float, frequency: float, start: float = 0.0) -> Signal:
    """Return position and velocity of a swing of so many m and Hz."""
    w = 2.0 * np.pi * frequency
    return start + amplitude * np.sin(w * T), amplitude * w * np.cos(w * T)


def ramp(speed: float) -> Signal:
    """Return position and velocity of a steady motion."""
    return _START + speed * T, np.full_like(T, speed)


def reversal(speed: float) -> Signal:
    """Return position and velocity of a motion that a blow turns round along a cosine, in 20 ms."""
    share = np.clip((T - _TURNED_AT) / _TURNING, 0.0, 1.0)
    turn = speed * _TURNING / np.pi * np.sin(np.pi * share)
    back = np.maximum(T - _TURNED_AT - _TURNING, 0.0)
    return speed * np.minimum(T, _TURNED_AT) + turn - speed * back, speed * np.cos(np.pi * share)


SIGNALS: dict[str, Callable[[], Signal]] = {
    "tremor": cache(lambda: sine(0.6 * QUANTUM, 8.0, _START)),
    "slow": cache(lambda: ramp(0.005)),
    "steady": cache(lambda: ramp(0.1)),
    "swing": cache(lambda: sine(0.02, 1.0)),
    "shake": cache(lambda: sine(0.002, 8.0)),
    "reversal": cache(lambda: reversal(0.2)),
}

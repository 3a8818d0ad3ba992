"""Sustained oscillation of the handle: amplitude and frequency from the last second of positions."""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.analysis.statistics import LEAST_CYCLES, dominant

SECONDS = 1.0
"""s: duration of the positions to evaluate."""
LEAST_AMPLITUDE = 50e-6  # m: smaller oscillations are jitter between two sensor steps
_FREQUENCY_TOLERANCE = 0.1  # relative tolerance between the spectral peak and the cycle frequency
_SUSTAINED = 0.8  # a motion decays if its last quarter is smaller than this fraction of its largest quarter


class Oscillation(NamedTuple):
    """Half the peak-to-peak distance in m, and the dominant frequency in Hz; NaN without a clear peak."""

    amplitude: float
    frequency: float


def sustained(time: np.ndarray, position: np.ndarray) -> Oscillation | None:
    """Return the oscillation of positions (n,) in m at times (n,) in s; None if it is not sustained.

    The time is divided into quarters. The amplitude is that of the last quarter. It must not be clearly
    smaller than in earlier quarters, because a decaying motion is only ringing after a release. A cycle is
    the time between two upward crossings of a band about the middle. The band extends to either side by half
    the smallest amplitude of a quarter. The frequency is that of ``statistics.dominant`` if it agrees with
    the cycles.
    """
    if len(time) < 2 * LEAST_CYCLES:
        return None
    *_, last = quarters = np.array_split(position, 4)
    amplitudes = [0.5 * float(np.ptp(quarter)) for quarter in quarters]
    if min(amplitudes) < LEAST_AMPLITUDE or amplitudes[-1] < _SUSTAINED * max(amplitudes):
        return None
    rises = _upward_crossings(time, position - 0.5 * (last.max() + last.min()), 0.5 * min(amplitudes))
    if len(rises) <= LEAST_CYCLES:
        return None
    period = float(rises[-1] - rises[0]) / (len(rises) - 1)
    still = max(rises[0] - time[0], time[-1] - rises[-1])
    if still >= 1.5 * period:
        return None
    frequency = dominant(time, position)
    regular = abs(frequency * period - 1.0) < _FREQUENCY_TOLERANCE
    return Oscillation(amplitudes[-1], frequency if regular else math.nan)


def _upward_crossings(time: np.ndarray, away: np.ndarray, band: float) -> np.ndarray:
    """Return the times in s at which a signal rises above the band after it was below the band."""
    outside = np.flatnonzero(np.abs(away) > band)
    up = away[outside] > 0.0
    at = outside[1:][up[1:] & ~up[:-1]]
    share = (band - away[at - 1]) / (away[at] - away[at - 1])
    return time[at - 1] + share * (time[at] - time[at - 1])

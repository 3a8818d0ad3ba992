"""A sustained oscillation of the handle: how far and how often it goes, from the last second of positions."""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.analysis.statistics import LEAST_CYCLES, dominant

SECONDS = 1.0
"""s of positions to look at."""
LEAST_AMPLITUDE = 50e-6  # m: less is a flicker between two sensor steps
_AS_OFTEN = 0.1  # relative difference between the peak's frequency and that of the cycles
_LASTS = 0.8  # of the widest quarter's width: what loses more is dying away


class Oscillation(NamedTuple):
    """Half the peak-to-peak distance in m, and the dominant frequency in Hz, NaN without a clear peak."""

    amplitude: float
    frequency: float


def sustained(time: np.ndarray, position: np.ndarray) -> Oscillation | None:
    """Return the oscillation of positions (n,) in m at times (n,) in s; None where none goes on.

    It fills all of the time and has not become clearly smaller by its last quarter, whose amplitude is
    returned: a handle that rings after a release does so for less. A cycle is from one rise over a band of
    half the least quarter's amplitude to the next one. The frequency is that of ``statistics.dominant``, and
    only where the cycles come as often.
    """
    if len(time) < 2 * LEAST_CYCLES:
        return None
    *_, last = quarters = np.array_split(position, 4)
    amplitudes = [0.5 * float(np.ptp(quarter)) for quarter in quarters]
    if min(amplitudes) < LEAST_AMPLITUDE or amplitudes[-1] < _LASTS * max(amplitudes):
        return None
    rises = _rises(time, position - 0.5 * (last.max() + last.min()), 0.5 * min(amplitudes))
    if len(rises) <= LEAST_CYCLES:
        return None
    period = float(rises[-1] - rises[0]) / (len(rises) - 1)
    still = max(rises[0] - time[0], time[-1] - rises[-1])
    if still >= 1.5 * period:
        return None
    frequency = dominant(time, position)
    regular = abs(frequency * period - 1.0) < _AS_OFTEN
    return Oscillation(amplitudes[-1], frequency if regular else math.nan)


def _rises(time: np.ndarray, away: np.ndarray, band: float) -> np.ndarray:
    """Return when in s a signal goes over the band, having been below it since the last time."""
    outside = np.flatnonzero(np.abs(away) > band)
    up = away[outside] > 0.0
    at = outside[1:][up[1:] & ~up[:-1]]
    share = (band - away[at - 1]) / (away[at] - away[at - 1])
    return time[at - 1] + share * (time[at] - time[at - 1])

"""What a stretch of samples comes to: extremes, mean, RMS, dominant frequency, slopes."""

import math
from typing import NamedTuple

import numpy as np

_LEAST_CYCLES = 2.0  # in a stretch: slower motion is a drift
_LEAST_SHARE = 0.1  # of the variance, within the peak: less is noise


class Statistics(NamedTuple):
    """Of values in their own unit; frequency in Hz, NaN where no one stands out."""

    minimum: float
    maximum: float
    mean: float
    rms: float
    frequency: float


def statistics(time: np.ndarray, values: np.ndarray) -> Statistics:
    """Return the statistics of values (n,) at times (n,) in s, n > 0; RMS about zero."""
    rms = math.sqrt(float(np.mean(values**2)))
    return Statistics(
        float(values.min()), float(values.max()), float(values.mean()), rms, dominant(time, values)
    )


def dominant(time: np.ndarray, values: np.ndarray) -> float:
    """Return the frequency in Hz that carries most of the variance; NaN where none stands out.

    The peak of the Hann periodogram of evenly spaced values, refined by a parabola through its logarithm
    (Gasior and Gonzalez 2004).
    """
    from scipy import signal  # late: a start does not wait for it

    if len(time) < 8:
        return math.nan
    even = np.linspace(time[0], time[-1], len(time))
    rate = (len(time) - 1) / float(time[-1] - time[0])
    frequency, power = signal.periodogram(np.interp(even, time, values), rate, "hann", detrend="linear")
    top = int(power.argmax())
    total = float(power.sum())
    near = power[max(top - 2, 0) : top + 3].sum()
    if not 0 < top < len(power) - 1 or total <= 0.0 or near < _LEAST_SHARE * total:
        return math.nan
    if frequency[top] * (time[-1] - time[0]) < _LEAST_CYCLES:
        return math.nan
    below, peak, above = np.log(np.maximum(power[top - 1 : top + 2], 1e-300))
    shift = 0.5 * (below - above) / (below - 2.0 * peak + above)
    return float(frequency[top] + shift * frequency[1])


class Line(NamedTuple):
    """A straight line: its slope, half the slope's 95 % interval, its ends (2,) along x and y.

    left: the RMS of what it leaves over that of y.
    """

    slope: float
    half: float
    x: np.ndarray
    y: np.ndarray
    left: float


def line(x: np.ndarray, y: np.ndarray, kept: np.ndarray) -> Line | None:
    """Return the line of y over x (n,), in order of time, through what is kept; None where x stands still.

    Least squares with a constant; neighbouring residuals may be alike.
    """
    from hapkit_studio.analysis.identify import regression  # late: it loads scipy.stats

    middle = x[kept].mean()
    columns = np.column_stack([x - middle, np.ones(len(x))])
    found = regression.solve(columns, columns, y, kept)
    if found is None:
        return None
    slope, half, ends = float(found.beta[0]), float(found.half[0]), np.array([x[kept].min(), x[kept].max()])
    left = np.linalg.norm(found.residual) / np.linalg.norm(y[kept])
    return Line(slope, half, ends, found.beta[1] + slope * (ends - middle), float(left))

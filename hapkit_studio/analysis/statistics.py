"""Statistics of samples: extremes, mean, RMS, dominant frequency, regression lines."""

import math
from typing import NamedTuple

import numpy as np

LEAST_CYCLES = 4.0
"""Fewest cycles for which a frequency is reported; a slower motion may be that of a hand."""
_FEWEST_SAMPLES = 32  # with fewer samples, white noise has a clear peak in one of six spectra
_LOBE = 2  # bins on either side of a peak in a Hann window's main lobe
_CLEAR = 4.0  # smallest ratio of a peak to any bin other than its own and those of its harmonics
_LEAST_SHARE = 0.1  # smallest fraction of the variance in the peak
_SAMPLES_A_CYCLE = 4  # faster motion cannot be distinguished from aliases of the sensor's counts
_RESOLVED = 0.5  # smallest amplitude in steps of the values; a ramp in counts has 0.32, a square wave 0.64
_HARMONICS_FROM = 8  # cycles; with fewer cycles, the lobes of the harmonics overlap


class Statistics(NamedTuple):
    """Statistics of values in their unit; the frequency is in Hz, NaN if there is no clear peak."""

    minimum: float
    maximum: float
    mean: float
    rms: float
    frequency: float


def statistics(time: np.ndarray, values: np.ndarray) -> Statistics:
    """Return the statistics of values (n,) at times (n,) in s, n > 0; the RMS includes the mean."""
    rms = math.sqrt(float(np.mean(values**2)))
    return Statistics(
        float(values.min()), float(values.max()), float(values.mean()), rms, dominant(time, values)
    )


def dominant(time: np.ndarray, values: np.ndarray) -> float:
    """Return the dominant frequency in Hz of values (n,) at times (n,) in s; NaN if there is no clear peak.

    It is the peak of the Hann periodogram of the detrended values. The peak must be at ``LEAST_CYCLES`` or
    above, exceed all other bins except harmonics, and have an amplitude above the resolution of the values. A
    parabola through the logarithm refines it (Gasior and Gonzalez 2004).
    """
    count, seconds = len(time), float(time[-1] - time[0]) if len(time) else 0.0
    if count < _FEWEST_SAMPLES or not seconds > 0.0:
        return math.nan
    even = np.interp(np.linspace(time[0], time[-1], count), time, values)
    ramp = np.linspace(-1.0, 1.0, count)
    left = even - even.mean() - ramp * (ramp @ even) / (ramp @ ramp)
    window = 0.5 - 0.5 * np.cos(2.0 * math.pi * np.arange(count) / count)
    power = np.abs(np.fft.rfft(window * left)) ** 2
    top = int(power.argmax())
    if not LEAST_CYCLES <= top <= count / _SAMPLES_A_CYCLE:
        return math.nan
    below, peak, above = np.log(np.maximum(power[top - 1 : top + 2], 1e-300))
    place = top + 0.5 * (below - above) / (below - 2.0 * peak + above)
    own = power[top - _LOBE : top + _LOBE + 1].sum()
    amplitude = 2.0 * math.sqrt(float(own) / count / float(window @ window))
    steps = np.abs(np.diff(values))
    step = float(steps.min(where=steps > 0.0, initial=math.inf))
    if amplitude < _RESOLVED * step:
        return math.nan
    bins = np.arange(len(power))
    harmonic = np.maximum(np.round(bins / place), 1.0) if top >= _HARMONICS_FROM else 1.0
    other = float(power.max(where=np.abs(bins - harmonic * place) > _LOBE + 0.5, initial=0.0))
    if own < _LEAST_SHARE * power.sum() or power[top] < _CLEAR * other:
        return math.nan
    return place * (count - 1) / count / seconds


class Line(NamedTuple):
    """A regression line: slope, half of its 95 % interval, end points (2,) along x and y.

    ``left`` is the ratio of the RMS of the residuals to that of y.
    """

    slope: float
    half: float
    x: np.ndarray
    y: np.ndarray
    left: float


def line(x: np.ndarray, y: np.ndarray, kept: np.ndarray) -> Line | None:
    """Return the regression line of y over x for the samples in the mask ``kept``; None for a singular fit.

    All arrays are (n,) and ordered by time. The line is a least-squares fit with a constant. The interval
    allows for autocorrelated residuals.
    """
    from hapkit_studio.analysis.identify import regression  # imported here because it loads scipy.stats

    middle = x[kept].mean()
    columns = np.column_stack([x - middle, np.ones(len(x))])
    found = regression.solve(columns, columns, y, kept)
    if found is None:
        return None
    slope, half, ends = float(found.beta[0]), float(found.half[0]), np.array([x[kept].min(), x[kept].max()])
    left = np.linalg.norm(found.residual) / np.linalg.norm(y[kept])
    return Line(slope, half, ends, found.beta[1] + slope * (ends - middle), float(left))

"""A recording on an even grid of samples, and the smooth windows over it.

Weak form: what is integrated against smooth windows needs no derivative of a quantised position. For a window
w that is zero at its ends, the integral of w v is that of -w' x, and that of w a is that of w'' x. The
windows are quintic B-splines of six pieces; their spectrum has zeros at every multiple of the piece's rate,
so that sums over samples stand for integrals.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d
from scipy.signal import oaconvolve

from hapkit_studio.analysis.identify.recording import Recording
from hapkit_studio.haptics import rows

# Reasons to leave samples out, in the order in which they are told.
REASONS = {
    "clamped": rows.CLAMPED,
    "stopped": rows.STOPPED,
    "fault": rows.FAULT,
    "stale sensor": rows.STALE,
    "fading": rows.FADING,
}
_MOTOR_OFF = rows.STOPPED | rows.FAULT | rows.STALE
_NOT_AS_ASKED = _MOTOR_OFF | rows.CLAMPED | rows.FADING
_SLOPE_SECONDS = 0.009
_FEWEST = 5
_SMOOTH_SAMPLES = 3.0  # standard deviation of the Gaussian that makes a smooth motion of a quantised one
# Variance of the noise, in that of the sensor's steps, that makes intervals wider: quantised motions without
# noise appear to have at most 0.13, Gaussian noise of 0.3 counts at least 0.8.
_NOISY = 0.25
# A longer break than that starts anew: what came before is of no use to what comes after.
_LONGEST_GAP = 1000


@dataclass(frozen=True)
class Grid:
    """Arrays (n,) on an even grid: position m about its middle, commands N, the hand's force N
    (what is smooth of it, and what is held from sample to sample).

    there: recorded at all; law: the law's force was applied as asked; known: the force in effect is known;
    contact: the law pushed; slope: the speed of a line through 9 ms; sign: its direction, 0 where that cannot
    be told; gone: how far it went that way, in m; seen and speed: what the law got as position and velocity;
    damped: the passivity controller added damping; target: where the hand pulls to, None where that is not
    known all the time. step: the sensor's in m; where positions are noisier, that of a sensor as uncertain.
    """

    period: float
    begin: float
    middle: float
    step: float
    position: np.ndarray
    commands: np.ndarray
    hand: np.ndarray
    hand_held: np.ndarray
    hand_known: bool
    held: np.ndarray
    there: np.ndarray
    law: np.ndarray
    known: np.ndarray
    contact: np.ndarray
    slope: np.ndarray
    sign: np.ndarray
    gone: np.ndarray
    damped: np.ndarray
    seen: np.ndarray
    speed: np.ndarray
    target: np.ndarray | None
    left_out: dict[str, int]

    def __len__(self) -> int:
        return len(self.position)


def lay(recording: Recording) -> Grid:
    """Lay a recording on its grid; samples between rows that were lost are not there."""
    steps, period = _steps(recording)
    good = np.concatenate(([True], steps > 0))
    place = np.concatenate(([0], np.cumsum(np.clip(steps, 0, _LONGEST_GAP))))[good]
    count = int(place[-1]) + 1
    there = np.zeros(count, bool)
    there[place] = True

    def spread(column: np.ndarray) -> np.ndarray:
        values = np.zeros(count)
        values[place] = column[good]
        return values

    middle = float(recording.position[good].mean())
    flags = spread(recording.flags).astype(int)
    position = np.interp(np.arange(count), place, recording.position[good] - middle)
    hand_known = bool(np.isfinite(recording.hand_force).all())
    hand = np.nan_to_num(spread(recording.hand_force))
    law = there & (flags & _NOT_AS_ASKED == 0)
    along = slope(position, period)
    step = recording.setup.quantum * math.sqrt(1.0 + noise_ratio(position, there, recording.setup.quantum))
    sign = direction(along, step, period)
    left_out = {word: int(((flags & bit) != 0).sum()) for word, bit in REASONS.items()}
    left_out["lost"] = int((~there).sum())
    target = recording.target
    if target is not None:
        target = np.interp(np.arange(count), place, target[good]) if np.isfinite(target).all() else None
    return Grid(
        period=period,
        begin=float(recording.time[0]),
        middle=middle,
        step=step,
        position=position,
        commands=spread(recording.applied),
        hand=hand,
        hand_held=spread(recording.hand_held),
        hand_known=hand_known,
        held=(hand != 0.0) | (spread(recording.hand_held) != 0.0),
        there=there,
        law=law,
        known=there & (flags & _MOTOR_OFF == 0),
        contact=spread(recording.asked) != 0.0,
        slope=along,
        sign=sign,
        gone=_gone(position, sign),
        damped=flags & rows.DAMPED != 0,
        seen=spread(recording.position),
        speed=spread(recording.velocity),
        target=target,
        left_out={word: number for word, number in left_out.items() if number},
    )


def _steps(recording: Recording) -> tuple[np.ndarray, float]:
    """Return how many periods each sample is after the one before (n - 1,), and the period in s."""
    gaps = np.diff(recording.time)
    usual = float(np.median(gaps[gaps > 0.0])) if (gaps > 0.0).any() else 1.0 / recording.setup.rate
    steps = np.rint(gaps / usual).astype(int)
    adjacent = steps == 1
    return steps, float(gaps[adjacent].mean()) if adjacent.any() else usual


def noise_ratio(position: np.ndarray, there: np.ndarray, quantum: float) -> float:
    """Return the variance of white noise in positions (n,) in m beside quantum^2 / 12, 0 where it is small.

    The fourth differences of white noise have 70 times its variance, those of a motion next to none. Those of
    the sensor's steps depend on the speed: they are taken from the smoothed motion, quantised again.
    """
    if quantum == 0.0 or len(position) < _FEWEST:
        return 0.0
    adjacent = np.convolve(there, np.ones(5), "valid") == 5.0
    smooth = gaussian_filter1d(position, _SMOOTH_SAMPLES) / quantum

    def variance(counts: np.ndarray) -> float:
        return float(np.mean(np.diff(counts, 4)[adjacent] ** 2)) / 70.0 if adjacent.any() else 0.0

    steps = np.mean([variance(np.floor(smooth + phase)) for phase in (0.0, 0.25, 0.5, 0.75)])
    ratio = 12.0 * (variance(position / quantum) - float(steps))
    return ratio if ratio > _NOISY else 0.0


def slope(position: np.ndarray, period: float) -> np.ndarray:
    """Return the speed (n,) in m/s of a line through some 9 ms about each sample, 0 at the ends."""
    samples = _slope_samples(period)
    if len(position) < samples:
        return np.zeros(len(position))
    about = np.arange(samples) - samples // 2
    found = np.convolve(position, -about / (period * float(about @ about)), "same")
    found[: samples // 2] = found[-(samples // 2) :] = 0.0
    return found


def direction(speed: np.ndarray, step: float, period: float) -> np.ndarray:
    """Return the sign of a ``slope`` (n,), 0 where a step or two in m of the sensor could have made it."""
    least = max(2.0 * step / (_slope_samples(period) * period), 1e-6)
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0)


def _slope_samples(period: float) -> int:
    return max(_FEWEST, int(_SLOPE_SECONDS / period) // 2 * 2 + 1)


def _gone(position: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Return how far the handle is from where it last turned or stood, in m, (n,)."""
    turned = np.flatnonzero(np.diff(sign, prepend=0.0) != 0.0)
    last = np.searchsorted(turned, np.arange(len(sign)), side="right") - 1
    origin = np.where(last >= 0, turned[last] if len(turned) else 0, 0)
    return np.abs(position - position[origin])


PIECES = 6
_SPLINE = BSpline.basis_element(np.arange(PIECES + 1), extrapolate=False)


def _of(spline: BSpline, u: np.ndarray, after: float = 0.0) -> np.ndarray:
    """Return a spline's values at u in pieces, zero before the window, `after` behind it."""
    inside = np.nan_to_num(spline(np.clip(u, 0.0, PIECES)))
    return np.where(u <= 0.0, 0.0, np.where(u >= PIECES, after, inside))


@dataclass(frozen=True)
class Windows:
    """Windows of mean weight 1 over a grid of `count` samples, `piece` (even) samples a piece and apart.

    Each stands over samples k piece … (k + 6) piece. delay in s from a sample to its force, period in s.
    """

    count: int
    piece: int
    period: float
    delay: float

    @property
    def length(self) -> int:
        """Return the samples from a window's start to its end."""
        return PIECES * self.piece

    @cached_property
    def lead(self) -> int:
        """Return how many samples before the window the force in it may come from."""
        return int(np.ceil(self.delay / self.period - 1e-9)) + 1

    @property
    def starts(self) -> np.ndarray:
        """Return the first sample of every window whose samples and forces are all on the grid."""
        first = -(-self.lead // self.piece) * self.piece
        return np.arange(first, self.count - self.length, self.piece)

    @property
    def middles(self) -> np.ndarray:
        """Return every window's middle in s from the grid's first sample."""
        return self.period * (self.starts + 0.5 * self.length)

    def kernel(self, order: int) -> np.ndarray:
        """Return the weights (length + 1,) of samples in the mean of a derivative of that order."""
        u = np.arange(self.length + 1) / self.piece
        step = self.piece * self.period
        return (-1.0) ** order * _of(_SPLINE.derivative(order), u) * self.period / step ** (order + 1)

    def derivative(self, series: np.ndarray, order: int, part: int | None = None) -> np.ndarray:
        """Return each window's mean of the series' derivative of that order, (windows,).

        part 0 or 1 takes every other sample only, so that two results share no sample's error.
        """
        kernel = self.kernel(order)
        if part is not None:
            kernel = np.where(np.arange(len(kernel)) % 2 == part, 2.0 * kernel, 0.0)
        return self._sums(series, kernel, 0)

    def held(self, commands: np.ndarray, delay: float | None = None) -> np.ndarray:
        """Return each window's mean of a force in N that is held from one command to the next, delayed."""
        late = self.delay if delay is None else delay
        edges = np.arange(-self.lead, self.length + 1) * self.period + late
        weight = np.diff(_of(_SPLINE.antiderivative(), edges / (self.piece * self.period), 1.0))
        return self._sums(commands, weight, -self.lead)

    def every(self, good: np.ndarray, before: int = 0) -> np.ndarray:
        """Return whether all of a window's samples, and so many before it, are good: bool (windows,)."""
        bad = np.concatenate(([0], np.cumsum(~good)))
        first = np.maximum(self.starts - before, 0)
        return bad[self.starts + self.length + 1] == bad[first]

    def back(self, values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
        """Return what each sample contributes to sums of the windows' values (windows, p): (count, p)."""
        sparse = np.zeros((self.count, values.shape[1]))
        sparse[self.starts] = values
        return oaconvolve(sparse, kernel[:, None], axes=0)[: self.count]

    def _sums(self, series: np.ndarray, kernel: np.ndarray, offset: int) -> np.ndarray:
        starts = self.starts
        if not len(starts):
            return np.empty(0)
        views = sliding_window_view(series, len(kernel))
        return views[starts[0] + offset : starts[-1] + offset + 1 : self.piece] @ kernel

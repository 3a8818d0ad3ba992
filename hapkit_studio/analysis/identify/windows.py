"""A recording on an even grid of samples, and smooth windows over this grid.

The equations are used in their weak form: integration by parts against a smooth window replaces derivatives
of the quantised position. For a window w that is zero at its ends, the integral of w v equals that of -w' x,
and the integral of w a equals that of w'' x. The windows are quintic B-splines of six segments. Their
spectrum is zero at every multiple of the segment rate, so sums over samples equal the integrals.
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

# reasons for excluding samples, in order of precedence
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
_SMOOTH_SAMPLES = 3.0  # standard deviation in samples of the Gaussian that smooths a quantised motion
# Ratio of noise variance to quantisation variance above which intervals are widened. Quantised motions
# without noise reach at most 0.13, Gaussian noise of 0.3 counts at least 0.8.
_NOISY = 0.25
# samples; after a longer gap a new grid starts, and the part before the gap is ignored
_LONGEST_GAP = 1000


@dataclass(frozen=True)
class Grid:
    """Arrays (n,) on an even grid: position in m about its mean, commands and the hand's force in N.

    ``hand`` is the smooth part of the hand's force, and ``hand_held`` the part that is constant between
    samples. ``there`` marks recorded samples. ``law`` marks samples at which the law's force was applied
    unchanged. ``known`` marks samples at which the force in effect is known. ``contact`` marks samples at
    which the law pushed. ``slope`` is the regression speed over 9 ms in m/s, ``sign`` its direction, 0 if
    uncertain, and ``gone`` the distance in m moved in this direction. ``seen`` and ``speed`` are the position
    and velocity passed to the law. ``damped`` marks samples at which the passivity controller added damping.
    ``target`` is the position towards which the hand pulls, None unless it is known throughout. ``step`` is
    the sensor's step in m; for noisier positions it is the step with the same variance.
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
    in_hand: np.ndarray
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
    """Put a recording on an even grid; ``there`` is False where a row is missing."""
    steps, period = _sample_steps(recording)
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
        commands=spread(recording.applied_force),
        hand=hand,
        hand_held=spread(recording.hand_held),
        hand_known=hand_known,
        in_hand=(hand != 0.0) | (spread(recording.hand_held) != 0.0),
        there=there,
        law=law,
        known=there & (flags & _MOTOR_OFF == 0),
        contact=spread(recording.force) != 0.0,
        slope=along,
        sign=sign,
        gone=_distance_since_reversal(position, sign),
        damped=flags & rows.DAMPED != 0,
        seen=spread(recording.position),
        speed=spread(recording.velocity),
        target=target,
        left_out={word: number for word, number in left_out.items() if number},
    )


def _sample_steps(recording: Recording) -> tuple[np.ndarray, float]:
    """Return the number of periods between consecutive samples (n - 1,), and the period in s."""
    gaps = np.diff(recording.time)
    usual = float(np.median(gaps[gaps > 0.0])) if (gaps > 0.0).any() else 1.0 / recording.setup.rate
    steps = np.rint(gaps / usual).astype(int)
    adjacent = steps == 1
    return steps, float(gaps[adjacent].mean()) if adjacent.any() else usual


def noise_ratio(position: np.ndarray, there: np.ndarray, quantum: float) -> float:
    """Return the ratio of the variance of white noise in positions (n,) in m to quantum² / 12, 0 if small.

    Fourth differences amplify the variance of white noise 70 times and suppress the motion. The fourth
    differences caused by quantisation depend on the speed, so they are computed from the smoothed motion,
    which is quantised again.
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
    """Return the regression speed (n,) in m/s over about 9 ms around each sample; it is 0 at the ends."""
    samples = _slope_samples(period)
    if len(position) < samples:
        return np.zeros(len(position))
    about = np.arange(samples) - samples // 2
    found = np.convolve(position, -about / (period * float(about @ about)), "same")
    found[: samples // 2] = found[-(samples // 2) :] = 0.0
    return found


def direction(speed: np.ndarray, step: float, period: float) -> np.ndarray:
    """Return the sign of a speed (n,); 0 if one or two sensor steps of ``step`` m could have caused it."""
    least = max(2.0 * step / (_slope_samples(period) * period), 1e-6)
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0)


def _slope_samples(period: float) -> int:
    return max(_FEWEST, int(_SLOPE_SECONDS / period) // 2 * 2 + 1)


def _distance_since_reversal(position: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Return the distance (n,) in m since the last reversal or stop."""
    turned = np.flatnonzero(np.diff(sign, prepend=0.0) != 0.0)
    last = np.searchsorted(turned, np.arange(len(sign)), side="right") - 1
    origin = np.where(last >= 0, turned[last] if len(turned) else 0, 0)
    return np.abs(position - position[origin])


PIECES = 6
_SPLINE = BSpline.basis_element(np.arange(PIECES + 1), extrapolate=False)


def _spline_values(spline: BSpline, u: np.ndarray, after: float = 0.0) -> np.ndarray:
    """Return a spline's values at u in segments: 0 before the window, ``after`` beyond its end."""
    inside = np.nan_to_num(spline(np.clip(u, 0.0, PIECES)))
    return np.where(u <= 0.0, 0.0, np.where(u >= PIECES, after, inside))


@dataclass(frozen=True)
class Windows:
    """Windows of mean weight 1 over a grid of ``count`` samples.

    ``piece`` is the even number of samples per segment, which is also the distance between windows: window k
    covers the samples from k piece to (k + 6) piece. ``delay`` is the time in s from a sample to its force,
    and ``period`` is in s.
    """

    count: int
    piece: int
    period: float
    delay: float

    @property
    def length(self) -> int:
        """Return the length of a window in samples."""
        return PIECES * self.piece

    @cached_property
    def lead(self) -> int:
        """Return how many samples before a window can contribute to the force in the window."""
        return int(np.ceil(self.delay / self.period - 1e-9)) + 1

    @property
    def starts(self) -> np.ndarray:
        """Return the first sample of every window whose samples and forces are all on the grid."""
        first = -(-self.lead // self.piece) * self.piece
        return np.arange(first, self.count - self.length, self.piece)

    @property
    def middles(self) -> np.ndarray:
        """Return the middle of every window in s after the grid's first sample."""
        return self.period * (self.starts + 0.5 * self.length)

    def kernel(self, order: int) -> np.ndarray:
        """Return the sample weights (length + 1,) that give a window's mean derivative of this order."""
        u = np.arange(self.length + 1) / self.piece
        step = self.piece * self.period
        return (
            (-1.0) ** order * _spline_values(_SPLINE.derivative(order), u) * self.period / step ** (order + 1)
        )

    def derivative(self, series: np.ndarray, order: int, part: int | None = None) -> np.ndarray:
        """Return the mean in each window (windows,) of a derivative of the series.

        If ``part`` is 0 or 1, only even or only odd samples are used, so that the errors of the two results
        are independent.
        """
        kernel = self.kernel(order)
        if part is not None:
            kernel = np.where(np.arange(len(kernel)) % 2 == part, 2.0 * kernel, 0.0)
        return self._sums(series, kernel, 0)

    def zero_order_hold(self, commands: np.ndarray, delay: float | None = None) -> np.ndarray:
        """Return the mean force (windows,) if commands in N act after a delay and are held for one period."""
        late = self.delay if delay is None else delay
        edges = np.arange(-self.lead, self.length + 1) * self.period + late
        weight = np.diff(_spline_values(_SPLINE.antiderivative(), edges / (self.piece * self.period), 1.0))
        return self._sums(commands, weight, -self.lead)

    def every(self, good: np.ndarray, before: int = 0) -> np.ndarray:
        """Return for each window whether all its samples, and the ``before`` preceding samples, are good."""
        bad = np.concatenate(([0], np.cumsum(~good)))
        first = np.maximum(self.starts - before, 0)
        return bad[self.starts + self.length + 1] == bad[first]

    def back(self, values: np.ndarray, kernel: np.ndarray) -> np.ndarray:
        """Return each sample's contribution (count, p) to sums of window values (windows, p)."""
        sparse = np.zeros((self.count, values.shape[1]))
        sparse[self.starts] = values
        return oaconvolve(sparse, kernel[:, None], axes=0)[: self.count]

    def _sums(self, series: np.ndarray, kernel: np.ndarray, offset: int) -> np.ndarray:
        starts = self.starts
        if not len(starts):
            return np.empty(0)
        views = sliding_window_view(series, len(kernel))
        return views[starts[0] + offset : starts[-1] + offset + 1 : self.piece] @ kernel

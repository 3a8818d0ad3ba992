"""Weak form: what is integrated against smooth windows needs no derivative of a quantised position.

For a window w that is zero at its ends, the integral of w v is that of -w' x, and that of w a is that of
w'' x. The windows are quintic B-splines of six pieces; their spectrum has zeros at every multiple of the
piece's rate, so that sums over samples stand for integrals.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.interpolate import BSpline
from scipy.signal import oaconvolve

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

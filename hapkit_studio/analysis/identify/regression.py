"""Least squares with instruments, and intervals that hold although neighbouring residuals are alike.

Errors of quantised positions in the columns would draw estimates towards zero. Here each column comes twice,
from different samples, with errors that have nothing in common: one is the instrument of the other.

Intervals: the scores' long-run variance from a few cosines, whose weights are independent even where the
scores are not, and Student's t with as many degrees of freedom (Müller 2007; Lazarus, Lewis, Stock and Watson
2018, J. Business & Economic Statistics 36(4)).

Another instrument is the hand's target: what it alone makes of the motion is free of the sensor's steps. A
loop feeds the steps back, so they move the handle, and at a constant speed they are no noise: samples that
lie apart share them. The target knows nothing of them. Two-stage least squares.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from hapkit_studio.analysis.identify.windows import Windows

LEVEL = 0.95
QUANTILE = 1.96  # standard deviations to either side that hold 95 % of a normal error
MOST_COSINES = 12
FEWEST_WINDOWS = 12
# Windows so many places apart have no sample in common.
APART = 6
# Residuals that far apart are alike by chance only in pieces shorter than that.
_ALIKE = 0.4
_FEWEST_AGAIN = 40


@dataclass(frozen=True)
class Fit:
    """Coefficients (p,), covariance (p, p), degrees of freedom, residuals (windows,), share explained."""

    beta: np.ndarray
    covariance: np.ndarray
    freedom: int
    residual: np.ndarray
    explained: float

    @property
    def half(self) -> np.ndarray:
        """Return the half widths (p,) of the intervals."""
        return self.half_of(np.eye(len(self.beta)))

    def half_of(self, gradient: np.ndarray) -> np.ndarray:
        """Return the half widths (k,) of what depends on the coefficients by these gradients (k, p)."""
        variance = np.einsum("ki,ij,kj->k", gradient, self.covariance, gradient)
        return np.sqrt(np.maximum(variance, 0.0)) * stats.t.ppf(0.5 + 0.5 * LEVEL, self.freedom)


def solve(
    one: np.ndarray, two: np.ndarray, y: np.ndarray, kept: np.ndarray, again: bool = False
) -> Fit | None:
    """Fit y (windows,) by columns (windows, p) measured twice; kept says which windows count.

    Windows are in order of time, those not kept too: the distance between neighbours matters. None where too
    few are kept, or a column is no different from the others. again: where residuals repeat, what repeats
    counts once.
    """
    columns = one.shape[1]
    if kept.sum() < max(FEWEST_WINDOWS, 4 * columns):
        return None
    scale = np.sqrt(np.mean(one[kept] ** 2, axis=0))
    if not (scale > 0.0).all():
        return None
    a, b, y = np.where(kept[:, None], one / scale, 0.0), np.where(kept[:, None], two / scale, 0.0), y * kept
    normal = 0.5 * (a.T @ b + b.T @ a)
    if np.linalg.cond(normal) > 1e8:
        return None
    inverse = np.linalg.inv(normal)
    beta = inverse @ (0.5 * (a + b).T @ y)
    ra, rb = y - a @ beta, y - b @ beta
    residual = 0.5 * (ra + rb)
    scores = 0.5 * (a * rb[:, None] + b * ra[:, None])
    middle, freedom = _spread(scores, kept)
    times = repeated(residual, kept) if again else 1.0
    if times > 1.0:
        middle = middle + times * _nearby(scores)
    around = y[kept] - y[kept].mean()
    explained = 1.0 - float(residual @ residual) / max(float(around @ around), 1e-300)
    covariance = inverse @ middle @ inverse / np.outer(scale, scale)
    return Fit(beta / scale, covariance, freedom, residual[kept], explained)


def repeated(residual: np.ndarray, kept: np.ndarray) -> float:
    """Return how many times residuals (windows,) come again; 1 where they do not.

    A motion that repeats to a count of the sensor repeats its errors: more of it tells no more.
    """
    count = len(residual)
    size = 2 * count
    spectra = [np.fft.rfft(series, size) for series in (residual, residual**2, kept.astype(float))]
    products = np.fft.irfft(np.abs(spectra[0]) ** 2, size)[:count]
    ahead = np.fft.irfft(np.conj(spectra[1]) * spectra[2], size)[:count]
    behind = np.fft.irfft(spectra[1] * np.conj(spectra[2]), size)[:count]
    both = np.fft.irfft(np.abs(spectra[2]) ** 2, size)[:count]
    norm = np.sqrt(np.maximum(ahead, 0.0) * np.maximum(behind, 0.0))
    enough = (both > _FEWEST_AGAIN) & (np.arange(count) > APART) & (norm > 1e-9 * max(norm[0], 1e-300))
    alike = np.where(enough, products / np.where(enough, norm, 1.0), 0.0)
    most = float(alike.max())
    if most < _ALIKE:
        return 1.0
    period = int(np.flatnonzero(alike >= 0.8 * most)[0])
    return 1.0 + (count / period - 1.0) * most


def _nearby(scores: np.ndarray) -> np.ndarray:
    """Return the covariance (p, p) of the sum of scores (windows, p) that neighbours make (Bartlett)."""
    found = scores.T @ scores
    for lag in range(1, min(2 * APART, len(scores))):
        product = scores[lag:].T @ scores[:-lag]
        found = found + (1.0 - lag / (2 * APART)) * (product + product.T)
    return found


def _spread(scores: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the covariance (p, p) of the sum of scores (windows, p), and its degrees of freedom."""
    where = np.flatnonzero(kept)
    scores = scores[where[0] : where[-1] + 1]
    count = len(scores)
    freedom = int(np.clip(0.41 * len(where) ** (2.0 / 3.0), 4, MOST_COSINES))
    turns = np.outer(np.arange(1, freedom + 1), (np.arange(count) + 0.5) / count)
    weights = np.sqrt(2.0) * np.cos(np.pi * turns) @ scores
    return weights.T @ weights / freedom, freedom


# The handle follows its target for some time: its response is made of the target so many seconds before.
_LATER = (0.0, 0.016, 0.048)
# Below that first-stage F an instrument is weak, and intervals are worth nothing (Staiger and Stock 1997).
STRONG = 10.0
# Up to an F of a hundred intervals are too narrow, at 10 by 1.75 (Lee, McCrary, Moreira and Porter 2022).
_WIDER = 7.5


def by_target(
    target: np.ndarray, windows: Windows, columns: np.ndarray, kept: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the columns (windows, p) as the target (n,) in m makes them, and how strong each is (p,)."""
    made = np.zeros_like(columns)
    if not kept.any():
        return made, np.zeros(columns.shape[1])
    instruments = _instruments(target, windows, columns)
    used, own = instruments[kept], columns[kept]
    if len(used) <= 1.5 * instruments.shape[1]:
        return made, np.zeros(columns.shape[1])
    made[kept] = used @ np.linalg.lstsq(used, own, rcond=1e-9)[0]
    return made, _strength(made[kept], own, instruments.shape[1])


def _instruments(target: np.ndarray, windows: Windows, columns: np.ndarray) -> np.ndarray:
    series = [windows.derivative(target, 0)]
    for seconds in _LATER:
        samples = round(seconds / windows.period)
        late = np.concatenate((np.full(samples, target[0]), target[: len(target) - samples]))
        series += [windows.derivative(late, 1), windows.derivative(late, 2)]
    # directions and the constant are known as they are
    found = np.column_stack([*series, columns[:, -2:]])
    return found / np.maximum(np.sqrt(np.mean(found**2, axis=0)), 1e-12)


def _strength(made: np.ndarray, own: np.ndarray, instruments: int) -> np.ndarray:
    """Return each column's F: what of it the target alone makes, beside what it does not."""
    scale = np.maximum(np.sqrt(np.mean(own**2, axis=0)), 1e-300)
    inverse = np.diag(np.linalg.pinv((made / scale).T @ (made / scale)))
    rest = np.mean(((own - made) / scale) ** 2, axis=0)
    # neighbouring windows share their samples: so many of them tell as much as one
    return 1.0 / np.maximum(APART * inverse * rest * instruments, 1e-12)


def widening(strong: np.ndarray) -> np.ndarray:
    """Return by how much intervals are to be wider for the strength of their instruments."""
    return 1.0 + _WIDER / strong

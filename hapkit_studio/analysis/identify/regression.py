"""Instrumental-variable least squares with intervals that are valid for autocorrelated residuals.

Quantisation errors in the regressors would bias estimates towards zero (errors in variables). Each regressor
is therefore computed twice, from different samples with independent errors. Each of the two is the instrument
of the other.

The intervals use the long-run variance of the scores, from a few cosine weights. The weighted sums are
independent even if the scores are not. Student's t has one degree of freedom per weight (Müller 2007;
Lazarus, Lewis, Stock and Watson 2018, J. Business & Economic Statistics 36(4)).

A further instrument is the hand's target, by two-stage least squares. A loop feeds the sensor's steps back
into the motion, and at a constant speed distant samples have correlated errors. The target is independent of
these errors.
"""

from dataclasses import dataclass

import numpy as np
from scipy import stats

from hapkit_studio.analysis.identify.windows import Windows

LEVEL = 0.95
QUANTILE = 1.96  # normal quantile of a 95 % interval
MOST_COSINES = 12
FEWEST_WINDOWS = 12
# windows that are at least this many windows apart share no samples
APART = 6
# smallest autocorrelation at which the residuals are treated as repeating
_REPEATS = 0.4
_FEWEST_AGAIN = 40


@dataclass(frozen=True)
class Fit:
    """Coefficients (p,), covariance (p, p), degrees of freedom, residuals (windows,), and R²."""

    beta: np.ndarray
    covariance: np.ndarray
    freedom: int
    residual: np.ndarray
    explained: float

    @property
    def half(self) -> np.ndarray:
        """Return the half widths (p,) of the confidence intervals."""
        return self.half_of(np.eye(len(self.beta)))

    def half_of(self, gradient: np.ndarray) -> np.ndarray:
        """Return the half widths (k,) of functions of the coefficients with these gradients (k, p)."""
        variance = np.einsum("ki,ij,kj->k", gradient, self.covariance, gradient)
        return np.sqrt(np.maximum(variance, 0.0)) * stats.t.ppf(0.5 + 0.5 * LEVEL, self.freedom)


def solve(
    one: np.ndarray, two: np.ndarray, y: np.ndarray, kept: np.ndarray, again: bool = False
) -> Fit | None:
    """Fit y (windows,) to regressors (windows, p) that were computed twice; use only the windows ``kept``.

    Windows are in order of time and include the windows that are not kept, so that distances in time are
    known. Return None if too few windows are kept or the regressors are collinear. If ``again`` is true,
    repeated residuals are treated as one observation.
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
    middle, freedom = _cosine_covariance(scores, kept)
    times = repetitions(residual, kept) if again else 1.0
    if times > 1.0:
        middle = middle + times * _bartlett_covariance(scores)
    around = y[kept] - y[kept].mean()
    explained = 1.0 - float(residual @ residual) / max(float(around @ around), 1e-300)
    covariance = inverse @ middle @ inverse / np.outer(scale, scale)
    return Fit(beta / scale, covariance, freedom, residual[kept], explained)


def repetitions(residual: np.ndarray, kept: np.ndarray) -> float:
    """Return how often the residuals (windows,) repeat, weighted by their autocorrelation; 1 if never.

    A motion that repeats to within one sensor count also repeats its quantisation errors, so the repetitions
    add no information.
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
    if most < _REPEATS:
        return 1.0
    period = int(np.flatnonzero(alike >= 0.8 * most)[0])
    return 1.0 + (count / period - 1.0) * most


def _bartlett_covariance(scores: np.ndarray) -> np.ndarray:
    """Return the Bartlett long-run covariance (p, p) of the sum of scores (windows, p)."""
    found = scores.T @ scores
    for lag in range(1, min(2 * APART, len(scores))):
        product = scores[lag:].T @ scores[:-lag]
        found = found + (1.0 - lag / (2 * APART)) * (product + product.T)
    return found


def _cosine_covariance(scores: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the covariance (p, p) of the sum of scores (windows, p), and its degrees of freedom."""
    where = np.flatnonzero(kept)
    scores = scores[where[0] : where[-1] + 1]
    count = len(scores)
    freedom = int(np.clip(0.41 * len(where) ** (2.0 / 3.0), 4, MOST_COSINES))
    turns = np.outer(np.arange(1, freedom + 1), (np.arange(count) + 0.5) / count)
    weights = np.sqrt(2.0) * np.cos(np.pi * turns) @ scores
    return weights.T @ weights / freedom, freedom


# s: the target, delayed by these times, is used as an instrument, because the handle follows the target with
# a delay
_LAGS = (0.0, 0.016, 0.048)
# an instrument with a smaller first-stage F is weak (Staiger and Stock 1997)
STRONG = 10.0
# intervals are widened by the factor 1 + _WEAK_WIDENING / F: 1.75 at F = 10, 1.075 at F = 100 (Lee et al.
# 2022)
_WEAK_WIDENING = 7.5


def first_stage(
    target: np.ndarray, windows: Windows, columns: np.ndarray, kept: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the regressors (windows, p) fitted to the target (n,) in m, and the first-stage F (p,)."""
    made = np.zeros_like(columns)
    if not kept.any():
        return made, np.zeros(columns.shape[1])
    instruments = _instruments(target, windows, columns)
    used, own = instruments[kept], columns[kept]
    if len(used) <= 1.5 * instruments.shape[1]:
        return made, np.zeros(columns.shape[1])
    made[kept] = used @ np.linalg.lstsq(used, own, rcond=1e-9)[0]
    return made, _first_stage_f(made[kept], own, instruments.shape[1])


def _instruments(target: np.ndarray, windows: Windows, columns: np.ndarray) -> np.ndarray:
    series = [windows.derivative(target, 0)]
    for seconds in _LAGS:
        samples = round(seconds / windows.period)
        late = np.concatenate((np.full(samples, target[0]), target[: len(target) - samples]))
        series += [windows.derivative(late, 1), windows.derivative(late, 2)]
    # the direction and the constant are exogenous
    found = np.column_stack([*series, columns[:, -2:]])
    return found / np.maximum(np.sqrt(np.mean(found**2, axis=0)), 1e-12)


def _first_stage_f(made: np.ndarray, own: np.ndarray, instruments: int) -> np.ndarray:
    """Return the first-stage F (p,) of each regressor."""
    scale = np.maximum(np.sqrt(np.mean(own**2, axis=0)), 1e-300)
    inverse = np.diag(np.linalg.pinv((made / scale).T @ (made / scale)))
    rest = np.mean(((own - made) / scale) ** 2, axis=0)
    # windows overlap, so only one in APART is independent
    return 1.0 / np.maximum(APART * inverse * rest * instruments, 1e-12)


def widening(strong: np.ndarray) -> np.ndarray:
    """Return the factor by which intervals are widened for a first-stage F."""
    return 1.0 + _WEAK_WIDENING / strong

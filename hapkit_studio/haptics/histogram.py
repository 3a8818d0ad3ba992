"""The loop's own lateness histogram: 1 µs bins to 1 ms, 10 µs to 10 ms, 100 µs to 100 ms, and beyond."""

import numpy as np

from hapkit_studio.dynamics.jit import compiled

_PER_DECADE = 1000
BINS = _PER_DECADE + 2 * 900 + 1


def new_histogram() -> np.ndarray:
    """Return empty bins, int64 (BINS,)."""
    return np.zeros(BINS, dtype=np.int64)


@compiled
def add(bins, lateness):
    """Count one lateness in s."""
    us = lateness * 1e6
    if us < 0.0:
        us = 0.0
    if us < 1e3:
        bins[int(us)] += 1
    elif us < 1e4:
        bins[900 + int(us / 10.0)] += 1
    elif us < 1e5:
        bins[1800 + int(us / 100.0)] += 1
    else:
        bins[BINS - 1] += 1


def _upper_edges() -> np.ndarray:
    fine = np.arange(1, 1001)
    return np.concatenate((fine, 1000 + 10 * np.arange(1, 901), 10_000 + 100 * np.arange(1, 901), [np.inf]))


EDGES_US = _upper_edges()


def percentiles(bins: np.ndarray) -> dict[str, float]:
    """Return p50, p99, p99.9 and max in µs, each the upper edge of its bin; 0 where nothing was counted."""
    total = int(bins.sum())
    if not total:
        return {"p50": 0.0, "p99": 0.0, "p99.9": 0.0, "max": 0.0}
    upto = np.cumsum(bins)
    edges = np.where(np.isinf(EDGES_US), 100_000.0, EDGES_US)
    found = {f"p{q:g}": float(edges[np.searchsorted(upto, q / 100.0 * total)]) for q in (50, 99, 99.9)}
    return {**found, "max": float(edges[np.flatnonzero(bins)[-1]])}

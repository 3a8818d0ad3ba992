"""A min–max pyramid: the least and greatest of any stretch of samples without reading them all.

Above the samples stand the extremes of every 16, 256 and 4096 of them, completed as samples come.
"""

from collections.abc import Iterator

import numpy as np

BRANCH = 16
LEVELS = 3
BLOCK = BRANCH**LEVELS
_DIRECT = 64  # elements a range may hold before the next level up is cheaper than reading them


class Pyramid:
    """Extremes over samples (channels, room); whoever writes the samples says so with ``grow``."""

    def __init__(self, samples: np.ndarray, upper: list[tuple[np.ndarray, np.ndarray]] | None = None):
        channels, room = samples.shape
        if upper is None:
            sizes = [room // BRANCH**level for level in range(1, LEVELS + 1)]
            upper = [(np.empty((channels, size)), np.empty((channels, size))) for size in sizes]
        self.levels = [(samples, samples), *upper]

    def grow(self, first: int, end: int) -> None:
        """Complete the blocks that the samples [first, end) have filled."""
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            a, b = first // size, end // size
            if b == a:
                return
            for table, below, pick in zip(
                self.levels[level], self.levels[level - 1], (np.fmin, np.fmax), strict=True
            ):
                span = below[:, a * BRANCH : b * BRANCH]
                table[:, a:b] = pick.reduce(span.reshape(len(span), b - a, BRANCH), axis=2)

    def shift(self, by: int, end: int) -> None:
        """Move everything but the samples forward by a multiple of BLOCK; end is the samples' end before."""
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            for table in self.levels[level]:
                table[:, : (end - by) // size] = table[:, by // size : end // size].copy()

    def part(self, samples: np.ndarray, first: int, end: int) -> "Pyramid":
        """Return a copy over samples, which hold [first, end) of this one's; first is a multiple of BLOCK."""
        upper = []
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            least, greatest = (table[:, first // size : end // size].copy() for table in self.levels[level])
            upper.append((least, greatest))
        return Pyramid(samples, upper)

    def extremes(self, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return least and greatest (channels, m) of the m non-empty, rising ranges [first, stop)."""
        parts = list(self._parts(first, stop))
        return np.fmin.reduce([part[0] for part in parts]), np.fmax.reduce([part[1] for part in parts])

    def _parts(self, first: np.ndarray, stop: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Split ranges over the levels: ragged ends from each, the middle from the next one up."""
        level = 0
        while level < LEVELS and (stop - first).mean() > _DIRECT:
            yield self._ends(level, first, stop)
            first, stop = -(-first // BRANCH), stop // BRANCH
            level += 1
        yield self._middle(level, first, stop)

    def _ends(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of each range's first and last 16 elements; NaN where it is empty."""
        steps = np.arange(BRANCH)
        left = np.minimum(first[:, None] + steps, stop[:, None] - 1)
        right = np.maximum(stop[:, None] - 1 - steps, first[:, None])
        which = np.clip(np.concatenate([left, right], axis=1), 0, None)
        least, greatest = self.levels[level]
        empty = stop <= first
        return (
            np.where(empty, np.nan, np.fmin.reduce(np.take(least, which, axis=1, mode="clip"), axis=2)),
            np.where(empty, np.nan, np.fmax.reduce(np.take(greatest, which, axis=1, mode="clip"), axis=2)),
        )

    def _middle(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of ranges by one pass over them; NaN where a range is empty."""
        full = stop > first
        least, greatest = self.levels[level]
        out = np.full((2, len(least), len(first)), np.nan)
        if full.any():
            span = slice(int(first[full][0]), int(stop[full][-1]))
            cuts = np.stack([first[full], stop[full]], axis=1).ravel()[:-1] - span.start
            out[0][:, full] = np.fmin.reduceat(least[:, span], cuts, axis=1)[:, 0::2]
            out[1][:, full] = np.fmax.reduceat(greatest[:, span], cuts, axis=1)[:, 0::2]
        return out[0], out[1]

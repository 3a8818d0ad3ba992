"""Compute a map of classes from a few cells: a coarse lattice, then the cells next to a different class.

A cell that was not evaluated gets the class of the nearest evaluated cell. The boundary of every region that
contains a lattice cell, or touches an evaluated cell, is traced completely. Other regions are missed; they
are smaller than a square of the lattice.
"""

from collections.abc import Callable, Iterable

import numpy as np

STEP = 10  # lattice spacing in cells; the number of evaluations is about the same from 8 to 16
_SMALL = 3 * STEP  # if an axis of a map has fewer cells than this, all cells of the map are evaluated

Judge = Callable[[np.ndarray], np.ndarray]
"""Returns the classes (k,) of cells given by their indices (k,) in the flattened map."""


def from_few(shape: tuple[int, int], judge: Judge, seeds: Iterable[tuple[int, int]] = ()) -> np.ndarray:
    """Return a map's classes as an int8 array; ``seeds`` are further cells (row, column) to start with."""
    from scipy import ndimage  # imported here because it is slow

    known, found = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=np.int8)
    wanted = np.full(shape, min(shape) < _SMALL)
    wanted[np.ix_(*map(_lattice, shape))] = True
    for seed in seeds:
        wanted[seed] = True
    while wanted.any():
        found[wanted] = judge(np.flatnonzero(wanted))
        known |= wanted
        nearest = ndimage.distance_transform_cdt(
            ~known, "chessboard", return_distances=False, return_indices=True
        )
        found = found[tuple(nearest)]
        beside_another = ndimage.maximum_filter(found, 3) != ndimage.minimum_filter(found, 3)
        wanted = beside_another & ~known
    return found


def _lattice(count: int) -> np.ndarray:
    """Return indices from 0 to count - 1, both included, that are about ``STEP`` apart."""
    return np.linspace(0, count - 1, max(round((count - 1) / STEP), 1) + 1).round().astype(int)

"""A map of classes from few of its cells: a coarse lattice, then every cell beside one of another class.

A cell that was not judged has the class of the nearest one that was. So every region that holds a cell of the
lattice, or touches one judged on the way, is traced along its whole boundary. An island that does neither is
missed: a square of the lattice's steps has no room in it.
"""

from collections.abc import Callable, Iterable

import numpy as np

STEP = 10  # cells between those of the lattice: with 8 to 16 about as many are judged
_SMALL = 3 * STEP  # cells along an axis, below which all are judged

Judge = Callable[[np.ndarray], np.ndarray]
"""Classes (k,) of cells by their places (k,) in the flattened map."""


def from_few(shape: tuple[int, int], judge: Judge, seeds: Iterable[tuple[int, int]] = ()) -> np.ndarray:
    """Return the classes int8 of a map; seeds are (row, column) of cells to be judged first as well."""
    from scipy import ndimage  # late: a start does not wait for it

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
    """Return indices from 0 to count - 1, both included, about `STEP` apart."""
    return np.linspace(0, count - 1, max(round((count - 1) / STEP), 1) + 1).round().astype(int)

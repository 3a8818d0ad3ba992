"""What the map measures, and what was measured: by the conditions it holds for."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.gui.tabs.job import Progress, Work

if TYPE_CHECKING:
    from hapkit_studio.analysis.plane import Cells, Points
    from hapkit_studio.analysis.setting import Setting

SIDE = 100
COLUMNS = 13
# Bisection takes about so many cells a column.
_CELLS_A_COLUMN = 25


@dataclass(frozen=True)
class Measured:
    """One measurement: its setting, the axes it covers, points and cells, and the seconds it took."""

    setting: "Setting"
    real: bool
    axes: tuple[float, float]
    points: "Points"
    cells: "Cells"
    seconds: float

    @property
    def words(self) -> str:
        """Say how much was measured, and how fast."""
        m, n = self.cells.classes.shape
        return f"{m} × {n} cells, {self.seconds:.1f} s"


def measuring(setting: "Setting", real: bool, axes: tuple[float, float], side: int = SIDE) -> Work:
    """Return the work for a Job: the cells of the map, then the boundary by bisection."""

    def work(progress: Progress) -> Measured:
        from hapkit_studio.analysis.plane import measure_cells, measure_points

        begin = time.monotonic()
        whole, rest = side * side, COLUMNS * _CELLS_A_COLUMN
        across, up = (_middles(end, side) for end in axes)
        say = _part(progress, 0, whole, whole + rest)
        cells = measure_cells(setting, across, up, real=real, progress=say)
        seconds = time.monotonic() - begin
        columns = np.linspace(0.0, axes[0], COLUMNS)
        say = _part(progress, whole, rest, whole + rest)
        points = measure_points(setting, columns, real=real, progress=say)
        return Measured(setting, real, axes, points, cells, seconds)

    return work


def _middles(end: float, count: int) -> np.ndarray:
    return (np.arange(count) + 0.5) * (end / count)


def _part(progress: Progress, before: int, share: int, of: int) -> Callable[[int, int], None]:
    """Return what tells a part's progress as that of the whole."""
    return lambda done, count: progress(before + share * done // max(count, 1), of)

"""What the map measures, and what was measured: by the conditions it holds for."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.gui.tabs.job import Progress, Work

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.analysis.stability.kb_plane import Cells, Plane, Points

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

    def words(self, axes: tuple[float, float]) -> str:
        """Say how much was measured, and how fast; how far, where the map's axes are wider than that."""
        m, n = self.cells.classes.shape
        if axes[0] > self.axes[0] or axes[1] > self.axes[1]:
            return f"Measured to {self.axes[0]:g} N·s/m and {self.axes[1]:,.0f} N/m only"
        return f"{m} × {n} cells, {self.seconds:.1f} s"


class Results:
    """What was measured for one loop: without the passivity controller and with it, the one in sight last."""

    def __init__(self) -> None:
        self.all: list[Measured] = []

    @property
    def last(self) -> Measured | None:
        """Return the measurement in sight."""
        return self.all[-1] if self.all else None

    def take(self, measured: Measured) -> None:
        """Take a measurement in; what was measured for another loop goes."""
        others = [old for old in self.all if old.setting.controller != measured.setting.controller]
        self.all = [*(old for old in others if _same_loop(old, measured)), measured]

    def prefer(self, setting: "Setting", real: bool) -> None:
        """Put the measurement of these conditions last, if there is one."""
        self.all.sort(key=lambda measured: (measured.setting, measured.real) == (setting, real))

    def outdated(self, setting: "Setting", real: bool) -> bool:
        """Say whether it holds for other conditions than these."""
        last = self.last
        return last is not None and (last.setting != setting or last.real != real)

    def put_into(self, plane: "Plane") -> "Plane":
        """Return a plane with what was measured last."""
        last = self.last
        return replace(plane, points=last.points, cells=last.cells) if last else plane


def _same_loop(one: Measured, other: Measured) -> bool:
    """Say whether two measurements differ by the controller alone."""
    return (
        replace(one.setting, controller=other.setting.controller) == other.setting and one.real == other.real
    )


def measuring(setting: "Setting", real: bool, axes: tuple[float, float], side: int = SIDE) -> Work:
    """Return the work for a Job: the cells of the map, then the boundary by bisection."""

    def work(progress: Progress) -> Measured:
        from hapkit_studio.analysis.stability.rendered import measure_cells, measure_points

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

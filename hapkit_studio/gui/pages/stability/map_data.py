"""The data of the stability map: lines that a thread computes, and measurements."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from hapkit_studio.analysis.stability import kb_plane
from hapkit_studio.analysis.stability.kb_plane import Cells, Plane, Points
from hapkit_studio.analysis.stability.margin import Margin, nice_top
from hapkit_studio.analysis.stability.rendered import cell_centres, measure_cells, measure_points
from hapkit_studio.analysis.stability.verdict import VerdictInput, verdict
from hapkit_studio.dynamics.hand import GRIPS
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.formatting import on_screen
from hapkit_studio.gui.state.background import Progress, Work

# if the dot for the rendered impedance is beyond this fraction of an axis, new axes are computed
_EDGE = 0.95


@dataclass(frozen=True)
class LinesRequest:
    """A request for the map's lines: the loop's settings, the rendered impedance and the axes.

    ``axes`` are the map's current limits, damping in N·s/m and stiffness in N/m; they are kept if the dot for
    the rendered impedance lies within them. ``asked`` is the input of the scene's verdict.
    """

    setting: LoopSettings
    stiffness: float
    damping: float
    axes: tuple[float, float] | None = None
    every_hand: bool = False
    asked: VerdictInput | None = None

    def margin(self, hand: str) -> Margin:
        """Return the rendered impedance's margin for a hand, computed in the same way as for the verdict."""
        if self.asked is not None:
            return self.asked.margin(hand)
        return kb_plane.margin_of(replace(self.setting, hand=hand), self.stiffness, self.damping)


@dataclass(frozen=True)
class Lines:
    """The computed lines: a plane of ``kb_plane`` and, if requested, each hand's exact boundary (n,) in N/m.

    ``dampings`` is each hand's damping limit in N·s/m if no stiffness is rendered.
    """

    question: LinesRequest
    plane: Plane
    hands: dict[str, np.ndarray] = field(default_factory=dict)
    dampings: dict[str, float] = field(default_factory=dict)


def solve(ask: LinesRequest) -> Lines:
    """Compute the lines, which are cached: if only the dot has moved, only its margin is computed again."""
    axes = ask.axes
    if axes is None or ask.damping > _EDGE * axes[0] or ask.stiffness > _EDGE * axes[1]:
        axes = _axes(ask)
    margins = {hand: ask.margin(hand) for hand in GRIPS}
    limits = {hand: margin.limit for hand, margin in margins.items()}
    hand = min(limits, key=lambda name: limits[name]) if ask.every_hand else ask.setting.hand
    judged = verdict(ask.asked) if ask.asked else None
    plane = replace(_plane(ask.setting, *axes), margin=margins[hand], hands=limits, verdict=judged)
    every = _every(ask.setting, axes[0]) if ask.every_hand else {}
    return Lines(ask, plane, every, {} if ask.stiffness else damping_limits(ask.setting))


def _axes(ask: LinesRequest) -> tuple[float, float]:
    """Return axes with round limits; if all hands are shown, the firmest hand's boundary fits in the axes."""
    found = kb_plane.plane(ask.setting, ask.stiffness, ask.damping, columns=2)
    highest = max((float(limits.max()) for limits in _every(ask.setting, found.width).values()), default=0.0)
    return found.width, max(found.top, nice_top(1.05 * highest) if ask.every_hand else 0.0)


@lru_cache(maxsize=32)
def _plane(setting: LoopSettings, width: float, top: float) -> Plane:
    return kb_plane.plane(setting, 0.0, 0.0, width=width, top=top)


@lru_cache(maxsize=8)
def _every(setting: LoopSettings, width: float) -> dict[str, np.ndarray]:
    if not setting.linear:
        return {}
    across = np.linspace(0.0, width, kb_plane.COLUMNS)
    return {hand: kb_plane.exact_boundary(replace(setting, hand=hand), across) for hand in GRIPS}


@lru_cache(maxsize=8)
def damping_limits(setting: LoopSettings) -> dict[str, float]:
    """Return each hand's damping limit in N·s/m if no stiffness is rendered, accurate to 0.2 %."""
    found: dict[str, float] = {}
    for hand in GRIPS if setting.linear else ():
        held, low, high = replace(setting, hand=hand), 0.0, 1.0
        while kb_plane.limit(held, high) > 0.0:
            low, high = high, 2.0 * high
        while high - low > 2e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if kb_plane.limit(held, middle) > 0.0 else (low, middle)
        found[hand] = low
    return found


SIDE = 100
COLUMNS = 13
# approximate number of cells per column that the bisection tries
_CELLS_A_COLUMN = 25


@dataclass(frozen=True)
class Measured:
    """One measurement with its settings, axes, points and cells, and its duration in s."""

    setting: LoopSettings
    real: bool
    axes: tuple[float, float]
    points: Points
    cells: Cells
    seconds: float

    def text(self, axes: tuple[float, float]) -> str:
        """Describe the number of cells and the duration.

        If the map's axes are wider than those of the measurement, describe the measured range instead.
        """
        m, n = self.cells.classes.shape
        if axes[0] > self.axes[0] or axes[1] > self.axes[1]:
            return f"Measured only up to {self.axes[0]:g} N·s/m and {self.axes[1]:,.0f} N/m"
        return f"Measured {m} × {n} cells in {on_screen(self.seconds, 's', 2)}"


class Results:
    """The measurements of one loop, without and with the passivity controller; the last one is shown."""

    def __init__(self) -> None:
        self.all: list[Measured] = []

    @property
    def last(self) -> Measured | None:
        """Return the measurement that is shown."""
        return self.all[-1] if self.all else None

    def add(self, measured: Measured) -> None:
        """Add a measurement; drop the measurements of other loops."""
        other = replace(measured.setting, controller=not measured.setting.controller)
        kept = [old for old in self.all if (old.setting, old.real) == (other, measured.real)]
        self.all = [*kept, measured]

    def prefer(self, setting: LoopSettings, real: bool) -> None:
        """Move a measurement under these conditions to the end of the list, so that it is shown."""
        self.all.sort(key=lambda measured: (measured.setting, measured.real) == (setting, real))

    def outdated(self, setting: LoopSettings, real: bool) -> bool:
        """Return whether the measurement that is shown was made under other conditions."""
        last = self.last
        return last is not None and (last.setting != setting or last.real != real)

    def put_into(self, plane: Plane) -> Plane:
        """Return a copy of ``plane`` with the points and cells of the shown measurement."""
        last = self.last
        return replace(plane, points=last.points, cells=last.cells) if last else plane


def measuring(setting: LoopSettings, real: bool, axes: tuple[float, float], side: int = SIDE) -> Work:
    """Return the function that a Job runs: it measures the map's cells, then the boundary by bisection."""

    def work(progress: Progress) -> Measured:
        begin = time.monotonic()
        whole, rest = side * side, COLUMNS * _CELLS_A_COLUMN
        across, up = (cell_centres(end, side) for end in axes)
        report = _part(progress, 0, whole, whole + rest)
        cells = measure_cells(setting, across, up, real=real, progress=report)
        seconds = time.monotonic() - begin
        columns = np.linspace(0.0, axes[0], COLUMNS)
        report = _part(progress, whole, rest, whole + rest)
        points = measure_points(setting, columns, real=real, progress=report)
        return Measured(setting, real, axes, points, cells, seconds)

    return work


def _part(progress: Progress, before: int, share: int, of: int) -> Callable[[int, int], None]:
    """Return a callback that converts the progress of one part into the progress of the whole."""
    return lambda done, count: progress(before + share * done // max(count, 1), of)

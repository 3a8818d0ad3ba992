"""A stretch of the past, shown grey and dotted under the live traces."""

from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QPainter

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.history import CHANNELS, History
from hapkit_studio.gui.widgets.theme import theme

DASH = (2.0, 3.0)
SAMPLE = [1.0, 1.5]
"""The same in widths of a line of 2 px, for a sample beside a name."""


@dataclass(frozen=True)
class PastTrace:
    """A past stretch: its samples in s and SI units, and by how many s later it is shown; words name it."""

    words: str
    time: np.ndarray
    values: dict[str, np.ndarray]
    shift: float = 0.0

    def part(self, channel: str, left: float, right: float, columns: int) -> tuple[np.ndarray, np.ndarray]:
        """Return (time, values) of a channel where shown from left to right s, about two points a column."""
        x = self.time + self.shift
        first, stop = np.searchsorted(x, (left, right))
        inside = slice(max(int(first) - 1, 0), int(stop) + 1)
        x, y = x[inside], self.values[channel][inside]
        size = max(len(x) // max(columns, 1), 1)
        if size < 4:
            return x, y
        starts = np.arange(0, len(x), size)
        low, high = np.fmin.reduceat(y, starts), np.fmax.reduceat(y, starts)
        return np.repeat(x[starts], 2), np.column_stack([low, high]).ravel()


def past_trace(
    history: History, words: str, start: float, stop: float, shift: float = 0.0
) -> PastTrace | None:
    """Return what a history holds from start to stop s, shown so many s later; None for nothing."""
    window = history.between(start, stop)
    known = np.isfinite(window.x)
    if np.count_nonzero(known) < 2:
        return None
    values = {name: window.y[name][known].copy() for name in CHANNELS}
    return PastTrace(words, window.x[known].copy(), values, shift)


def paint_past(painter: QPainter, across: np.ndarray, down: np.ndarray) -> None:
    """Paint a past line given in pixels."""
    painter.setPen(strokes.pen(theme.color("hold"), 2.0))
    strokes.segments(painter, strokes.patterned(across, down, DASH))

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


def past_trace(
    history: History, words: str, start: float, stop: float, shift: float = 0.0
) -> PastTrace | None:
    """Return what a history holds from start to stop s, shown so many s later; None for nothing."""
    window = history.between(start, stop).known()
    values = {name: window.y[name] for name in CHANNELS}
    return PastTrace(words, window.x, values, shift) if len(window.x) > 1 else None


def paint_past(painter: QPainter, across: np.ndarray, down: np.ndarray) -> None:
    """Paint a past line given in pixels."""
    painter.setPen(strokes.pen(theme.color("hold"), 2.0))
    strokes.segments(painter, strokes.patterned(*strokes.thinned(across, down), DASH))

"""A stretch of the past, shown under the live traces in a colour and a dash of its own."""

from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QPainter

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.widgets.theme import theme


@dataclass(frozen=True)
class Look:
    """How a past stretch is drawn: token of its colour, dash in px."""

    token: str
    dash: tuple[float, ...]

    @property
    def sample(self) -> tuple[str, float, list[float]]:
        """Return it as a stroke for a sample beside a name: the dash in widths of a line of 2 px."""
        return self.token, 2.0, [length / 2.0 for length in self.dash]


@dataclass(frozen=True)
class PastTrace:
    """A past stretch: its samples at the times in s at which they are shown, in SI units; words name it.

    pinned: its times count from the right edge of the plots, where it stays while time goes on.
    """

    words: str
    time: np.ndarray
    values: dict[str, np.ndarray]
    look: Look
    pinned: bool


def paint_past(painter: QPainter, across: np.ndarray, down: np.ndarray, look: Look) -> None:
    """Paint a past line given in pixels."""
    painter.setPen(strokes.pen(theme.color(look.token), 2.0))
    strokes.segments(painter, strokes.patterned(*strokes.thinned(across, down), look.dash))

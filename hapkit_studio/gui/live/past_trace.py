"""A stretch of the past, shown under the live traces in a colour and a dash of its own."""

from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QPainter

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.history import CHANNELS, History
from hapkit_studio.gui.widgets.theme import theme


@dataclass(frozen=True)
class Look:
    """How a past stretch is drawn: token of its colour, dash in px."""

    token: str = "hold"
    dash: tuple[float, ...] = (2.0, 3.0)

    @property
    def sample(self) -> tuple[str, float, list[float]]:
        """Return it as a stroke for a sample beside a name: the dash in widths of a line of 2 px."""
        return self.token, 2.0, [length / 2.0 for length in self.dash]


USUAL = Look()


@dataclass(frozen=True)
class PastTrace:
    """A past stretch: its samples at the times in s at which they are shown, in SI units; words name it.

    pinned: its times count from the right edge of the plots, where it stays while time goes on.
    """

    words: str
    time: np.ndarray
    values: dict[str, np.ndarray]
    look: Look = USUAL
    pinned: bool = False


def past_trace(
    history: History, words: str, start: float, stop: float, shift: float = 0.0
) -> PastTrace | None:
    """Return what a history holds from start to stop s, shown so many s later; None for nothing."""
    window = history.between(start, stop).known()
    values = {name: window.y[name] for name in CHANNELS}
    return PastTrace(words, window.x + shift, values) if len(window.x) > 1 else None


def paint_past(painter: QPainter, across: np.ndarray, down: np.ndarray, look: Look) -> None:
    """Paint a past line given in pixels."""
    painter.setPen(strokes.pen(theme.color(look.token), 2.0))
    strokes.segments(painter, strokes.patterned(*strokes.thinned(across, down), look.dash))

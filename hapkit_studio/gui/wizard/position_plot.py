"""Where the handle was over the last seconds."""

from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen, QPolygonF

from hapkit_studio.gui.widgets.theme import number, theme
from hapkit_studio.gui.wizard.recent_plot import BOTTOM, LEFT, RIGHT, RecentPlot

SPAN = 30.0
"""mm from the middle of the picture to its edges."""


class PositionPlot(RecentPlot):
    """Draws positions (n,) in m over times (n,) in s about where the handle began, ± 30 mm."""

    TITLE, NAME = "Way from the start, mm", "Position over time"
    start: float | None = None

    def show_positions(self, time: np.ndarray, position: np.ndarray) -> None:
        """Show positions (n,) in m over board times (n,) in s."""
        self.show_values(time, position)
        if self.start is None:
            self.begin_here()

    def begin_here(self) -> None:
        """Count from where the handle is now: the limits of what follows are about that place."""
        self.start = float(self.values[-1]) if len(self.values) else None

    def _y(self, millimetres: Any) -> Any:
        return self.up((millimetres + SPAN) / (2 * SPAN))

    def draw_ticks(self, painter: QPainter) -> None:
        limit, middle = QPen(theme.color("danger"), 1.4, Qt.PenStyle.DotLine), QPen(theme.color("grid"), 1)
        for tick in (-25, 0, 25):
            self.tick(painter, self._y(tick), number(tick, 0), limit if tick else middle)

    def draw_trace(self, painter: QPainter) -> None:
        x, place = self.thinned()
        y = self._y(1e3 * np.clip(place - (self.start or 0.0), -0.06, 0.06))
        points = [QPointF(float(a), float(b)) for a, b in zip(x, y, strict=True) if a >= LEFT]
        width = self.width() - LEFT - RIGHT
        painter.setClipRect(QRectF(LEFT, self.TOP, width + 8, self.height() - self.TOP - BOTTOM))
        painter.setPen(QPen(theme.color("position"), 2))
        painter.drawPolyline(QPolygonF(points))

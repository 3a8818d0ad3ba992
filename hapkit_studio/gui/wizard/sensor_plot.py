"""The sensor's reading over the last seconds, with its lowest and highest: the saw teeth are its repeats."""

from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen, QPolygonF

from hapkit_studio.gui.widgets.theme import MINUS, theme
from hapkit_studio.gui.wizard.recent_plot import LEFT, RIGHT, RecentPlot

_WORDS = 19


class SensorPlot(RecentPlot):
    """Draws readings (n,) over times (n,) in s, on a scale from bottom to top."""

    TITLE, NAME = "Sensor reading, counts", "Sensor reading over time"
    TOP = 38
    LOWEST = 110
    bottom, top = 0, 1023

    def show_readings(self, time: np.ndarray, raw: np.ndarray, bottom: int, top: int) -> None:
        """Show readings (n,) over board times (n,) in s, and the scale for them."""
        self.bottom, self.top = bottom, top
        self.show_values(time, raw)

    def _y(self, raw: Any) -> Any:
        return self.up((raw - self.bottom) / (self.top - self.bottom))

    def draw_ticks(self, painter: QPainter) -> None:
        for share in (0.0, 0.5, 1.0):
            words = _whole(round(self.bottom + share * (self.top - self.bottom)))
            self.tick(painter, self.up(share), words, QPen(theme.color("grid"), 1))

    def draw_trace(self, painter: QPainter) -> None:
        x, raw = self.thinned()
        y = self._y(raw)
        painter.setPen(QPen(theme.color("position"), 2))
        cuts = np.flatnonzero(np.abs(np.diff(raw)) > 0.4 * max(float(np.ptp(raw)), 64.0)) + 1
        for piece in np.split(np.arange(len(raw)), cuts):
            points = [QPointF(float(x[i]), float(y[i])) for i in piece if x[i] >= LEFT]
            painter.drawPolyline(QPolygonF(points))
        painter.setBrush(theme.color("position"))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.drawEllipse(QPointF(float(x[-1]), float(y[-1])), 4.5, 4.5)
        self._limits(painter)

    def _limits(self, painter: QPainter) -> None:
        low, high = (self._y(float(value)) for value in (self.values.min(), self.values.max()))
        inside = low - high > 2 * _WORDS  # else the words stand side by side, where there is room
        free, x = high < self.height() / 2, LEFT + 4.0
        for value, above in ((int(self.values.min()), False), (int(self.values.max()), True)):
            y = self._y(value)
            painter.setPen(QPen(theme.color("hold"), 1.2, Qt.PenStyle.DashLine))
            painter.drawLine(QPointF(LEFT, y), QPointF(self.width() - RIGHT, y))
            painter.setPen(theme.color("ink2"))
            words = f"{'highest' if above else 'lowest'} {_whole(value)}"
            wide = painter.fontMetrics().horizontalAdvance(words) + 8
            box = QRectF(x, y + 2 if (above if inside else free) else y - _WORDS, wide, 17)
            x += 0.0 if inside else wide + 8.0
            painter.fillRect(box, theme.color("plot", 0.9))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)


def _whole(value: int) -> str:
    """Return a reading as a person reads it."""
    return f"{value:,}".replace("-", MINUS)

"""Where the handle was over the last seconds."""

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from hapkit_studio.gui.theme import number, theme
from hapkit_studio.gui.wizard.sensor_plot import SECONDS

SPAN = 30.0
"""mm from the middle of the picture to its edges."""
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 14, 30, 24
_MOST_POINTS = 1500


class PositionPlot(QWidget):
    """Draws positions (n,) in m over times (n,) in s about where the handle began, ± 30 mm."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.time, self.position = np.empty(0), np.empty(0)
        self.start: float | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(90)
        self.setAccessibleName("Position over time")

    def show_positions(self, time: np.ndarray, position: np.ndarray) -> None:
        """Show positions (n,) in m over board times (n,) in s."""
        self.time, self.position = time, position
        if self.start is None:
            self.begin_here()
        self.update()

    def begin_here(self) -> None:
        """Count from where the handle is now: the limits of what follows are about that place."""
        self.start = float(self.position[-1]) if len(self.position) else None

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("plot"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        painter.setFont(theme.font("strong"))
        painter.setPen(theme.color("ink"))
        painter.drawText(QRectF(14, 6, 300, 20), Qt.AlignmentFlag.AlignVCenter, "Way from the start, mm")
        self._grid(painter)
        if len(self.position) > 1:
            self._trace(painter)

    def _y(self, millimetres: float) -> float:
        return self.height() - _BOTTOM - (millimetres + SPAN) / (2 * SPAN) * (self.height() - _TOP - _BOTTOM)

    def _grid(self, painter: QPainter) -> None:
        painter.setFont(theme.font("tick"))
        for tick in (-25, 0, 25):
            y = self._y(tick)
            limit = QPen(theme.color("danger"), 1.4, Qt.PenStyle.DotLine)
            painter.setPen(limit if tick else QPen(theme.color("grid"), 1))
            painter.drawLine(QPointF(_LEFT, y), QPointF(self.width() - _RIGHT, y))
            painter.setPen(theme.color("axis"))
            flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(QRectF(0, y - 9, _LEFT - 8, 18), flags, number(tick, 0))
        words = QRectF(_LEFT, self.height() - _BOTTOM + 3, self.width() - _LEFT - _RIGHT, 18)
        painter.drawText(words, Qt.AlignmentFlag.AlignRight, f"last {SECONDS:g} s")

    def _trace(self, painter: QPainter) -> None:
        step = max(1, len(self.time) // _MOST_POINTS)
        way = self.position[::step] - (self.start or 0.0)
        time, place = self.time[::step], 1e3 * np.clip(way, -0.06, 0.06)
        width = self.width() - _LEFT - _RIGHT
        x = self.width() - _RIGHT - (time[-1] - time) / SECONDS * width
        points = [QPointF(float(a), self._y(float(b))) for a, b in zip(x, place, strict=True) if a >= _LEFT]
        painter.setClipRect(QRectF(_LEFT, _TOP, width + 8, self.height() - _TOP - _BOTTOM))
        painter.setPen(QPen(theme.color("position"), 2))
        painter.drawPolyline(QPolygonF(points))

"""The sensor's reading over the last seconds, with its lowest and highest: the saw teeth are its repeats."""

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from hapkit_studio.gui.theme import theme

SECONDS = 10.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 58, 14, 38, 24
_MOST_POINTS = 1500
_WORDS = 19


class SensorPlot(QWidget):
    """Draws readings (n,) over times (n,) in s; top is the largest reading there can be."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.time, self.raw = np.empty(0), np.empty(0)
        self.top = 1023
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(110)
        self.setAccessibleName("Sensor reading over time")

    def show_readings(self, time: np.ndarray, raw: np.ndarray, top: int) -> None:
        """Show readings (n,) over board times (n,) in s."""
        self.time, self.raw, self.top = time, raw, top
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("plot"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        self._axes(painter)
        if len(self.raw) > 1:
            self._trace(painter)
            self._limits(painter)

    def _y(self, reading: float) -> float:
        return self.height() - _BOTTOM - reading / self.top * (self.height() - _TOP - _BOTTOM)

    def _axes(self, painter: QPainter) -> None:
        painter.setFont(theme.font("strong"))
        painter.setPen(theme.color("ink"))
        painter.drawText(QRectF(14, 6, 300, 20), Qt.AlignmentFlag.AlignVCenter, "Sensor reading, counts")
        painter.setFont(theme.font("tick"))
        for share in (0.0, 0.5, 1.0):
            y = self._y(share * self.top)
            painter.setPen(QPen(theme.color("grid"), 1))
            painter.drawLine(QPointF(_LEFT, y), QPointF(self.width() - _RIGHT, y))
            painter.setPen(theme.color("axis"))
            box = QRectF(0, y - 9, _LEFT - 8, 18)
            flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(box, flags, f"{round(share * self.top):,}")
        words = QRectF(_LEFT, self.height() - _BOTTOM + 3, self.width() - _LEFT - _RIGHT, 18)
        painter.drawText(words, Qt.AlignmentFlag.AlignRight, f"last {SECONDS:g} s")

    def _limits(self, painter: QPainter) -> None:
        low, high = self._y(float(self.raw.min())), self._y(float(self.raw.max()))
        inside = low - high > 2 * _WORDS  # else the words stand outside their lines
        for value, above in ((int(self.raw.min()), False), (int(self.raw.max()), True)):
            y = self._y(value)
            painter.setPen(QPen(theme.color("hold"), 1.2, Qt.PenStyle.DashLine))
            painter.drawLine(QPointF(_LEFT, y), QPointF(self.width() - _RIGHT, y))
            painter.setPen(theme.color("ink2"))
            words = f"{'highest' if above else 'lowest'} {value:,}"
            wide = painter.fontMetrics().horizontalAdvance(words) + 8
            box = QRectF(_LEFT + 4, y + 2 if above == inside else y - _WORDS, wide, 17)
            painter.fillRect(box, theme.color("plot", 0.9))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, words)

    def _trace(self, painter: QPainter) -> None:
        step = max(1, len(self.raw) // _MOST_POINTS)
        time, raw = self.time[::step], self.raw[::step]
        width = self.width() - _LEFT - _RIGHT
        x = self.width() - _RIGHT - (time[-1] - time) / SECONDS * width
        y = self.height() - _BOTTOM - raw / self.top * (self.height() - _TOP - _BOTTOM)
        painter.setPen(QPen(theme.color("position"), 2))
        cuts = np.flatnonzero(np.abs(np.diff(raw)) > 0.4 * max(float(np.ptp(raw)), 64.0)) + 1
        for piece in np.split(np.arange(len(raw)), cuts):
            points = [QPointF(float(x[i]), float(y[i])) for i in piece if x[i] >= _LEFT]
            painter.drawPolyline(QPolygonF(points))
        painter.setBrush(theme.color("position"))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.drawEllipse(QPointF(float(x[-1]), float(y[-1])), 4.5, 4.5)

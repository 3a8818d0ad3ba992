"""A value over the last seconds, the newest on the right: what the plots of the steps share."""

from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from hapkit_studio.gui.widgets.theme import theme

SECONDS = 10.0
LEFT, RIGHT, BOTTOM = 58, 14, 24
_MOST_POINTS = 1500


class RecentPlot(QWidget):
    """Draws values (n,) over board times (n,) in s; each kind has its own scale, ticks and trace."""

    TITLE = NAME = ""
    TOP = 30
    LOWEST = 90
    """Title, name for screen readers, pixels above the trace, least height in pixels."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self.time, self.values = np.empty(0), np.empty(0)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(self.LOWEST)
        self.setAccessibleName(self.NAME)

    def show_values(self, time: np.ndarray, values: np.ndarray) -> None:
        """Show values (n,) over board times (n,) in s."""
        self.time, self.values = time, values
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("plot"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        painter.setFont(theme.font("strong"))
        painter.setPen(theme.color("ink"))
        painter.drawText(QRectF(14, 6, 300, 20), Qt.AlignmentFlag.AlignVCenter, self.TITLE)
        painter.setFont(theme.font("tick"))
        self.draw_ticks(painter)
        words = QRectF(LEFT, self.height() - BOTTOM + 3, self.width() - LEFT - RIGHT, 18)
        painter.drawText(words, Qt.AlignmentFlag.AlignRight, f"last {SECONDS:g} s")
        if len(self.values) > 1:
            self.draw_trace(painter)

    def draw_ticks(self, painter: QPainter) -> None:
        """Draw the lines of the scale."""
        raise NotImplementedError

    def draw_trace(self, painter: QPainter) -> None:
        """Draw the values."""
        raise NotImplementedError

    # --- for each kind
    def up(self, share: Any) -> Any:
        """Return the y of shares of the way from bottom to top."""
        return self.height() - BOTTOM - share * (self.height() - self.TOP - BOTTOM)

    def tick(self, painter: QPainter, y: float, words: str, pen: QPen) -> None:
        painter.setPen(pen)
        painter.drawLine(QPointF(LEFT, y), QPointF(self.width() - RIGHT, y))
        painter.setPen(theme.color("axis"))
        flags = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(QRectF(0, y - 9, LEFT - 8, 18), flags, words)

    def thinned(self) -> tuple[np.ndarray, np.ndarray]:
        """Return x and value of the points to draw, (m,) each."""
        step = max(1, len(self.time) // _MOST_POINTS)
        time, values = self.time[::step], self.values[::step]
        return self.width() - RIGHT - (time[-1] - time) / SECONDS * (self.width() - LEFT - RIGHT), values

"""A curve that fades with age: one layer a second, each painted once, as its points arrive."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QImage, QPainter

from hapkit_studio.gui.plots import strokes

SECONDS = 10
_AGES = (1.0, 1.0, 0.55, 0.55, 0.40, 0.40, 0.30, 0.30, 0.25, 0.25, 0.25)  # opacity by whole seconds


class Layers:
    """The last seconds of a curve, in pixels of one frame."""

    def __init__(self, box: QRectF, ratio: float, color: QColor):
        self.box, self.ratio, self.color = box, ratio, color
        self._layers: deque[tuple[int, QImage]] = deque(maxlen=SECONDS + 1)
        self._waiting: list[tuple[int, np.ndarray]] = []
        self._tail = np.empty((2, 0))

    def begin(self, time: np.ndarray, line: np.ndarray) -> None:
        """Take a whole curve at once: its newest second is painted now, one older second at each ``add``."""
        parts = _by_second(time, line)
        for (second, points), (_, following) in pairwise(parts):
            self._waiting.append((second, np.concatenate([points, following[:, :1]], axis=1)))
        for second, points in parts[-1:]:
            self._continue(second, points)

    def add(self, time: np.ndarray, line: np.ndarray) -> bool:
        """Continue the curve by pixels (2, n) at times (n,) in s; say whether any but the newest changed."""
        before = self._layers[-1][0] if self._layers else None
        for second, points in _by_second(time, line):
            self._continue(second, points)
        if self._waiting and self._layers:
            second, points = self._waiting.pop()
            if self._layers[-1][0] - second <= SECONDS:
                image = self._blank()
                self._paint(image, points)
                self._layers.appendleft((second, image))
                return True
            self._waiting.clear()
        return bool(self._layers) and self._layers[-1][0] != before

    def _continue(self, second: int, points: np.ndarray) -> None:
        if not self._layers or self._layers[-1][0] != second:
            self._layers.append((second, self._blank()))
        line = np.concatenate([self._tail, points], axis=1)
        self._tail = line[:, -1:]
        self._paint(self._layers[-1][1], line)

    def _paint(self, image: QImage, line: np.ndarray) -> None:
        painter = QPainter(image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(-self.box.topLeft())
        strokes.trace(painter, line[0], line[1], self.color)
        painter.end()

    def _blank(self) -> QImage:
        width, height = (max(math.ceil(n * self.ratio), 1) for n in (self.box.width(), self.box.height()))
        image = QImage(width, height, QImage.Format.Format_ARGB32_Premultiplied)
        image.setDevicePixelRatio(self.ratio)
        image.fill(Qt.GlobalColor.transparent)
        return image

    def paint_old(self, painter: QPainter) -> None:
        """Paint every layer but the newest, paler the older."""
        for second, image in list(self._layers)[:-1]:
            age = self._layers[-1][0] - second
            if age < len(_AGES):
                painter.setOpacity(_AGES[age])
                painter.drawImage(self.box.topLeft(), image)
        painter.setOpacity(1.0)

    def paint_newest(self, painter: QPainter) -> None:
        """Paint the layer that is still growing."""
        if self._layers:
            painter.drawImage(self.box.topLeft(), self._layers[-1][1])


def _by_second(time: np.ndarray, line: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """Split a curve by whole seconds; a break, which has no time, goes with the points before it."""
    if not len(time):
        return []
    seconds = np.floor(np.fmax.accumulate(time))
    whole = np.unique(seconds[np.isfinite(seconds)]).astype(int)
    return [(int(second), line[:, seconds == second]) for second in whole]

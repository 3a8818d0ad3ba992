"""A curve that fades with age: one layer a second, each painted once, as its points arrive.

When the frame's place in the data changes, every layer is painted anew, one at a time; until its turn comes
each is shown as it was painted, moved and scaled to where its points now are.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter

from hapkit_studio.gui.plots import strokes

SECONDS = 10
_AGES = (1.0, 1.0, 0.55, 0.55, 0.40, 0.40, 0.30, 0.30, 0.25, 0.25, 0.25)  # opacity by whole seconds


@dataclass(frozen=True)
class Place:
    """A frame in pixels, and where data lies in it: left + across·x, bottom + up·y."""

    box: QRectF
    left: float
    across: float
    bottom: float
    up: float

    def moved(self, size: QSizeF, to: "Place") -> QRectF:
        """Return where a picture of this frame lies once its data is shown in another place."""
        wider, higher = to.across / self.across, to.up / self.up
        x = to.left + (self.box.left() - self.left) * wider
        y = to.bottom + (self.box.top() - self.bottom) * higher
        return QRectF(x, y, size.width() * wider, size.height() * higher)


@dataclass(frozen=True)
class Layer:
    """One second of a curve, painted for a place."""

    image: QImage
    place: Place

    def paint(self, painter: QPainter, place: Place) -> None:
        """Paint it where its points lie in that place."""
        if self.place == place:
            painter.drawImage(place.box.topLeft(), self.image)
        else:
            target = self.place.moved(self.image.deviceIndependentSize(), place)
            painter.drawImage(target, self.image, QRectF(self.image.rect()))


class Layers:
    """The last seconds of a curve."""

    def __init__(self) -> None:
        self._layers: dict[int, Layer] = {}
        self._newest = 0
        self._waiting: list[tuple[int, np.ndarray]] = []
        self._tail = np.empty((2, 0))

    def begin(self, place: Place, ratio: float, color: QColor, time: np.ndarray, line: np.ndarray) -> None:
        """Take a whole curve at once: its newest second is painted now, one older second at each ``add``."""
        self._place, self._ratio, self._color = place, ratio, color
        self._tail, self._waiting = np.empty((2, 0)), []
        parts = _by_second(time, line)
        for (second, points), (_, following) in pairwise(parts):
            self._waiting.append((second, np.concatenate([points, following[:, :1]], axis=1)))
        for second, points in parts[-1:]:
            self._layers.pop(second, None)
            self._continue(second, points)

    def add(self, time: np.ndarray, line: np.ndarray) -> bool:
        """Continue the curve by pixels (2, n) at times (n,) in s; say whether any but the newest changed."""
        before = self._newest
        for second, points in _by_second(time, line):
            self._continue(second, points)
        if not self._waiting:
            return self._newest != before
        second, points = self._waiting.pop()
        if self._newest - second <= SECONDS:
            self._layers[second] = self._painted(self._blank(), points)
        else:
            self._waiting.clear()
        return True

    def _continue(self, second: int, points: np.ndarray) -> None:
        if second not in self._layers:
            self._layers[second], self._newest = self._blank(), second
            self._layers = {s: layer for s, layer in self._layers.items() if second - s <= SECONDS}
        line = np.concatenate([self._tail, points], axis=1)
        self._tail = line[:, -1:]
        self._painted(self._layers[second], line)

    def _painted(self, layer: Layer, line: np.ndarray) -> Layer:
        painter = QPainter(layer.image)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(-self._place.box.topLeft())
        strokes.trace(painter, line[0], line[1], self._color)
        painter.end()
        return layer

    def _blank(self) -> Layer:
        size = self._place.box.size() * self._ratio
        image = QImage(
            max(math.ceil(size.width()), 1),
            max(math.ceil(size.height()), 1),
            QImage.Format.Format_ARGB32_Premultiplied,
        )
        image.setDevicePixelRatio(self._ratio)
        image.fill(Qt.GlobalColor.transparent)
        return Layer(image, self._place)

    def paint_old(self, painter: QPainter, place: Place) -> None:
        """Paint every layer but the newest, paler the older."""
        for second, layer in sorted(self._layers.items(), key=lambda item: item[0]):
            age = self._newest - second
            if 0 < age < len(_AGES):
                painter.setOpacity(_AGES[age])
                layer.paint(painter, place)
        painter.setOpacity(1.0)

    def paint_newest(self, painter: QPainter, place: Place) -> None:
        """Paint the layer that is still growing."""
        if self._newest in self._layers:
            self._layers[self._newest].paint(painter, place)


def _by_second(time: np.ndarray, line: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """Split a curve by whole seconds; a break, which has no time, goes with the points before it."""
    if not len(time):
        return []
    seconds = np.floor(np.fmax.accumulate(time))
    whole = np.unique(seconds[np.isfinite(seconds)]).astype(int)
    return [(int(second), line[:, seconds == second]) for second in whole]

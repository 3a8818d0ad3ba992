"""What a phase plot is painted from: the theory as a band, and the curve in layers that fade with age."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPolygonF

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.widgets.theme import theme

_FAR = 1e4  # px
_LEAST_FORCE = 0.5  # N
_OVER_LIMIT = 1.35  # of the force limit: what lies beyond is not worth showing
_MARGIN = 0.12
_BENT = 1e-6  # of the force's span: a bend smaller than this is rounding
_TURNS = 5  # to each side: the end of a well at the centre, then two wells more
_BEYOND = 1.1  # a bend wants to be inside the frame, not on it

Mapping = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
SECONDS = 10
_AGES = (1.0, 1.0, 0.55, 0.55, 0.40, 0.40, 0.30, 0.30, 0.25, 0.25, 0.25)  # opacity by whole seconds


@dataclass(frozen=True)
class Band:
    """The law's force in N, one row a branch (m, n), over x (n,) in the plot's unit; NaN: no curve there."""

    x: np.ndarray
    force: np.ndarray

    def forces(self, reach: float, max_force: float) -> tuple[float, float]:
        """Return the forces in N to show within ±reach, with a margin, under a force limit in N."""
        seen = self.force[:, np.abs(self.x) <= reach]
        seen = seen[np.isfinite(seen)]
        low, high = seen.min(initial=-_LEAST_FORCE), seen.max(initial=_LEAST_FORCE)
        most = _OVER_LIMIT * max_force
        low, high = max(low, -most), min(high, most)
        margin = _MARGIN * (high - low)
        return low - margin, high + margin

    def reach(self, least: float, most: float, max_force: float) -> float:
        """Return how far to each side, least to most, the plot opens, rounded up to quarters of the least.

        Up to the last bend that the motor can render, or, where the curve goes up and down, a few turns.
        """
        sides = [(side, row) for row in self.force for side in (1.0, -1.0)]
        far = max((self._last(row, side, most, max_force) for side, row in sides), default=0.0)
        part = least / 4.0
        return min(max(math.ceil(_BEYOND * far / part - 1e-9) * part, least), most)

    def _last(self, row: np.ndarray, side: float, most: float, max_force: float) -> float:
        """Return how far out one branch is of interest to one side; 0 where it is straight."""
        out = np.argsort(side * self.x)
        out = out[(side * self.x[out] >= 0.0) & (side * self.x[out] <= most)]
        distance, force = np.abs(self.x[out]), row[out]
        least = _BENT * np.fmax.reduce(np.abs(force), initial=0.0)
        rise = np.diff(force)
        rise[np.abs(rise) <= least] = 0.0
        shown = np.abs(force) < _OVER_LIMIT * max_force
        bent = np.abs(np.diff(rise)) > least
        bends = np.flatnonzero(bent & shown[:-2] & shown[2:]) + 1
        if not len(bends):
            return 0.0
        going = np.flatnonzero(np.nan_to_num(rise))
        turns = going[1:][rise[going[1:]] * rise[going[:-1]] < 0.0][:_TURNS]
        last = min(bends[-1], turns[-1]) if len(turns) == _TURNS else bends[-1]
        return float(distance[last])

    def paint(self, painter: QPainter, to_pixels: Mapping) -> None:
        """Paint the kerbs of all branches, then the band."""
        lines = [line for force in self.force for line in self._unbroken(force, to_pixels)]
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            painter.setPen(QPen(theme.color(token), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
            for line in lines:
                painter.drawPolyline(line)

    def _unbroken(self, force: np.ndarray, to_pixels: Mapping) -> list[QPolygonF]:
        """Return a branch as lines in pixels, cut where it has no value."""
        across, up = to_pixels(self.x, force)
        cuts = np.flatnonzero(np.diff(np.isfinite(force))) + 1
        pieces = zip(np.split(across, cuts), np.split(np.clip(up, -_FAR, _FAR), cuts), strict=True)
        return [QPolygonF(list(map(QPointF, a, b))) for a, b in pieces if np.isfinite(b[0])]


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

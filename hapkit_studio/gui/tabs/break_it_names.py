"""Writes names into a chart where they hide least of it."""

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFontMetricsF, QPainter

from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.theme import theme

# Where a name may stand: its base line's x and y, and how much of it lies left of x.
Spot = tuple[float, float, float]
_NEAR = 3.0


class Names:
    """Knows what is drawn: points, upright lines at these x, and the names written so far."""

    def __init__(self, painter: QPainter, frame: QRectF, points: Sequence[QPointF], upright: Sequence[float]):
        self._painter, self._frame = painter, frame
        self._points, self._upright = points, upright
        self._written: list[QRectF] = []

    def write(self, text: str, token: str, role: str, spots: Sequence[Spot]) -> None:
        """Write at the best of some spots; of equals, at the first."""
        boxes = [self._box(text, role, spot) for spot in spots]
        costs = [self._cost(box) for box in boxes]
        x, y, anchor = spots[costs.index(min(costs))]
        box = marks.write(self._painter, QPointF(x, y), text, token, role, anchor, self._frame)
        self._written.append(box)

    def _box(self, text: str, role: str, spot: Spot) -> QRectF:
        metrics = QFontMetricsF(theme.font(role))
        width, (x, y, anchor) = metrics.horizontalAdvance(text), spot
        return QRectF(x - anchor * width, y - metrics.ascent(), width, metrics.height())

    def _cost(self, box: QRectF) -> float:
        """Count what lies under a box; out of the frame is worst, another name next."""
        around = box.adjusted(-_NEAR, -_NEAR, _NEAR, _NEAR)
        inside = self._frame.left() <= box.left() and box.right() <= self._frame.right()
        cost = 0.0 if inside else 1000.0
        cost += 100.0 * sum(around.intersects(other) for other in self._written)
        cost += 30.0 * sum(box.left() < x < box.right() for x in self._upright)
        return cost + sum(around.contains(point) for point in self._points)

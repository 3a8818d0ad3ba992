"""What charts are drawn with: lines, markers of eight shapes, regions, words, arrows."""

import math
from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from hapkit_studio.gui.painting import words
from hapkit_studio.gui.theme import theme

DOT, DASH, DASH_DOT = [1.6, 2.4], [5.0, 3.5], [7.0, 2.6, 1.6, 2.6]
_RIM = 4.0


def line(
    painter: QPainter,
    points: Sequence[QPointF],
    token: str,
    width: float = 2.0,
    dash: list[float] | None = None,
    alpha: float = 1.0,
) -> None:
    """Draw a line through pixels."""
    pen = QPen(theme.color(token, alpha), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    if dash:
        pen.setDashPattern(dash)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPolyline(QPolygonF(list(points)))


def region(painter: QPainter, points: Sequence[QPointF], token: str, hatch: str = "") -> None:
    """Fill an area; hatch is the token of lines across it."""
    painter.setPen(Qt.PenStyle.NoPen)
    for brush in (QBrush(theme.color(token)), hatching(hatch) if hatch else None):
        if brush is not None:
            painter.setBrush(brush)
            painter.drawPolygon(QPolygonF(list(points)))


def hatching(token: str, alpha: float = 0.25) -> QBrush:
    """Return a brush of slanted lines."""
    return QBrush(theme.color(token, alpha), Qt.BrushStyle.BDiagPattern)


def _corners(count: int, turn: float, inner: float = 1.0) -> list[tuple[float, float]]:
    steps = count if inner == 1.0 else 2 * count
    sizes = [1.0 if i % 2 == 0 else inner for i in range(steps)]
    angles = [turn + 2.0 * math.pi * i / steps for i in range(steps)]
    return [(r * math.sin(a), -r * math.cos(a)) for r, a in zip(sizes, angles, strict=True)]


SHAPES: dict[str, list[tuple[float, float]]] = {
    "star": _corners(5, 0.0, 0.45),
    "diamond": [(0.0, -1.05), (1.05, 0.0), (0.0, 1.05), (-1.05, 0.0)],
    "square": [(-0.82, -0.82), (0.82, -0.82), (0.82, 0.82), (-0.82, 0.82)],
    "pentagon": _corners(5, 0.0),
    "up": _corners(3, 0.0),
    "down": _corners(3, math.pi),
}


def marker(
    painter: QPainter, shape: str, at: QPointF, token: str, size: float = 5.5, filled: bool = True
) -> None:
    """Draw a marker: circle, plus, cross, or one of SHAPES; hollow ones show the ground."""
    color = theme.color(token)
    painter.setPen(QPen(color, 2.6 if shape in ("plus", "cross") else 1.6))
    painter.setBrush(color if filled else theme.color("plot"))
    if shape == "circle":
        painter.drawEllipse(at, 0.86 * size, 0.86 * size)
    elif shape == "plus":
        painter.drawLine(at - QPointF(size, 0.0), at + QPointF(size, 0.0))
        painter.drawLine(at - QPointF(0.0, size), at + QPointF(0.0, size))
    elif shape == "cross":
        painter.drawLine(at - QPointF(size, size) * 0.75, at + QPointF(size, size) * 0.75)
        painter.drawLine(at + QPointF(-size, size) * 0.75, at + QPointF(size, -size) * 0.75)
    else:
        painter.drawPolygon(QPolygonF([at + QPointF(size * x, size * y) for x, y in SHAPES[shape]]))


def write(
    painter: QPainter,
    at: QPointF,
    text: str,
    token: str,
    role: str = "label",
    anchor: float = 0.0,
    inside: QRectF | None = None,
) -> QRectF:
    """Write words on a base line with a rim of the ground; return the box they take.

    anchor: 0 begins at the point, 0.5 is centred on it, 1 ends there; inside keeps them within a frame.
    """
    font = theme.font(role)
    metrics = QFontMetricsF(font)
    width = metrics.horizontalAdvance(text)
    x, y = at.x() - anchor * width, at.y()
    if inside is not None:
        x = min(max(x, inside.left() + 4), inside.right() - width - 4)
        y = min(max(y, inside.top() + metrics.ascent() + 2), inside.bottom() - metrics.descent() - 2)
    words(painter, x, y, text, font, (token, "plot"), _RIM, painter.device().devicePixelRatio())
    return QRectF(x, y - metrics.ascent(), width, metrics.height())


def arrow(painter: QPainter, start: QPointF, end: QPointF, token: str, width: float = 2.0) -> None:
    """Draw a line with a head at its end."""
    along = end - start
    length = math.hypot(along.x(), along.y())
    if length < 1.0:
        return
    unit = along / length
    across = QPointF(-unit.y(), unit.x())
    size = min(9.0, length)
    back, side = end - unit * size, across * (0.45 * size)
    line(painter, [start, end - unit * (0.7 * size)], token, width)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(theme.color(token))
    painter.drawPolygon(QPolygonF([end, back + side, back - side]))


def ring(painter: QPainter, at: QPointF, token: str, radius: float = 10.0, width: float = 2.2) -> None:
    """Draw a ring."""
    painter.setPen(QPen(QColor(theme.color(token)), width))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    path = QPainterPath()
    path.addEllipse(at, radius, radius)
    painter.drawPath(path)

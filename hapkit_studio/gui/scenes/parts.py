"""Parts that several scenes share: solid blocks, reliefs with a ball on them, labels on a background."""

import math
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainterPath, QPen, QPolygonF

from hapkit_studio.gui.scenes.base import Motion, Values
from hapkit_studio.gui.scenes.stage import HALF_TRAVEL, Stage
from hapkit_studio.gui.widgets.text import paint_text
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.palette import luminance

BALL = 6.5  # px at u = 1: radius of the ball including half the outline
_OUTLINE = 1.2

# maps positions (n,) in mm to heights (n,) in px above the rail
Relief = Callable[[np.ndarray], np.ndarray]


# fixed parts ------------------------------------------------------------------------------------


def block(stage: Stage, face: float, end: float, token: str = "mat", hatched: bool = True) -> None:
    """Draw a solid block between two pixel columns, with a rounded corner at its face."""
    side = 1 if end > face else -1
    top, low, corner = stage.top + 2 * stage.u, stage.rail - 1.25 * stage.u, 7 * stage.u * side
    if side * (end - face) <= abs(corner):
        return
    inner = face + corner
    edge = QPainterPath(QPointF(inner, top))
    edge.quadTo(face, top, face, top + abs(corner))
    edge.lineTo(face, low)
    solid = QPainterPath(edge)
    solid.lineTo(end, low)
    solid.lineTo(end, top)
    if hatched:
        stage.hatch(solid, token)
    else:
        stage.p.fillPath(solid, theme.color(token))
    edge.moveTo(end, top)
    edge.lineTo(inner, top)
    stage.stroke(edge, stage.pen("matline", 2.6))


def surface_line(stage: Stage, x: float, token: str = "matline") -> None:
    """Draw a dashed line where the face would be if the handle did not press it in."""
    stage.line(x, stage.top + 2 * stage.u, x, stage.rail, stage.pen(token, 1.6, (4, 4)))


def mark(stage: Stage, x: float, text: str) -> None:
    """Mark a fixed position below the rail with a triangle and a label."""
    u = stage.u
    top, low = stage.rail + u, stage.rail + 9 * u
    stage.use(stage.pen("matline", 0.5), "matline")
    stage.polygon([(x, top), (x - 4.5 * u, low), (x + 4.5 * u, low)])
    stage.write(text, [(x, stage.rail + 22 * u, 0)], "matline", 12, 600, must=True)


def label(
    stage: Stage, text: str, x: float, y: float, tokens: tuple[str, str], size: float = 12.0,
    weight: int = 600,
) -> None:  # fmt: skip
    """Write a centred label on a coloured background; ``tokens`` are the colours of text and background."""
    font, metrics = stage.font(size, weight)
    wide, high = metrics.horizontalAdvance(text), metrics.capHeight() + 6
    box = QRectF(x - wide / 2, y - high + 3, wide, high)
    stage.occupied.append(box)
    stage.texts.append(box)
    paint_text(stage.p, box.left(), y, text, font, tokens, 2.0 * stage.u, stage.ratio)


def on_object() -> str:
    """Return the colour token with the highest contrast for a label on a moving object."""
    ground = luminance(theme.tokens["obj"]) + 0.05
    ratios = {token: (luminance(theme.tokens[token]) + 0.05) / ground for token in ("ink", "scene")}
    return max(ratios, key=lambda token: max(ratios[token], 1.0 / ratios[token]))


def text_width(stage: Stage, text: str, size: float = 12.0, weight: int = 600) -> float:
    """Return the width of a label in px."""
    return stage.font(size, weight)[1].horizontalAdvance(text)


# reliefs ----------------------------------------------------------------------------------------


def sampled(stage: Stage, relief: Relief) -> Relief:
    """Return the relief as a table with one value per pixel, so that it can be evaluated fast."""
    columns = _columns(stage)
    heights = relief(columns)
    return lambda mm: np.interp(mm, columns, heights)


def _columns(stage: Stage) -> np.ndarray:
    """Return a position in mm for each pixel between the rail's ends."""
    return np.linspace(-HALF_TRAVEL, HALF_TRAVEL, math.ceil(2.0 * HALF_TRAVEL * stage.per_mm) + 1)


def ribbon(x: np.ndarray, y: np.ndarray, width: float) -> QPainterPath:
    """Return a line through points (n,) in px as an area, which Qt draws faster than a wide line."""
    slope = np.gradient(y, x)
    across = 0.5 * width / np.sqrt(1.0 + slope**2)
    edges = [(x - slope * across * side, y + across * side) for side in (-1.0, 1.0)]
    there = zip(*edges[0], strict=True)
    back = zip(edges[1][0][::-1], edges[1][1][::-1], strict=True)
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.WindingFill)
    path.addPolygon(QPolygonF([QPointF(a, b) for a, b in (*there, *back)]))
    path.closeSubpath()
    return path


def ground(stage: Stage, relief: Relief, fine: bool = False) -> None:
    """Fill and outline a relief along the rail; if ``fine`` is True, the outline is thin."""
    columns = _columns(stage)
    x, rows = stage.width / 2 + columns * stage.per_mm, stage.rail - relief(columns)
    left, right, low = float(x[0]), float(x[-1]), stage.rail
    line = [QPointF(a, b) for a, b in zip(x, rows, strict=True)]
    if fine:
        level = float(rows.mean())
        stage.p.fillRect(QRectF(left, level, right - left, low - level), theme.color("mat"))
        stage.p.setPen(QPen(theme.color("matline"), 1.0))
        stage.p.drawPolyline(QPolygonF(line))
        return
    body = QPainterPath()
    body.addPolygon(QPolygonF([QPointF(left, low), *line, QPointF(right, low)]))
    stage.p.fillPath(body, theme.color("mat"))
    stage.p.fillPath(ribbon(x, rows, 2.6 * stage.u), theme.color("matline"))


def resting(stage: Stage, relief: Relief, mm: float, radius: float) -> float:
    """Return the row of the centre of a ball that rests on the relief; ``radius`` is in px."""
    reach = radius * np.linspace(-1.0, 1.0, 41)
    under = stage.rail - relief(mm + reach / stage.per_mm)
    return float(np.min(under - np.sqrt(radius**2 - reach**2)))


def riding(
    relief: Callable[[Stage, Values], Relief], radius: Callable[[Stage, Values], float]
) -> tuple[Callable[[Stage, Values, Motion], None], Callable[[Stage, Values, Motion], float]]:
    """Return the functions ``moving`` and ``tip`` of a scene in which the stem's ball rolls on a relief."""

    def moving(stage: Stage, values: Values, motion: Motion) -> None:
        stage.use(None, "handle")
        seen = radius(stage, values) - _OUTLINE * stage.u
        stage.p.drawEllipse(QPointF(stage.x(motion.position), tip(stage, values, motion)), seen, seen)

    def tip(stage: Stage, values: Values, motion: Motion) -> float:
        return resting(stage, relief(stage, values), motion.position, radius(stage, values))

    return moving, tip


def occupy_stem(stage: Stage, motion: Motion, low: float) -> None:
    """Reserve the area of the stem, from below the knob down to a row, so that no label is written there."""
    x, half = stage.x(motion.position), 6 * stage.u
    stage.occupied.append(QRectF(x - half, stage.top, 2 * half, low - stage.top))


def saturating(value: float, reference: float, room: float) -> float:
    """Return a height that grows with ``value`` to at most ``room``; at ``reference`` it is 0.63 ``room``."""
    return room * (1.0 - math.exp(-max(value, 0.0) / reference))

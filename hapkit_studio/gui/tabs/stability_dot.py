"""The dot of the map, its way to the boundary, and what the pointer reads."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFontMetricsF, QPainter

from hapkit_studio.analysis.margin import Margin, factor, short
from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.tabs.marks import arrow, line, marker, ring, write
from hapkit_studio.gui.tabs.stability_lines import Lines
from hapkit_studio.gui.theme import number, theme

# From this share of the width on, words stand on the left.
TURNS = 0.62
_SIDE, _DOT, _RING = 14.0, 8.0, 11.0
# Nearer than this, across and up, the pointer's words stand over the dot's.
_FAR, _CLOSE = 230.0, 40.0
# The dot's words: their font, and how far above and below they may stand; a measured point's radius.
_ROLE, _HIGHER, _CIRCLE = "strong", (0.0, -24.0, 24.0), 7.0
# Less than this between dot and boundary leaves no room for the arrow's words.
_ROOM_FOR_WORDS = 34.0


def here(margin: Margin) -> str:
    """Return the dot's words."""
    return f"you: {margin.stiffness:,.0f} N/m, {number(margin.damping, 1)} N·s/m"


@dataclass(frozen=True)
class Label:
    """Words beside the dot or its arrow, and the box they take in pixels."""

    text: str
    box: QRectF


def labels(chart: Chart, lines: Lines, circles: Sequence[QPointF] = ()) -> list[Label]:
    """Return the dot's words and its arrow's, clear of measured points and boundary where there is room."""
    margin, plane = lines.plane.margin, lines.plane
    at = chart.at(margin.damping, margin.stiffness)
    curve = chart.points(plane.damping, plane.exact)
    own, tip = _label(chart, at, here(margin), circles, curve), _tip(chart, lines)
    if tip is None or abs(tip.y() - at.y()) <= _ROOM_FOR_WORDS:
        return [own]
    other = _label(chart, (at + tip) * 0.5, factor(margin.ratio), circles, curve)
    return [own] if other.box.intersects(own.box) else [own, other]


def _label(
    chart: Chart, at: QPointF, text: str, circles: Sequence[QPointF], curve: Sequence[QPointF]
) -> Label:
    """Return words beside a point where they cover the fewest measured points, then the least of a curve."""
    metrics, frame = QFontMetricsF(theme.font(_ROLE)), chart.frame()
    width, height = metrics.horizontalAdvance(text), metrics.height()
    left = at.x() > frame.left() + TURNS * frame.width()
    tries = [
        QRectF(at.x() - _SIDE - width if side else at.x() + _SIDE, at.y() + up - 0.5 * height, width, height)
        for up in _HIGHER
        for side in (left, not left)
    ]
    inside = [box for box in tries if frame.contains(box)] or tries[:1]
    return Label(text, min(inside, key=lambda box: (_covered(box, circles), _covered(box, curve) > 0)))


def _covered(box: QRectF, points: Sequence[QPointF]) -> int:
    wide = box.adjusted(-_CIRCLE, -_CIRCLE, _CIRCLE, _CIRCLE)
    return sum(wide.contains(point) for point in points)


def _tip(chart: Chart, lines: Lines) -> QPointF | None:
    """Return where the arrow ends; None where there is none."""
    margin = lines.plane.margin
    if not (margin.stiffness > 0.0 and margin.limit > 0.0):
        return None
    at = chart.at(margin.damping, margin.stiffness)
    tip = chart.at(margin.damping, min(margin.limit, 0.98 * lines.plane.top))
    return None if abs(tip.y() - at.y()) < _RING else tip


def paint_dot(
    painter: QPainter,
    chart: Chart,
    lines: Lines,
    pointer: tuple[float, float] | None = None,
    circles: Sequence[QPointF] = (),
) -> None:
    """Paint the rendered impedance and how far it is; without words where the pointer reads others."""
    margin, plane = lines.plane.margin, lines.plane
    bad = not margin.stable and plane.setting.linear and not plane.setting.controller
    token = "danger" if bad else "accent"
    at, tip = chart.at(margin.damping, margin.stiffness), _tip(chart, lines)
    for foot in (chart.at(0.0, margin.stiffness), chart.at(margin.damping, 0.0)):
        line(painter, [foot, at], token, 1.4, [1.4, 3.0])
    if tip is not None:
        arrow(painter, at + QPointF(0.0, -_RING if tip.y() < at.y() else _RING), tip, token)
    painter.setPen(theme.color("surface"))
    painter.setBrush(theme.color("accent"))
    painter.drawEllipse(at, _DOT, _DOT)
    if bad:
        ring(painter, at, "danger", _RING)
    own, *others = labels(chart, lines, circles)
    away = chart.at(*pointer) - at if pointer else QPointF(_FAR, _FAR)
    read = abs(away.x()) <= _FAR and abs(away.y()) <= _CLOSE and math.hypot(away.x(), away.y()) >= _SIDE
    for label in others if read else (own, *others):
        place = QPointF(label.box.left(), label.box.center().y() + 5.0)
        write(painter, place, label.text, token, _ROLE, 0.0, chart.frame())


def paint_reading(
    painter: QPainter, chart: Chart, lines: Lines, pointer: tuple[float, float], dotted: bool
) -> None:
    """Say limit and margin where the pointer is, unless it is on the dot."""
    at, margin = chart.at(*pointer), lines.plane.margin
    away = at - chart.at(margin.damping, margin.stiffness)
    if dotted and math.hypot(away.x(), away.y()) < _SIDE:
        return
    box = chart.frame()
    left = at.x() > box.left() + TURNS * box.width()
    for row, text in enumerate(reading(lines, *pointer)):
        place = at + QPointF(-12.0 if left else 12.0, -22.0 + 16.0 * row)
        write(painter, place, text, "ink" if row else "ink2", "label", float(left), box)
    marker(painter, "plus", at, "ink2", 5.0)


def reading(lines: Lines, damping: float, stiffness: float) -> tuple[str, str]:
    """Return what the map says of a point: its values, and the limit with the margin there."""
    plane = lines.plane
    values = f"{stiffness:,.0f} N/m, {number(damping, 1)} N·s/m"
    limit = float(np.interp(damping, plane.damping, plane.exact))
    said = short(Margin(stiffness, damping, limit, plane.setting.hand))
    if not math.isfinite(limit) or limit <= 0.0:
        return values, said
    return values, f"limit {limit:,.0f} N/m: {said.removesuffix(' the limit')}"

"""The dot of the map, its way to the boundary, and what the pointer reads."""

import math

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter

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
# Less than this between dot and boundary leaves no room for the arrow's words.
_ROOM_FOR_WORDS = 34.0


def here(margin: Margin) -> str:
    """Return the dot's words."""
    return f"you: {number(margin.stiffness, 0)} N/m, {number(margin.damping, 1)} N·s/m"


def paint_dot(
    painter: QPainter, chart: Chart, lines: Lines, pointer: tuple[float, float] | None = None
) -> None:
    """Paint the rendered impedance and how far it is; without words where the pointer reads others."""
    margin, plane = lines.plane.margin, lines.plane
    bad = not margin.stable and plane.setting.linear
    token = "danger" if bad else "accent"
    at = chart.at(margin.damping, margin.stiffness)
    for foot in (chart.at(0.0, margin.stiffness), chart.at(margin.damping, 0.0)):
        line(painter, [foot, at], token, 1.4, [1.4, 3.0])
    if margin.stiffness > 0.0 and margin.limit > 0.0:
        _way(painter, chart, lines, token)
    painter.setPen(theme.color("surface"))
    painter.setBrush(theme.color("accent"))
    painter.drawEllipse(at, _DOT, _DOT)
    if bad:
        ring(painter, at, "danger", _RING)
    away = chart.at(*pointer) - at if pointer else QPointF(_FAR, _FAR)
    if abs(away.x()) > _FAR or abs(away.y()) > _CLOSE or math.hypot(away.x(), away.y()) < _SIDE:
        _beside(painter, chart, at + QPointF(0.0, 5.0), here(margin), token)


def _way(painter: QPainter, chart: Chart, lines: Lines, token: str) -> None:
    """Paint the arrow to the boundary and its factor."""
    margin = lines.plane.margin
    at = chart.at(margin.damping, margin.stiffness)
    tip = chart.at(margin.damping, min(margin.limit, 0.98 * lines.plane.top))
    if abs(tip.y() - at.y()) < _RING:
        return
    arrow(painter, at + QPointF(0.0, -_RING if tip.y() < at.y() else _RING), tip, token)
    if abs(tip.y() - at.y()) > _ROOM_FOR_WORDS:
        _beside(painter, chart, (at + tip) * 0.5 + QPointF(0.0, 5.0), factor(margin.ratio), token)


def _beside(painter: QPainter, chart: Chart, at: QPointF, words: str, token: str) -> None:
    box = chart.frame()
    left = at.x() > box.left() + TURNS * box.width()
    write(painter, at + QPointF(-_SIDE if left else _SIDE, 0.0), words, token, "strong", float(left), box)


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
    values = f"{number(stiffness, 0)} N/m, {number(damping, 1)} N·s/m"
    limit = float(np.interp(damping, plane.damping, plane.exact))
    said = short(Margin(stiffness, damping, limit, plane.setting.hand))
    if not math.isfinite(limit) or limit <= 0.0:
        return values, said
    return values, f"limit {number(limit, 0)} N/m: {said.removesuffix(' the limit')}"

"""The names of the map's regions, inside them and clear of everything else."""

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFontMetricsF, QPainter

from hapkit_studio.charts.placing import Box, crosses, room
from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.tabs.marks import line, write
from hapkit_studio.gui.tabs.stability_dot import labels
from hapkit_studio.gui.tabs.stability_lines import Lines
from hapkit_studio.gui.tabs.stability_measure import Measured
from hapkit_studio.gui.theme import theme

_PASSIVE = "passive: stable in any hand"
_FONT = "banner"
# Even places across; half of a measured point and some room, in pixels.
_COLUMNS, _CIRCLE = 121, 9.0


def paint_names(
    painter: QPainter, chart: Chart, lines: Lines, dotted: bool, circles: Sequence[QPointF] = ()
) -> None:
    """Name the regions where there is room, clear of the dot, all words and measured points."""
    plane, dot = lines.plane, _around_dot(chart, lines, circles) if dotted else []
    taken = _taken(chart, lines, dot, circles)
    exact = np.clip(plane.exact / plane.top, 0.0, 1.0)
    hand = "without controller" if plane.setting.controller else _hand(lines)
    taken += _name_hands(painter, chart, lines)
    if plane.edge.any():
        _name_passive(painter, chart, lines, taken, dot)
    passive = np.minimum(_passive(lines), exact)
    _name(painter, chart, f"grows, {hand}", "danger", (exact, np.ones_like(exact)), taken)
    _name(painter, chart, f"stable, {hand}", "ok", (passive, exact), taken)


def paint_measured_names(
    painter: QPainter,
    chart: Chart,
    lines: Lines,
    measured: Measured,
    dotted: bool,
    circles: Sequence[QPointF] = (),
) -> None:
    """Name what was measured, where the handle comes to rest, buzzes, grows; and what was not."""
    dot = _around_dot(chart, lines, circles) if dotted else []
    taken, hand = _taken(chart, lines, dot, circles), _hand(lines)
    taken += _name_hands(painter, chart, lines)
    zero, rests, grows, end = borders(measured, lines.plane.width, lines.plane.top)
    _name(painter, chart, f"comes to rest, {hand}", "ok", (zero, rests), taken)
    _name(painter, chart, "buzzes, does not grow", "warn", (rests, grows), taken)
    _name(painter, chart, f"grows, {hand}", "danger", (grows, end), taken)
    _name(painter, chart, "not measured", "ink2", (end, np.ones_like(end)), taken)


def borders(
    measured: Measured, width: float, top: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return 0 and the heights (n,) where it buzzes, where it grows, where nothing is measured any more.

    They are shares of a chart of this width in N·s/m and top in N/m, at even places across.
    """
    across = np.linspace(0.0, width, _COLUMNS)
    inside = across <= measured.axes[0]
    count = measured.cells.classes.shape[1]
    column = np.minimum((across / measured.axes[0] * count).astype(int), count - 1)
    high = measured.axes[1] / top
    kinds = (_lowest(measured, kind)[column] * high for kind in (1, 2))
    rests, grows, end = (np.where(inside, np.minimum(h, 1.0), 0.0) for h in (*kinds, np.full(_COLUMNS, high)))
    return np.zeros(_COLUMNS), rests, grows, end


def _lowest(measured: Measured, kind: int) -> np.ndarray:
    """Return where, as a share of the measured height, each column first does that or worse; 1 if nowhere."""
    there = measured.cells.classes >= kind
    return np.where(there.any(axis=0), there.argmax(axis=0) / len(there), 1.0)


def _hand(lines: Lines) -> str:
    hand = lines.plane.setting.hand
    return hand if hand == "released" else f"{hand} grip"


def _taken(chart: Chart, lines: Lines, dot: list[Box], circles: Sequence[QPointF]) -> list[Box]:
    """Return the shares of the frame that the simple rule, the dot and the measured points take."""
    plane, frame, size = lines.plane, chart.frame(), QPointF(_CIRCLE, _CIRCLE)
    points = [_share(QRectF(circle - size, circle + size), frame) for circle in circles]
    return [*_along(plane.damping / plane.width, plane.simple / plane.top), *dot, *points]


def _size(chart: Chart, words: str) -> tuple[float, float]:
    """Return the room that words take as shares of the frame."""
    metrics, box = QFontMetricsF(theme.font(_FONT)), chart.frame()
    return (metrics.horizontalAdvance(words) + 12) / box.width(), (metrics.height() + 6) / box.height()


def _name(
    painter: QPainter,
    chart: Chart,
    words: str,
    token: str,
    between: tuple[np.ndarray, np.ndarray],
    taken: list[Box],
) -> None:
    found = room(*between, _size(chart, words), taken)
    if found is None:
        return
    taken.append(found)
    box = chart.frame()
    middle = box.left() + 0.5 * (found[0] + found[2]) * box.width()
    base = box.bottom() - 0.5 * (found[1] + found[3]) * box.height() + 5
    write(painter, QPointF(middle, base), words, token, _FONT, 0.5)


def _name_hands(painter: QPainter, chart: Chart, lines: Lines) -> list[Box]:
    """Name the other hands' boundaries where they leave the map; return the room that takes."""
    box, plane, taken = chart.frame(), lines.plane, []
    for hand, limits in lines.hands.items():
        inside = np.flatnonzero(limits <= 0.96 * plane.top)
        if hand != plane.setting.hand and inside.size:
            last = chart.at(plane.damping[inside[-1]], limits[inside[-1]])
            drawn = write(painter, last + QPointF(-6, -8), f"{hand} grip", "ink2", "label", 1.0, box)
            taken.append(_share(drawn, box))
    return taken


def _name_passive(painter: QPainter, chart: Chart, lines: Lines, taken: list[Box], dot: list[Box]) -> None:
    """Name the passive region from beside it, with a line that leads into it."""
    plane = lines.plane
    floor = _passive(lines)
    inside = np.zeros_like(floor), np.minimum(floor, 1.0)
    if room(*inside, _size(chart, _PASSIVE), taken):
        _name(painter, chart, _PASSIVE, "velocity", inside, taken)
        return
    exact = np.clip(plane.exact / plane.top, 0.0, 1.0)
    found = room(floor, np.minimum(exact, floor + 0.3), _size(chart, _PASSIVE), taken)
    into = 0.35 * min(plane.edge_damping[-1] / plane.width, 1.0), 0.35 * min(plane.edge[0] / plane.top, 1.0)
    if found is None:
        return
    if any(crosses((found[0], 0.5 * (found[1] + found[3])), into, box) for box in dot):
        return
    taken.append(found)
    box = chart.frame()
    left = box.left() + found[0] * box.width() + 6
    base = box.bottom() - 0.5 * (found[1] + found[3]) * box.height()
    end = chart.at(into[0] * plane.width, into[1] * plane.top)
    line(painter, [QPointF(left - 4, base), end], "velocity", 1.2)
    write(painter, QPointF(left, base + 5), _PASSIVE, "velocity", _FONT)


def _passive(lines: Lines) -> np.ndarray:
    """Return the passivity line as a share of the height in each column (n,)."""
    plane = lines.plane
    if not plane.edge.size:
        return np.zeros_like(plane.damping)
    return np.interp(plane.damping, plane.edge_damping, plane.edge / plane.top, right=0.0)


def _along(x: np.ndarray, y: np.ndarray) -> list[Box]:
    """Return small boxes along a line, in shares of the frame."""
    places = np.linspace(0.0, 1.0, 4 * len(x))
    heights = np.interp(places, x, y)
    return [(a - 0.01, b - 0.02, a + 0.01, b + 0.02) for a, b in zip(places, heights, strict=True) if b < 1]


def _around_dot(chart: Chart, lines: Lines, circles: Sequence[QPointF]) -> list[Box]:
    """Return the shares of the frame that dot, arrow and their words take."""
    margin, plane = lines.plane.margin, lines.plane
    x, y = margin.damping / plane.width, margin.stiffness / plane.top
    tip = min((margin.limit if math.isfinite(margin.limit) else margin.stiffness) / plane.top, 1.0)
    words = [
        _share(label.box.adjusted(-8, -4, 8, 4), chart.frame()) for label in labels(chart, lines, circles)
    ]
    return [(x - 0.03, min(y, tip) - 0.05, x + 0.03, max(y, tip) + 0.05), *words]


def _share(drawn: QRectF, box: QRectF) -> Box:
    """Return a rectangle of pixels as a share of the frame."""
    left, right = ((x - box.left()) / box.width() for x in (drawn.left(), drawn.right()))
    bottom, top = ((box.bottom() - y) / box.height() for y in (drawn.bottom(), drawn.top()))
    return left, bottom, right, top

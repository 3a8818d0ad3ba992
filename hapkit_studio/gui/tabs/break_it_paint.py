"""Paints a failure's chart: regions, lines, limits, and where the knob stands."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainter

from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.tabs.break_it_lines import Look, looks
from hapkit_studio.gui.tabs.break_it_names import Names
from hapkit_studio.gui.tabs.break_it_record import CHART, Record
from hapkit_studio.gui.tabs.chart import Chart

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures import Chart as Found
    from hapkit_studio.analysis.failures import Evidence

_PALE = 0.35
_LINE, _ROWS = 16.0, 6
_STRIDE, _PIECES = 6.0, 40  # px between the places that are looked at along a line
_DOT = 30  # points that the dot of the knob stands for, where names are placed
_BIG, _SMALL, _MANY = 3.8, 3.0, 40
_LIKELY = (1.0, 1000.0)  # the screen's unit over the knob's: itself, or thousandths


def scale_of(record: Record) -> float | None:
    """Return what turns the knob's unit into the chart's across; None where the chart runs over another."""
    chart, limit = record.chart, record.limit
    if chart is None or not chart.marks or limit is None:
        return None
    ratio = chart.marks[0].x / limit
    return next((s for s in _LIKELY if math.isclose(ratio, s, rel_tol=1e-3)), None)


def along(points: list[QPointF]) -> list[QPointF]:
    """Return places all along a line through pixels, so that what lies on a long stroke counts too."""
    found = points[:1]
    for start, end in pairwise(points):
        way = end - start
        pieces = max(1, min(_PIECES, round(math.hypot(way.x(), way.y()) / _STRIDE)))
        found += [start + way * (k / pieces) for k in range(1, pieces + 1)]
    return found


class CurvePainter:
    """Layers of one record's chart; without a scale the chart runs over something else than the knob."""

    def __init__(self, record: Record, found: "Found"):
        self._record, self._found = record, found
        self.scale = scale_of(record)

    def under(self, painter: QPainter, chart: Chart) -> None:
        """Tint where it holds and hatch where it fails."""
        if self.scale is None:
            return
        self._fade(painter)
        left, right = QRectF(chart.frame()), QRectF(chart.frame())
        edge = chart.at(self._found.marks[0].x, 1.0).x()
        left.setRight(edge)
        right.setLeft(edge)
        for area, token, hatch in ((left, "stable", ""), (right, "unstable", "danger")):
            if area.width() > 0.0:
                corners = [area.topLeft(), area.topRight(), area.bottomRight(), area.bottomLeft()]
                marks.region(painter, corners, token, hatch)

    def over(self, painter: QPainter, chart: Chart) -> None:
        """Draw level, limits, lines, points and the knob."""
        self._fade(painter)
        self._level(painter, chart)
        self._limits(painter, chart)
        pairs = zip(self._found.lines, looks(self._found.lines), strict=True)
        for line, look in sorted(pairs, key=lambda pair: bool(pair[1].marker)):
            self._line(painter, chart.points(line.x, line.y), look)
        self._names(painter, chart)
        self._knob(painter, chart)

    def _fade(self, painter: QPainter) -> None:
        painter.setOpacity(_PALE if CHART in self._record.old else 1.0)

    def _level(self, painter: QPainter, chart: Chart) -> None:
        if self._found.level is not None:
            (low, high), _ = chart.shown()
            ends = [chart.at(low, self._found.level), chart.at(high, self._found.level)]
            marks.line(painter, ends, "ink3", 1.2)

    def _limits(self, painter: QPainter, chart: Chart) -> None:
        box = chart.frame()
        for number, place in enumerate(self._found.marks):
            x = chart.at(place.x, 1.0).x()
            ends = [QPointF(x, box.top()), QPointF(x, box.bottom())]
            main = number == 0
            marks.line(
                painter, ends, "ink" if main else "ink3", 2.4 if main else 1.4, None if main else marks.DOT
            )

    @staticmethod
    def _line(painter: QPainter, points: list[QPointF], look: Look) -> None:
        if look.marker:
            for point in points:
                size = _BIG if len(points) < _MANY else _SMALL
                marks.marker(painter, look.marker, point, look.token, size, False)
        elif len(points) > 1:
            marks.line(painter, points, look.token, look.width, look.dash)

    def _names(self, painter: QPainter, chart: Chart) -> None:
        """Name the limits where they hide least."""
        box = chart.frame()
        (low, high), _ = chart.shown()
        shown = [mark for mark in self._found.marks if low <= mark.x <= high]
        points = [p for line in self._found.lines for p in along(chart.points(line.x, line.y))]
        taken = [chart.at(mark.x, 1.0).x() for mark in shown]
        if self.scale is not None and self._record.value is not None:
            taken.append(chart.at(self._record.value * self.scale, 1.0).x())
        points += _DOT * [dot] if (dot := self._dot(chart)) is not None else []
        writer = Names(painter, box, points, taken)
        for row, place in enumerate(shown):
            x, token = chart.at(place.x, 1.0).x(), "ink" if place is self._found.marks[0] else "ink2"
            levels = [box.top() + _LINE * (row + 1 + lower) for lower in range(_ROWS)]
            spots = [(x + side, y, float(side < 0)) for y in levels for side in (7, -7)]
            writer.write(place.label.replace("_", ""), token, "label", spots)

    def _knob(self, painter: QPainter, chart: Chart) -> None:
        """Draw where the knob stands, and what it showed there."""
        value, box = self._record.value, chart.frame()
        if self.scale is None or value is None:
            return
        x = value * self.scale
        at = chart.at(x, 1.0).x()
        marks.line(painter, [QPointF(at, box.top()), QPointF(at, box.bottom())], "accent", 1.6, marks.DASH)
        marks.marker(painter, "up", QPointF(at, box.bottom() - 6), "accent", 6.0)
        dot = self._dot(chart)
        if dot is not None:
            marks.marker(painter, "circle", dot, "accent", 6.5)

    def _dot(self, chart: Chart) -> QPointF | None:
        """Return where the knob's present value was found, if the chart runs up over that."""
        here = self._record.here
        if here is None or self.scale is None or not self._measures(here.evidence):
            return None
        return chart.at(here.value * self.scale, here.evidence.measure)

    def _measures(self, found: "Evidence") -> bool:
        """Say whether the chart runs up over what a try is judged by."""
        same = self._found.y_label.endswith(f", {found.measure_unit}")
        return same and math.isfinite(found.measure)

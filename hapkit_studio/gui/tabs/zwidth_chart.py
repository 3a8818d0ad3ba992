"""Stiffness over damping: what was rendered, point by point as it comes, and the linear loop's limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Signal
from PySide6.QtGui import QPainter

from hapkit_studio.analysis.scales import nice_top
from hapkit_studio.analysis.zwidth_limits import HIGHEST
from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.tabs.fresh import PALE
from hapkit_studio.gui.tabs.marks import DASH, line, marker, region, ring, write

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth_result import ZWidth

_NEAR = 18.0  # px
_ROOM = 1.18
_NAME_ROOM = 50.0  # px
# What the axes show before anything is known, N·s/m and N/m.
_RIGHT, _LEAST = 10.0, 1000.0


@dataclass(frozen=True)
class Spot:
    """One point: damping N·s/m, stiffness N/m, whether the motor's limit was reached."""

    damping: float
    stiffness: float
    clamped: bool


class ZWidthChart(Chart):
    """Emits ``pointed(index or None)`` for the point of the result under the pointer."""

    pointed = Signal(object)

    def __init__(self) -> None:
        super().__init__("virtual damping B, N·s/m", "virtual stiffness K, N/m")
        self._spots: list[Spot] = []
        self._curve = np.empty((2, 0))
        self._pale = self._done = self._open = False
        self._right = _RIGHT
        self.under += [self._below]
        self._trial: tuple[float, float] | None = None
        self.over += [self._linear, self._rendered, self._names, self._tried]
        self.hovered.connect(self._hover)
        self._fit(_RIGHT, _LEAST)

    def show_result(self, result: "ZWidth") -> None:
        """Show what was found."""
        points = zip(result.damping, result.stiffness, result.clamped, strict=True)
        self._spots = [Spot(float(b), float(k), clamped) for b, k, clamped in points]
        self._curve, self._pale, self._done = result.curve, False, True
        self._open = HIGHEST in result.ends
        self._fit(float(result.damping[-1]), 0.0)

    def show_nothing(self) -> None:
        """Show nothing: here nothing was measured yet."""
        self._spots, self._curve = [], np.empty((2, 0))
        self._pale = self._done = False
        self._fit(_RIGHT, _LEAST)

    def outdate(self, on: bool) -> None:
        """Pale what is there while it is out of date."""
        self._pale = on
        self.redraw()

    def begin(self, highest: float) -> None:
        """Pale what is there; the first point, of a damping up to the highest, takes its place."""
        self._pale, self._done, self._right = bool(self._spots), False, highest
        if not self._pale:
            self._fit(highest, _LEAST)
        self.redraw()

    def add(self, spot: Spot) -> None:
        """Show one more point of the measurement under way."""
        if self._pale or self._curve.size:
            self._spots, self._curve, self._pale = [], np.empty((2, 0)), False
        self._spots.append(spot)
        self._fit(self._right, _LEAST)

    def show_trial(self, damping: float, stiffness: float) -> None:
        """Ring the wall that is being tried."""
        now = damping, stiffness
        if now == self._trial:
            return
        self._trial = now
        if stiffness > self.shown()[1][1]:
            self._fit(self._right, stiffness)
        self.redraw()

    def settle(self) -> None:
        """Show what is there as it is; the measurement is over."""
        self._pale, self._trial = False, None
        self._done = bool(self._curve.size)
        self.redraw()

    def nearest(self, place: QPointF) -> int | None:
        """Return the index of the point near a pixel."""
        away = [self.at(s.damping, s.stiffness) - place for s in self._spots]
        near = [(abs(d.x()) + abs(d.y()), index) for index, d in enumerate(away)]
        distance, index = min(near, default=(_NEAR + 1.0, 0))
        return index if distance <= _NEAR else None

    def _fit(self, right: float, least: float) -> None:
        limits = self._curve[1][np.isfinite(self._curve[1])]
        high = max([least, *limits.tolist(), *(s.stiffness for s in self._spots)], default=0.0)
        self.set_range((-0.02 * (right or 1.0), 1.04 * (right or 1.0)), (0.0, nice_top(_ROOM * high)))

    # layers

    def _line(self) -> list[QPointF]:
        return [self.at(s.damping, s.stiffness) for s in self._spots]

    def _below(self, painter: QPainter, _chart: Chart) -> None:
        points = self._line()
        if len(points) < 2:
            return
        painter.setOpacity(PALE if self._pale else 1.0)
        floor = self.frame().bottom()
        region(painter, [*points, QPointF(points[-1].x(), floor), QPointF(points[0].x(), floor)], "stable")

    def _linear(self, painter: QPainter, _chart: Chart) -> None:
        points = self.points(*self._curve) if self._curve.size else []
        if len(points) > 1:
            line(painter, points, "ink", 2.0, DASH, PALE if self._pale else 1.0)

    def _rendered(self, painter: QPainter, _chart: Chart) -> None:
        painter.setOpacity(PALE if self._pale else 1.0)
        if len(self._spots) > 1:
            line(painter, self._line(), "position", 2.4)
        for spot, place in zip(self._spots, self._line(), strict=True):
            marker(painter, "circle", place, "position", 6.0, filled=not spot.clamped)

    def _names(self, painter: QPainter, _chart: Chart) -> None:
        if not self._done or len(self._spots) < 2:
            return
        painter.setOpacity(PALE if self._pale else 1.0)
        box, points = self.frame(), self._line()
        self._name_rendered(painter, box, points)
        limits = self.points(*self._curve)
        if len(limits) > 1:
            place = limits[round(0.72 * (len(limits) - 1))]
            write(painter, place + QPointF(0.0, 22.0), "linear loop", "ink", anchor=0.0, inside=box)

    def _name_rendered(self, painter: QPainter, box: QRectF, points: Sequence[QPointF]) -> None:
        last, before = points[-1], points[-2]
        middle = (last + before) / 2.0
        above = QPointF(middle.x() - 10.0, middle.y() - 14.0)
        write(painter, above, "rendered without buzzing", "position", anchor=1.0, inside=box)
        left = (points[0] + points[1]) / 2.0
        if not self._open and min(p.y() for p in points) - box.top() > _NAME_ROOM:
            write(painter, QPointF(left.x() + 24.0, box.top() + 26.0), "buzzes", "danger", inside=box)

    def _tried(self, painter: QPainter, _chart: Chart) -> None:
        if self._trial is not None:
            ring(painter, self.at(*self._trial), "accent", 7.0)

    def _hover(self, place: tuple[float, float] | None) -> None:
        self.pointed.emit(None if place is None else self.nearest(self.at(*place)))

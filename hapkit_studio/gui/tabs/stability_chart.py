"""The map itself: regions, boundaries, measured cells and points, the dot, and what the pointer reads."""

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainter

from hapkit_studio.gui.tabs.chart import Chart, Layer
from hapkit_studio.gui.tabs.marks import DASH_DOT, DOT, line, marker, region
from hapkit_studio.gui.tabs.stability_cells import paint_cells
from hapkit_studio.gui.tabs.stability_dot import paint_dot, paint_reading
from hapkit_studio.gui.tabs.stability_lines import Lines
from hapkit_studio.gui.tabs.stability_measure import Measured
from hapkit_studio.gui.tabs.stability_names import paint_measured_names, paint_names

_PALE = 0.4
# The axes before anything is known.
_EMPTY = (12.0, 2000.0)


class StabilityChart(Chart):
    """Damping across, stiffness up; paints what it was shown last."""

    def __init__(self) -> None:
        super().__init__("damping B, N·s/m", "stiffness K, N/m")
        self.lines: Lines | None = None
        self.dotted = False
        self.measured: list[Measured] = []
        self.pale = self.faded = False
        self._pointer: tuple[float, float] | None = None
        self.under += [self._regions, self._cells, self._passive]
        self.over += [self._curves, self._names]
        self.marks += [self._points, self._dot, self._read]
        self.hovered.connect(self._point)
        self.set_range((0.0, _EMPTY[0]), (0.0, _EMPTY[1]))

    def show_lines(self, lines: Lines | None, dotted: bool) -> None:
        """Show other lines; dotted: the rendered impedance is one that can be shown."""
        self.lines, self.dotted, self.faded = lines, dotted, False
        if lines is not None:
            self.set_range((0.0, lines.plane.width), (0.0, lines.plane.top))
        self.redraw()

    def fade(self) -> None:
        """Keep what is shown, paler: it holds no more."""
        self.dotted, self.faded = False, True
        self.redraw()

    def show_measured(self, measured: Sequence[Measured], pale: bool) -> None:
        """Show what was measured, the newest last; paler where other conditions hold now."""
        self.measured, self.pale = list(measured), pale
        self.redraw()

    def _paint(self, painter: QPainter, layers: list[Layer]) -> None:
        painter.setOpacity(_PALE if self.faded else 1.0)
        super()._paint(painter, layers)
        painter.setOpacity(1.0)

    # layers

    def _regions(self, painter: QPainter, chart: Chart) -> None:
        lines = self.lines
        if lines is None or not lines.plane.setting.linear or self.particular is not None:
            return
        box = self.frame()
        region(painter, _corners(box), "unstable", "danger")
        curve = self.points(lines.plane.damping, np.minimum(lines.plane.exact, 10.0 * lines.plane.top))
        region(painter, [*curve, box.bottomRight(), box.bottomLeft()], "stable")

    def _cells(self, painter: QPainter, chart: Chart) -> None:
        if self.measured and self.lines is not None:
            self._pale(painter)
            paint_cells(painter, self, self.measured[-1])

    def _passive(self, painter: QPainter, chart: Chart) -> None:
        if self.lines is not None and self.lines.plane.edge.any():
            edge = self.points(self.lines.plane.edge_damping, self.lines.plane.edge)
            region(painter, [self.at(0.0, 0.0), *edge], "passive")

    def _curves(self, painter: QPainter, chart: Chart) -> None:
        if self.lines is None:
            return
        plane = self.lines.plane
        line(painter, self.points(plane.damping, plane.simple), "asked", 2.0, DOT)
        for hand, limits in self.lines.hands.items():
            if hand != plane.setting.hand:
                line(painter, self.points(plane.damping, limits), "ink2", 1.6)
        if plane.setting.linear:
            line(painter, self.points(plane.damping, plane.exact), "ink", 3.0)
        if plane.edge.any():
            line(painter, self.points(plane.edge_damping, plane.edge), "velocity", 2.0, DASH_DOT)
        if plane.coulomb < plane.top:
            line(painter, self.points([0.0, plane.width], [plane.coulomb] * 2), "warn", 2.0, [6.0, 3.0])

    def _points(self, painter: QPainter, chart: Chart) -> None:
        """Paint the measured boundary; points on the frame stand over it, whole."""
        seen = self.frame().adjusted(-1.0, -1.0, 1.0, 1.0)
        self._pale(painter)
        for measured in self.measured if self.lines is not None else ():
            token = "applied" if measured.points.controller else "position"
            for place in self.points(measured.points.damping, measured.points.stiffness):
                if seen.contains(place):
                    marker(painter, "circle", place, token, 6.0, filled=False)

    @property
    def particular(self) -> Measured | None:
        """Return a measurement that the lines cannot stand for: with friction, or with the controller."""
        newest = self.measured[-1] if self.measured and not self.pale else None
        return newest if newest is not None and (newest.real or newest.cells.controller) else None

    def circles(self) -> list[QPointF]:
        """Return where measured points are, in pixels."""
        pairs = [(measured.points.damping, measured.points.stiffness) for measured in self.measured]
        return [place for pair in pairs for place in self.points(*pair)]

    def _names(self, painter: QPainter, chart: Chart) -> None:
        if self.lines is None:
            return
        if self.particular is not None:
            paint_measured_names(painter, self, self.lines, self.particular, self.dotted, self.circles())
        elif self.lines.plane.setting.linear:
            paint_names(painter, self, self.lines, self.dotted, self.circles())

    def _dot(self, painter: QPainter, chart: Chart) -> None:
        if self.lines is not None and self.dotted:
            paint_dot(painter, self, self.lines, self._pointer, self.circles())

    def _pale(self, painter: QPainter) -> None:
        """Paint what follows paler, if it holds for other conditions."""
        painter.setOpacity(painter.opacity() * (_PALE if self.pale else 1.0))

    def _point(self, place: tuple[float, float] | None) -> None:
        self._pointer = place
        self.redraw()

    def _read(self, painter: QPainter, chart: Chart) -> None:
        if self.lines is not None and self._pointer is not None and not self.faded:
            paint_reading(painter, self, self.lines, self._pointer, self.dotted)


def _corners(box: QRectF) -> list[QPointF]:
    return [box.topLeft(), box.topRight(), box.bottomRight(), box.bottomLeft()]

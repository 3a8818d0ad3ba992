"""Force over what it belongs to, with the line that was found; what is left over, in time."""

from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter, QPolygonF
from PySide6.QtWidgets import QSizePolicy

from hapkit_studio.charts.identify import AXES
from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.tabs.fresh import PALE
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Part, Points

_MOST_POINTS = 1200
_MARGIN = 0.08
_STEPS = 40


def _room(values: np.ndarray) -> tuple[float, float]:
    """Return a range with some room about the values."""
    low, high = float(values.min()), float(values.max())
    room = _MARGIN * (high - low) or 1e-3
    return low - room, high + room


def _dots(painter: QPainter, points: list[QPointF], size: float = 3.0) -> None:
    pen = painter.pen()
    pen.setColor(theme.color("applied"))
    pen.setWidthF(size)
    painter.setPen(pen)
    painter.drawPoints(QPolygonF(points))


class Paling(Chart):
    """A chart that can be out of date."""

    strength = 1.0

    def outdate(self, on: bool) -> None:
        """Draw data paler while they are out of date."""
        self.strength = PALE if on else 1.0
        self.redraw()


class TermChart(Paling):
    """One term: the force that is left without all others, the line found, its band, what was set."""

    def __init__(self) -> None:
        super().__init__("", "its own force, N")
        self._points: tuple[np.ndarray, np.ndarray] | None = None
        self._line: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self._asked: float | None = None
        self._offset = False
        self.under += [self._band]
        self.over += [self._fit, self._dots]

    def show_term(self, part: "Part", name: str) -> None:
        """Show one term of a part that has points."""
        points, estimate = part.points, part[name]
        assert points is not None
        label, scale = AXES[name]
        own, force = points.share(name)
        sign = -1.0 if part.key == "rendered" else 1.0
        across = np.linspace(*_room(own), _STEPS)
        fit, half = points.line(name, across)
        self._points = scale * own, sign * force
        self._line = scale * across, sign * fit, half
        self._offset = name == "stiffness"
        self._asked = None if estimate.asked is None else sign * estimate.asked / scale
        self.set_titles(label, "its own force, N")
        self.set_range(_room(scale * own), _room(np.concatenate([sign * force, [0.0]])))

    def _band(self, painter: QPainter, chart: Chart) -> None:
        if self._line is None:
            return
        painter.setOpacity(self.strength)
        across, fit, half = self._line
        edges = [*self.points(across, fit + half), *reversed(self.points(across, fit - half))]
        marks.region(painter, edges, "theory")
        marks.line(painter, [*edges, edges[0]], "edge", 1.0)

    def _dots(self, painter: QPainter, chart: Chart) -> None:
        if self._points is None:
            return
        painter.setOpacity(self.strength)
        every = max(len(self._points[0]) // _MOST_POINTS, 1)
        _dots(painter, self.points(*(column[::every] for column in self._points)))

    def _fit(self, painter: QPainter, chart: Chart) -> None:
        if self._line is None:
            return
        painter.setOpacity(self.strength)
        across, fit, _ = self._line
        marks.line(painter, self.points(across, fit), "ink", 2.0)
        if self._asked is not None:
            middle = 0.5 * (across[0] + across[-1])
            through = float(np.interp(middle, across, fit)) - self._asked * middle if self._offset else 0.0
            marks.line(painter, self.points(across, through + self._asked * across), "hold", 2.0, marks.DOT)


class LeftOver(Paling):
    """What no term explains, over the time before now."""

    def __init__(self) -> None:
        super().__init__("time, s (what no term explains)", "mN")
        self._points: tuple[np.ndarray, np.ndarray] | None = None
        self.setMinimumSize(260, 96)
        self.setMaximumHeight(112)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self.over += [self._draw]

    def show_points(self, points: "Points", end: float) -> None:
        """Show what is left of a part; end is the piece's end in its own time."""
        self._points = points.time - end, 1e3 * points.residual
        most = max(float(np.abs(self._points[1]).max()), 0.1) * (1.0 + _MARGIN)
        self.set_range((float(self._points[0].min()) - 0.05, 0.0), (-most, most))

    def _draw(self, painter: QPainter, chart: Chart) -> None:
        if self._points is None:
            return
        painter.setOpacity(self.strength)
        box = self.frame()
        zero = self.at(0.0, 0.0).y()
        marks.line(painter, [QPointF(box.left(), zero), QPointF(box.right(), zero)], "ink2", 1.0)
        every = max(len(self._points[0]) // _MOST_POINTS, 1)
        _dots(painter, self.points(*(column[::every] for column in self._points)), 2.5)

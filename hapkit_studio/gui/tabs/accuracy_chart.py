"""One scene's points: error over cost, both in powers of ten, front and tolerance beneath."""

import itertools
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Signal
from PySide6.QtGui import QFontMetricsF, QPainter

from hapkit_studio.charts.methods import look
from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.tabs.chart import Chart
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Point, Sheet

_LEAST, _MOST = 1e-16, 1e6
_ROOM = 2.2  # how far the axes go beyond the points, as a factor
_NEAR, _EDGE = 14.0, 9.0  # px
_NS = 1e-3  # µs


def micro(point: "Point") -> float:
    """Return a point's cost in µs per simulated second."""
    return _NS * point.ns_per_simulated_s


def height(error: float) -> float:
    """Return where an error is drawn: what is too small or too large for the axis at its edge."""
    return min(max(error, _LEAST), _MOST) if math.isfinite(error) else _MOST


class AccuracyChart(Chart):
    """Emits ``pointed(Point or None)`` for the point under the pointer; one method may stand out."""

    pointed_at = Signal(object)

    def __init__(self) -> None:
        super().__init__(
            "computing time per simulated second (less is faster)", "error", log=(True, True), unit="µs"
        )
        self._sheet: Sheet | None = None
        self._method = ""
        self.under += [self._tolerance, self._front]
        self.over += [self._lines, self._points]
        self.marks += [self._names]
        self.hovered.connect(self._hover)

    def show_sheet(self, sheet: "Sheet | None") -> None:
        """Show another scene's points."""
        self._sheet, self._method = sheet, ""
        if sheet is None:
            self.set_titles(self.across, "error (less is better)")
            return
        costs = [micro(p) for p in sheet.points]
        errors = [height(p.error) for p in sheet.points if math.isfinite(p.error)] + [sheet.scene.tolerance]
        across = min(costs) / _ROOM, max(costs) * _ROOM**2
        up = max(min(errors) / _ROOM**2, _LEAST / 3.0), max(errors) * _ROOM**2
        self.set_range(across, up)
        unit = f", {sheet.scene.unit}" if sheet.scene.unit else ""
        self.set_titles(self.across, f"{sheet.scene.error}{unit} (less is better)")

    def stand_out(self, method: str) -> None:
        """Draw one method stronger than the others, "" for none."""
        self._method = method
        self.redraw()

    def spot(self, point: "Point") -> QPointF:
        """Return where a point is drawn: one whose error is lost in growth, at the upper edge."""
        place, top = self.at(micro(point), height(point.error)), self.frame().top()
        return QPointF(place.x(), max(place.y(), top + _EDGE))

    # layers

    def _tolerance(self, painter: QPainter, chart: Chart) -> None:
        if self._sheet is None:
            return
        box = self.frame()
        y = self.at(1.0, self._sheet.scene.tolerance).y()
        painter.fillRect(QRectF(box.left(), y, box.width(), box.bottom() - y), theme.color("stable", 0.45))

    def _front(self, painter: QPainter, chart: Chart) -> None:
        """Draw the edge beyond which nothing lies, as a band with kerbs: a staircase in cost and error."""
        front = self._sheet.front if self._sheet else ()
        if not front:
            return
        box = self.frame()
        places = [self.spot(p) for p in front]
        path = [QPointF(places[0].x(), box.top())]
        for before, here in itertools.pairwise(places):
            path += [before, QPointF(here.x(), before.y())]
        path += [places[-1], QPointF(box.right(), places[-1].y())]
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            marks.line(painter, path, token, width)

    def _lines(self, painter: QPainter, chart: Chart) -> None:
        if self._sheet is None:
            return
        box, scene = self.frame(), self._sheet.scene
        y = self.at(1.0, scene.tolerance).y()
        marks.line(painter, [QPointF(box.left(), y), QPointF(box.right(), y)], "danger", 2.0, marks.DASH)
        for method in self._sheet.methods:
            points = [p for p in self._sheet.line(method.key) if math.isfinite(p.error)]
            places = [self.spot(p) for p in points]
            width = 3.0 if method.key == self._method else 1.5
            marks.line(painter, places, look(method.key)[1], width)

    def _points(self, painter: QPainter, chart: Chart) -> None:
        if self._sheet is None:
            return
        for point in self._sheet.points:
            shape, token = look(point.method)
            place = self.spot(point)
            filled = self._sheet.scene.competes(point)
            marks.marker(painter, shape, place, token, 6.5 if filled else 5.0, filled)
        default = self._sheet.answer.default
        if default is not None:
            marks.ring(painter, self.spot(default), "accent", 12.0)

    def _names(self, painter: QPainter, chart: Chart) -> None:
        if self._sheet is None:
            return
        box = self.frame()
        taken = [self._around(p) for p in self._sheet.points]
        y = self.at(1.0, self._sheet.scene.tolerance).y()
        words = f"tolerance {self._tolerance_words()}"
        right = QPointF(box.right() - 6, y - 6)
        taken.append(marks.write(painter, right, words, "danger", "label", 1.0, box))
        default = self._sheet.answer.default
        if default is not None:
            self._place(painter, default, "default", "accent", taken, box)
        for method in self._sheet.methods:
            line = [p for p in self._sheet.line(method.key) if math.isfinite(p.error)]
            if line:
                last = max(line, key=micro)
                self._place(painter, last, method.label, look(method.key)[1], taken, box)

    def _place(
        self, painter: QPainter, point: "Point", text: str, token: str, taken: list[QRectF], box: QRectF
    ) -> None:
        """Write a name beside a point, where nothing else is; where everything is full, nowhere."""
        metrics = QFontMetricsF(theme.font("label"))
        width, tall = metrics.horizontalAdvance(text), metrics.height()
        at = self.spot(point)
        for x, y in _around(at, width, tall):
            room = QRectF(x, y - metrics.ascent(), width, tall)
            if box.contains(room) and not any(room.intersects(other) for other in taken):
                taken.append(marks.write(painter, QPointF(x, y), text, token))
                return

    def _around(self, point: "Point") -> QRectF:
        place = self.spot(point)
        return QRectF(place.x() - 6, place.y() - 6, 12, 12)

    def _tolerance_words(self) -> str:
        from hapkit_studio.analysis.accuracy.words import error_words

        assert self._sheet is not None
        return error_words(self._sheet.scene.tolerance, self._sheet.scene.unit)

    # pointer

    def point_near(self, place: QPointF) -> "Point | None":
        """Return the point nearest to a pixel, within reach."""
        if self._sheet is None:
            return None

        def far(point: "Point") -> float:
            away = self.spot(point) - place
            return math.hypot(away.x(), away.y())

        nearest = min(self._sheet.points, key=far, default=None)
        return nearest if nearest is not None and far(nearest) <= _NEAR else None

    def _hover(self, value: tuple[float, float] | None) -> None:
        self.pointed_at.emit(None if value is None else self.point_near(self.at(*value)))


def _around(at: QPointF, width: float, tall: float) -> Iterable[tuple[float, float]]:
    """Return places for a name's left end and base line around a point, the best first."""
    for down in (0.35, 1.3, -0.7, 2.2, -1.6):
        yield at.x() + 11.0, at.y() + down * tall
    for down in (1.5, -0.9, 2.4, -1.8, 3.3):
        yield at.x() - 0.5 * width, at.y() + down * tall
    for down in (0.35, 1.3, -0.7, 2.2, -1.6):
        yield at.x() - width - 11.0, at.y() + down * tall

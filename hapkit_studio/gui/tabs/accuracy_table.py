"""The methods of a scene at the loop's own step: marker, name, cost, error; one may be chosen."""

import math
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.charts.methods import look
from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.theme import theme

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Point, Scene, Sheet

_ROW, _HEAD = 30, 38
_TINY, _HUGE = 1e-2, 1e5
_COST, _ERROR, _NAME = 36, 52, 20  # px


def error_head(scene: "Scene") -> str:
    """Return the head of a scene's errors with the unit that all of them are in."""
    if scene.unit == "m/s":
        return "Error\nmm/s"
    return "Of limit\n%" if scene.goal else "Error\n%"


def error_figures(error: float, scene: "Scene") -> str:
    """Write an error in the unit of the head; what is tiny or huge as a power of ten."""
    from hapkit_studio.analysis.accuracy.words import figures, power

    if not math.isfinite(error):
        return "none"
    value = (1e3 if scene.unit == "m/s" else 1e2) * error
    return figures(value) if value == 0.0 or _TINY <= value < _HUGE else power(value)


class MethodTable(QWidget):
    """Emits ``chosen(method)``; a second click on the same row chooses none."""

    chosen = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self._sheet: Sheet | None = None
        self._points: list[Point] = []
        self._method = ""
        self.setAccessibleName("Methods with cost and error")
        theme.changed.connect(self.update)

    def show_sheet(self, sheet: "Sheet | None") -> None:
        """List the points that compete, the most accurate first."""
        self._sheet, self._method = sheet, ""
        found = [p for p in sheet.points if sheet.scene.competes(p)] if sheet else []
        self._points = sorted(found, key=lambda p: p.error if math.isfinite(p.error) else math.inf)
        self.setFixedHeight(_HEAD + _ROW * len(self._points))
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._sheet is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(theme.font("hint"))
        painter.setPen(theme.color("ink3"))
        self._row(painter, 0.0, _HEAD, self._heads(), ("ink3", "ink3", "ink3"))
        for index, point in enumerate(self._points):
            self._entry(painter, _HEAD + index * _ROW, point)

    def _entry(self, painter: QPainter, top: float, point: "Point") -> None:
        assert self._sheet is not None
        scene = self._sheet.scene
        default = point is self._sheet.answer.default
        if default or point.method == self._method:
            painter.fillRect(QRectF(0, top, self.width(), _ROW), theme.color("accentsoft"))
        shape, token = look(point.method)
        marks.marker(painter, shape, QPointF(9, top + _ROW / 2), token, 6.0)
        painter.setFont(theme.font("body"))
        within = point.error <= scene.tolerance
        self._row(painter, top, _ROW, self.texts(point), ("ink", "ink", "ok" if within else "danger"))

    def _heads(self) -> tuple[str, str, str]:
        assert self._sheet is not None
        scene = self._sheet.scene
        return ("Rate" if scene.step_s is None else "Method", "µs\nper s", error_head(scene))

    def texts(self, point: "Point") -> tuple[str, str, str]:
        """Return a row's words: what is chosen between, cost, error."""
        from hapkit_studio.analysis.accuracy.words import figures, name_words

        assert self._sheet is not None
        scene = self._sheet.scene
        cost = figures(1e-3 * point.ns_per_simulated_s)
        return name_words(scene, point), cost, error_figures(point.error, scene)

    def cells(self, top: float, height: float) -> tuple[QRectF, QRectF, QRectF]:
        """Return the places of a row's words."""
        name = QRectF(_NAME, top, self.width() - _NAME - _COST - _ERROR, height)
        cost = QRectF(name.right(), top, _COST - 4, height)
        return name, cost, QRectF(cost.right() + 2, top, _ERROR, height)

    def _row(
        self,
        painter: QPainter,
        top: float,
        height: float,
        texts: tuple[str, str, str],
        tokens: tuple[str, str, str],
    ) -> None:
        left, right = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight
        middle = Qt.AlignmentFlag.AlignVCenter
        for box, text, token, side in zip(
            self.cells(top, height), texts, tokens, (left, right, right), strict=True
        ):
            painter.setPen(theme.color(token))
            if "\n" not in text:
                text = painter.fontMetrics().elidedText(
                    text, Qt.TextElideMode.ElideRight, int(box.width()) + 1
                )
            painter.drawText(box, side | middle, text)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        index = int((event.position().y() - _HEAD) // _ROW)
        if 0 <= index < len(self._points):
            method = self._points[index].method
            self._method = "" if method == self._method else method
            self.update()
            self.chosen.emit(self._method)

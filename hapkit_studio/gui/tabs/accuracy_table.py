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
    from hapkit_studio.analysis.accuracy import Point, Sheet

_ROW, _HEAD = 30, 24
_COST, _ERROR = 46, 56


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
        self._row(painter, 0.0, _HEAD, ("Method", "µs / s", "Error"), ("ink3", "ink3", "ink3"))
        for index, point in enumerate(self._points):
            self._entry(painter, _HEAD + index * _ROW, point)

    def _entry(self, painter: QPainter, top: float, point: "Point") -> None:
        from hapkit_studio.analysis.accuracy.words import error_words, figures

        assert self._sheet is not None
        scene = self._sheet.scene
        default = point is self._sheet.answer.default
        if default or point.method == self._method:
            painter.fillRect(QRectF(0, top, self.width(), _ROW), theme.color("accentsoft"))
        shape, token = look(point.method)
        marks.marker(painter, shape, QPointF(11, top + _ROW / 2), token, 6.0)
        painter.setFont(theme.font("body"))
        within = point.error <= scene.tolerance
        texts = (point.label, figures(1e-3 * point.ns_per_simulated_s), error_words(point.error, scene.unit))
        self._row(painter, top, _ROW, texts, ("ink", "ink", "ok" if within else "danger"))

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
        name = QRectF(24, top, self.width() - 24 - _COST - _ERROR, height)
        cost = QRectF(name.right(), top, _COST - 6, height)
        error = QRectF(self.width() - _ERROR - 4, top, _ERROR, height)
        for box, text, token, side in zip(
            (name, cost, error), texts, tokens, (left, right, right), strict=True
        ):
            painter.setPen(theme.color(token))
            shown = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, int(box.width()))
            painter.drawText(box, side | middle, shown)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        index = int((event.position().y() - _HEAD) // _ROW)
        if 0 <= index < len(self._points):
            method = self._points[index].method
            self._method = "" if method == self._method else method
            self.update()
            self.chosen.emit(self._method)

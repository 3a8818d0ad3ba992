"""A small map of damping and stiffness: the exact boundary, and where the rendered impedance lies."""

import math

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from hapkit_studio.gui.margin import Answer
from hapkit_studio.gui.theme import theme

_HEIGHT = 150
_LEFT, _TOP, _RIGHT, _BOTTOM = 44, 8, 8, 34


def nice_top(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 4, 5, 8 × 10ⁿ at or above a value."""
    if value <= 0.0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in (1, 1.5, 2, 3, 4, 5, 8, 10) if m * power >= value * (1 - 1e-9))


class StabilityMap(QWidget):
    """Paints one answer; the dot stays inside the frame and says so by an open ring where it is beyond."""

    def __init__(self, parent: QWidget | None = None):
        super().__init__(parent)
        self._answer: Answer | None = None
        self.setFixedHeight(_HEIGHT)
        self.setAccessibleName("Stability map, damping across, stiffness up")
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(220, _HEIGHT)

    def show_answer(self, answer: Answer) -> None:
        """Show another answer."""
        self._answer = answer
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._answer is None or len(self._answer.boundary) < 2:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(theme.font("tick"))
        frame = QRectF(_LEFT, _TOP, self.width() - _LEFT - _RIGHT, self.height() - _TOP - _BOTTOM)
        right = self._answer.question.width
        top = self._top()
        self._regions(painter, frame, right, top)
        self._axes(painter, frame, right, top)
        self._dot(painter, frame, right, top)

    def _top(self) -> float:
        """Return the stiffness at the upper edge: room above dot and limit, the whole curve if it is low."""
        assert self._answer is not None
        highest = max([k for _, k in self._answer.boundary if math.isfinite(k)], default=1.0)
        limit = self._answer.limit if math.isfinite(self._answer.limit) else 0.0
        around = max(2.2 * limit, 1.4 * self._answer.question.stiffness, 1.0)
        return nice_top(max(min(around, 1.1 * highest), 1.1 * self._answer.question.stiffness, 1.0))

    def _regions(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        curve = [_at(frame, b / right, min(k, top) / top) for b, k in self._answer.boundary]
        painter.fillRect(frame, theme.color("unstable"))
        painter.fillRect(frame, QBrush(theme.color("danger", 0.25), Qt.BrushStyle.BDiagPattern))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("stable"))
        painter.drawPolygon(QPolygonF([*curve, frame.bottomRight(), frame.bottomLeft()]))
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(QPolygonF(curve))
        painter.setFont(theme.font("label"))
        room = max(point.y() for point in curve)
        self._name(
            painter, frame, "grows", "danger", frame.top() + 4, min(p.y() for p in curve) - frame.top() > 26
        )
        self._name(painter, frame, "stable", "ok", frame.bottom() - 22, frame.bottom() - room > 6)

    def _name(self, painter: QPainter, frame: QRectF, word: str, token: str, y: float, right: bool) -> None:
        box = QRectF(frame.left() + 8, y, frame.width() - 16, 18)
        painter.setPen(theme.color(token))
        side = Qt.AlignmentFlag.AlignRight if word == "stable" else Qt.AlignmentFlag.AlignLeft
        painter.drawText(box, side | Qt.AlignmentFlag.AlignVCenter, word)

    def _axes(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        painter.setFont(theme.font("tick"))
        painter.setPen(theme.color("ink2"))
        for part in (0.0, 0.5, 1.0):
            place = _at(frame, part, part)
            x = min(place.x() - 30, self.width() - 60)
            bottom = QRectF(x, frame.bottom() + 2, 60, 16)
            flag = Qt.AlignmentFlag.AlignRight if part == 1.0 else Qt.AlignmentFlag.AlignHCenter
            painter.drawText(bottom, flag, f"{part * right:g}")
            left = QRectF(0, place.y() - 8, _LEFT - 6, 16)
            painter.drawText(
                left, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, f"{part * top:g}"
            )
        painter.setPen(theme.color("ink3"))
        below = QRectF(frame.left(), frame.bottom() + 16, frame.width(), 18)
        painter.drawText(below, Qt.AlignmentFlag.AlignHCenter, "damping, N·s/m")

    def _dot(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        question = self._answer.question
        dot = _at(frame, min(1.0, question.damping / right), min(1.0, question.stiffness / top))
        edge = _at(frame, min(1.0, question.damping / right), min(top, self._answer.limit) / top)
        token = "accent" if self._answer.stable else "danger"
        painter.setPen(QPen(theme.color(token), 1.6, Qt.PenStyle.DotLine))
        painter.drawLine(dot, edge)
        painter.setPen(QPen(theme.color("surface"), 2))
        painter.setBrush(theme.color("accent"))
        painter.drawEllipse(dot, 6, 6)
        if not self._answer.stable:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.color("danger"), 2))
            painter.drawEllipse(dot, 9, 9)


def _at(frame: QRectF, across: float, up: float) -> QPointF:
    return QPointF(frame.left() + across * frame.width(), frame.bottom() - up * frame.height())

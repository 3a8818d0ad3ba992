"""A small map of damping and stiffness: the exact boundary, and where the rendered impedance lies."""

import math

from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QBrush, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from hapkit_studio.analysis.stability.axes import height
from hapkit_studio.gui.margin import Answer
from hapkit_studio.gui.theme import theme

_HEIGHT = 146
_LEFT, _TOP, _RIGHT, _BOTTOM = 56, 8, 10, 36
_DOT_ROOM = 13  # px: as far as the ring round a dot on the frame stands out


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
        return height(self._answer.question.stiffness, self._answer.margin.limit, highest)

    def _regions(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        beyond = 10.0 * top
        curve = [_at(frame, b / right, min(k, beyond) / top) for b, k in self._answer.boundary]
        painter.save()
        painter.setClipRect(frame)
        painter.fillRect(frame, theme.color("unstable"))
        painter.fillRect(frame, QBrush(theme.color("danger", 0.25), Qt.BrushStyle.BDiagPattern))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("stable"))
        painter.drawPolygon(QPolygonF([*curve, frame.bottomRight(), frame.bottomLeft()]))
        painter.setPen(QPen(theme.color("ink"), 2))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPolyline(QPolygonF(curve))
        painter.restore()
        dot = self._place(frame, right, top)
        painter.setFont(theme.font("label"))
        for word, token, above in (("grows", "danger", True), ("stable", "ok", False)):
            box = _room_for_name(frame, curve, dot, above)
            if box is not None:
                painter.setPen(theme.color(token))
                painter.drawText(box, Qt.AlignmentFlag.AlignCenter, word)

    def _axes(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        painter.setFont(theme.font("tick"))
        painter.setPen(theme.color("ink2"))
        for part in (0.0, 0.5, 1.0):
            place = _at(frame, part, part)
            x = min(place.x() - 30, self.width() - 60)
            bottom = QRectF(x, frame.bottom() + 5, 60, 16)
            flag = Qt.AlignmentFlag.AlignRight if part == 1.0 else Qt.AlignmentFlag.AlignHCenter
            painter.drawText(bottom, flag, f"{part * right:g}")
            left = QRectF(0, place.y() - 8, _LEFT - _DOT_ROOM, 16)
            painter.drawText(
                left, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, f"{part * top:,g}"
            )
        painter.setPen(theme.color("ink3"))
        below = QRectF(frame.left(), frame.bottom() + 18, frame.width(), 18)
        painter.drawText(below, Qt.AlignmentFlag.AlignHCenter, "damping, N·s/m")

    def _place(self, frame: QRectF, right: float, top: float) -> QPointF:
        assert self._answer is not None
        question = self._answer.question
        return _at(frame, min(1.0, question.damping / right), min(1.0, question.stiffness / top))

    def _dot(self, painter: QPainter, frame: QRectF, right: float, top: float) -> None:
        assert self._answer is not None
        question, dot = self._answer.question, self._place(frame, right, top)
        edge = _at(frame, min(1.0, question.damping / right), min(top, self._answer.margin.limit) / top)
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


def _room_for_name(frame: QRectF, curve: list[QPointF], dot: QPointF, above: bool) -> QRectF | None:
    """Return where a region's name fits, clear of boundary and dot; None where the region is too small."""
    size = QSizeF(50, 18)
    y = frame.top() + 4 if above else frame.bottom() - size.height() - 4
    shares = (0.05, 0.3, 0.55, 0.95) if above else (0.95, 0.6, 0.3, 0.05)
    for share in shares:
        box = QRectF(QPointF(frame.left() + share * (frame.width() - size.width()), y), size)
        near = [p.y() for p in curve if box.left() - 12 <= p.x() <= box.right() + 12]
        clear = min(near) > box.bottom() if above else max(near) < box.top()
        if clear and not box.adjusted(-12, -12, 12, 12).contains(dot):
            return box
    return None


def _at(frame: QRectF, across: float, up: float) -> QPointF:
    return QPointF(frame.left() + across * frame.width(), frame.bottom() - up * frame.height())

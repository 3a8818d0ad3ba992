"""A kit in a few lines: paddle, sector, motor, board, its USB plug, the motor's supply, a weight."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from hapkit_studio.gui.widgets.theme import theme

_SIZE = QSize(500, 250)
_LEAST = 12
"""Pixels of the words on the screen at least, however small the drawing."""


class KitDrawing(QWidget):
    """Draws the kit, USB plugged in; supply: whether the motor's supply is to be plugged in too.

    ``show_weight``: it lies on its side, a mass hangs at its handle; ``show_scale``: it pushes on a scale.
    """

    def __init__(self, supply: bool) -> None:
        super().__init__()
        self.supply = supply
        self.weight: str | None = None
        self.scale = False
        self._zoom = 1.0
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)
        self.setMinimumSize(250, 150)
        self.setAccessibleName("Drawing of the kit")

    def show_weight(self, grams: str) -> None:
        """Lay the kit on its side, with so many grams at its handle; "0" for none."""
        self.weight, self.scale = grams, False
        self.update()

    def show_scale(self) -> None:
        """Stand the kit up, with a kitchen scale at the right of its handle."""
        self.weight, self.scale = None, True
        self.update()

    def sizeHint(self) -> QSize:
        return self.minimumSize()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(theme.color("line"), 1))
        painter.setBrush(theme.color("scene"))
        painter.drawRoundedRect(QRectF(0.5, 0.5, self.width() - 1, self.height() - 1), 8, 8)
        zoom = self._zoom = min(self.width() / _SIZE.width(), self.height() / _SIZE.height())
        painter.translate(
            (self.width() - zoom * _SIZE.width()) / 2, (self.height() - zoom * _SIZE.height()) / 2
        )
        painter.scale(zoom, zoom)
        if self.weight is not None:
            self._on_its_side(painter)
        else:
            self._upright(painter)
        if self.scale:
            self._kitchen_scale(painter)

    def _pen(self, token: str, width: float = 2.0) -> QPen:
        pen = QPen(theme.color(token), width)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        return pen

    def _paddle(self, painter: QPainter) -> None:
        """Draw the paddle about its axis at (0, 0), handle up."""
        sector = QPainterPath(QPointF(0, 8))
        sector.lineTo(-50, -62)
        sector.arcTo(QRectF(-74, -80, 148, 148), 130, -80)
        sector.closeSubpath()
        painter.setPen(self._pen("matline"))
        painter.setBrush(theme.color("mat"))
        painter.drawPath(sector)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("handle"))
        painter.drawRect(QRectF(-4, -112, 8, 40))
        painter.drawRoundedRect(QRectF(-19, -134, 38, 26), 8, 8)
        painter.setBrush(theme.color("surface"))
        painter.setPen(self._pen("matline"))
        painter.drawEllipse(QPointF(0, 0), 5, 5)

    def _motor(self, painter: QPainter, at: QPointF) -> None:
        painter.setPen(self._pen("objline"))
        painter.setBrush(theme.color("obj"))
        painter.drawEllipse(at, 15, 15)
        painter.drawEllipse(at, 4, 4)

    def _upright(self, painter: QPainter) -> None:
        self._motor(painter, QPointF(110, 86))
        painter.save()
        painter.translate(110, 178)
        self._paddle(painter)
        painter.restore()
        painter.setPen(self._pen("edge"))
        painter.setBrush(theme.color("mat2"))
        painter.drawRoundedRect(QRectF(60, 196, 100, 34), 5, 5)
        self._words(painter, QRectF(60, 196, 100, 34), "board", "ink")
        self._plug(painter, 204.0, "USB", True, "green light")
        self._plug(painter, 222.0, "12 V supply", self.supply, "on")

    def _plug(self, painter: QPainter, y: float, name: str, on: bool, when: str) -> None:
        token = "ok" if on else "ink3"
        end = 162.0 if on else 186.0
        painter.setPen(self._pen(token, 3))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        path = QPainterPath(QPointF(262, y - (40 if name == "USB" else -14)))
        path.cubicTo(230, y, 230, y, end + 14, y)
        painter.drawPath(path)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color(token))
        painter.drawRoundedRect(QRectF(end, y - 5, 16, 10), 2, 2)
        top = y - 52 if name == "USB" else y + 4
        words = f"{name}: {when}" if on else f"{name}: not plugged in"
        self._words(painter, QRectF(268, top, 230, 24), words, token, Qt.AlignmentFlag.AlignLeft)

    def _on_its_side(self, painter: QPainter) -> None:
        painter.setPen(self._pen("edge"))
        painter.setBrush(theme.color("mat2"))
        painter.drawRoundedRect(QRectF(282, 82, 30, 96), 5, 5)
        self._motor(painter, QPointF(170, 130))
        painter.save()
        painter.translate(262, 130)
        painter.rotate(-90)
        self._paddle(painter)
        painter.restore()
        self._words(painter, QRectF(0, 24, 400, 22), "the left side of the kit is down", "ink2")
        if self.weight == "0":
            self._words(painter, QRectF(60, 178, 160, 24), "no mass yet", "ink2")
            return
        painter.setPen(self._pen("ink", 1.6))
        painter.drawLine(QPointF(140, 142), QPointF(140, 184))
        painter.setPen(self._pen("objline"))
        painter.setBrush(theme.color("obj"))
        painter.drawRoundedRect(QRectF(118, 184, 44, 40), 5, 5)
        self._words(painter, QRectF(172, 192, 200, 24), f"{self.weight} g", "ink", Qt.AlignmentFlag.AlignLeft)

    def _kitchen_scale(self, painter: QPainter) -> None:
        """Draw a kitchen scale on its edge, its plate at the handle's right."""
        painter.setPen(self._pen("objline"))
        painter.setBrush(theme.color("obj"))
        painter.drawRoundedRect(QRectF(131, 24, 9, 72), 3, 3)
        painter.drawRect(QRectF(140, 50, 12, 20))
        painter.drawRoundedRect(QRectF(152, 14, 26, 92), 5, 5)
        self._words(painter, QRectF(186, 48, 200, 24), "kitchen scale", "ink2", Qt.AlignmentFlag.AlignLeft)

    def _words(
        self, painter: QPainter, box: QRectF, words: str, token: str,
        where: Qt.AlignmentFlag = Qt.AlignmentFlag.AlignHCenter,
    ) -> None:  # fmt: skip
        painter.setPen(QColor(theme.color(token)))
        font = theme.font("strong")
        font.setPixelSize(round(max(font.pixelSize(), _LEAST / self._zoom)))
        painter.setFont(font)
        flags = where | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextDontClip
        painter.drawText(box, flags, words)

"""A slider in whole steps of a quantity, on a square-root scale where the range is wide."""

from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QWheelEvent
from PySide6.QtWidgets import QSlider, QWidget

from hapkit_studio.gui.quantity import Quantity
from hapkit_studio.gui.theme import theme

_HEIGHT = 20
_THUMB = 16.0
_END = 11.0  # from the thumb at a limit to the slider's end: its focus ring stays whole
_GROOVE = 4.0


class ValueSlider(QSlider):
    """Emits ``picked`` with a value in screen units; keys move it by steps, as any slider."""

    picked = Signal(float)

    def __init__(self, quantity: Quantity, parent: QWidget | None = None):
        super().__init__(Qt.Orientation.Horizontal, parent)
        self._quantity = quantity
        self._exact = quantity.default
        self.setRange(0, quantity.steps)
        self.setSingleStep(1)
        self.setPageStep(10)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFixedHeight(_HEIGHT)
        self.valueChanged.connect(self._stepped)
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(160, _HEIGHT)

    def minimumSizeHint(self) -> QSize:
        return QSize(60, _HEIGHT)

    def show_value(self, value: float) -> None:
        """Show an exact value, on a step or between two, without saying so to anyone."""
        blocked = self.blockSignals(True)
        self._exact = value
        self.setValue(self._quantity.index(value))
        self.blockSignals(blocked)
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._pick(self._quantity.value(self._fraction_at(event.position().x())))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            self._pick(self._quantity.value(self._fraction_at(event.position().x())))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._pick(self._quantity.default)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Turn values only where the focus is, so that scrolling past changes nothing."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, thumb = self.height() / 2.0, self._place(self._exact)
        enabled = self.isEnabled()
        # in high contrast a filled groove would hide where the accent ends
        outlined = theme.name == "contrast"
        painter.setPen(QPen(theme.color("edge"), 1) if outlined else Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("surface" if outlined else "line"))
        groove = QRectF(0.5, middle - _GROOVE / 2, self.width() - 1, _GROOVE)
        painter.drawRoundedRect(groove, 2, 2)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("accent" if enabled else "edge"))
        painter.drawRoundedRect(QRectF(0, middle - _GROOVE / 2, thumb, _GROOVE), 2, 2)
        painter.setPen(QPen(theme.color("ink2"), 1.5))
        default = self._place(self._quantity.default)
        painter.drawLine(QPointF(default, middle - 6), QPointF(default, middle + 6))
        painter.setBrush(theme.color("surface"))
        painter.setPen(QPen(theme.color("accent" if enabled else "edge"), 3))
        painter.drawEllipse(QPointF(thumb, middle), _THUMB / 2 - 2, _THUMB / 2 - 2)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.color("accent"), 1.5))
            painter.drawEllipse(QPointF(thumb, middle), _THUMB / 2 + 1, _THUMB / 2 + 1)

    def _pick(self, value: float) -> None:
        if value != self._exact:
            self.show_value(value)
            self.picked.emit(value)

    def _stepped(self, index: int) -> None:
        self._exact = self._quantity.at(index)
        self.update()
        self.picked.emit(self._exact)

    def _fraction_at(self, x: float) -> float:
        return (x - _END) / max(1.0, self.width() - 2 * _END)

    def _place(self, value: float) -> float:
        return _END + self._quantity.fraction(value) * (self.width() - 2 * _END)

"""Number fields: a spin box and a slider for a quantity in display units."""

import math
import re
from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import (
    QBrush,
    QFocusEvent,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QValidator,
    QWheelEvent,
)
from PySide6.QtWidgets import QDoubleSpinBox, QSizePolicy, QSlider

from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.quantity import Quantity

_UNDO, _REDO = QKeySequence.StandardKey.Undo, QKeySequence.StandardKey.Redo
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_THOUSANDS = re.compile(r"-?[1-9]\d{0,2}(,\d{3})+(\.\d+)?")
_BEYOND = 1e9
_HEIGHT = 20
_THUMB = 16.0
_END = 11.0  # px: space for the focus ring between a thumb at its limit and the slider's end
_GROOVE = 4.0


def _number(text: str) -> float | None:
    """Return a text as a number, or None if it is not a number.

    A true minus sign, thousands separators and a decimal comma are accepted.
    """
    plain = text.strip().replace("−", "-")
    plain = plain.replace(",", "" if _THOUSANDS.fullmatch(plain) else ".")
    return float(plain) if _NUMBER.fullmatch(plain) else None


class NumberBox(QDoubleSpinBox):
    """A spin box; ``entered`` is emitted with a complete number in display units, which may be out of range.

    Thousands separators are hidden while the box has the focus, because typing would displace them.
    """

    entered = Signal(float)

    def __init__(self, quantity: Quantity):
        super().__init__()
        self._quantity = quantity
        self._typed = False
        self.setDecimals(quantity.decimals + 4)
        self.setRange(-_BEYOND, _BEYOND)
        self.setSingleStep(quantity.step)
        self.setKeyboardTracking(False)
        self.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.lineEdit().textEdited.connect(self._note_typing)
        self.editingFinished.connect(self._finish)

    def show_value(self, value: float) -> None:
        """Set a value without emitting a signal."""
        self._typed = False
        with QSignalBlocker(self):
            self.setValue(value)
            # setting an equal text would move the cursor
            if self.lineEdit().text() != self.textFromValue(value):
                self.lineEdit().setText(self.textFromValue(value))

    def textFromValue(self, value: float) -> str:
        text = self._quantity.text(value)
        return text.replace(",", "") if self.hasFocus() else text

    def valueFromText(self, text: str) -> float:
        value = _number(text)
        return self.value() if value is None else value

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        if _number(text) is not None:
            return QValidator.State.Acceptable, text, position
        begun = _number(f"{text.strip()}0") is not None
        return (QValidator.State.Intermediate if begun else QValidator.State.Invalid), text, position

    def stepBy(self, steps: int) -> None:
        value = self._quantity.moved(self.valueFromText(self.lineEdit().text()), steps)
        self.show_value(value)
        self.selectAll()
        self.entered.emit(value)

    def event(self, event: QEvent) -> bool:
        """Leave Ctrl+Z to the window, unless the user is editing the text."""
        override = event.type() == QEvent.Type.ShortcutOverride and not self._typed
        if override and isinstance(event, QKeyEvent) and (event.matches(_UNDO) or event.matches(_REDO)):
            event.ignore()
            return False
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Use Home and End to go to the limits, unless the user is editing the text."""
        ends = {Qt.Key.Key_Home: self._quantity.low, Qt.Key.Key_End: self._quantity.high}
        if event.key() in ends and not self._typed:
            self.show_value(ends[Qt.Key(event.key())])
            self.entered.emit(self.value())
            return
        super().keyPressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Ignore the wheel if the box does not have the focus: scrolling must not change values."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def focusInEvent(self, event: QFocusEvent) -> None:
        self.show_value(self.value())
        super().focusInEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.show_value(self.value())

    def _note_typing(self, _text: str) -> None:
        self._typed = True

    def _finish(self) -> None:
        value = _number(self.lineEdit().text())
        if self._typed and value is not None:
            self._typed = False
            self.entered.emit(value)


class ValueSlider(QSlider):
    """A slider; ``picked`` is emitted with a value in display units. Keys move it by steps."""

    picked = Signal(float)

    def __init__(self, quantity: Quantity):
        super().__init__(Qt.Orientation.Horizontal)
        self._quantity = quantity
        self._exact = quantity.default
        self._ranges: Sequence[tuple[float, float]] = ()
        self.setRange(0, math.ceil((quantity.high - quantity.low) / quantity.step - 1e-9))
        self.setSingleStep(1)
        self.setPageStep(10)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.valueChanged.connect(self._stepped)
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        return QSize(160, theme.px(_HEIGHT))

    def minimumSizeHint(self) -> QSize:
        return QSize(60, theme.px(_HEIGHT))

    def show_value(self, value: float) -> None:
        """Set an exact value, which may lie between steps, without emitting a signal."""
        self._exact = value
        with QSignalBlocker(self):
            self.setValue(self._quantity.index(value))
        self.update()

    def show_ranges(self, ranges: Sequence[tuple[float, float]]) -> None:
        """Hatch the ranges of unstable values."""
        if self._ranges != ranges:
            self._ranges = ranges
            self.update()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if event.buttons() & Qt.MouseButton.LeftButton:
            end = theme.px(_END)
            fraction = (event.position().x() - end) / max(1.0, self.width() - 2 * end)
            self._pick(self._quantity.value(fraction))

    mousePressEvent = mouseMoveEvent

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._pick(self._quantity.default)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Ignore the wheel if the slider does not have the focus: scrolling must not change values."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, thumb = self.height() / 2.0, self._place(self._exact)
        radius, thick = theme.px(_THUMB) / 2, theme.px(_GROOVE)
        enabled = self.isEnabled()
        # in the high-contrast theme a filled groove would hide the end of the coloured part
        outlined = theme.name == "contrast"
        painter.setPen(QPen(theme.color("edge"), 1) if outlined else Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("surface" if outlined else "line"))
        groove = QRectF(0.5, middle - thick / 2, self.width() - 1, thick)
        painter.drawRoundedRect(groove, 2, 2)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color("accent" if enabled else "edge"))
        painter.drawRoundedRect(QRectF(0, middle - thick / 2, thumb, thick), 2, 2)
        painter.setBrush(QBrush(theme.color("danger"), Qt.BrushStyle.BDiagPattern))
        for ends in self._ranges:
            low, high = (self._place(end) for end in ends)
            painter.drawRect(QRectF(low, middle - thick, high - low, 2.0 * thick))
        painter.setPen(QPen(theme.color("ink2"), 1.5))
        default = self._place(self._quantity.default)
        painter.drawLine(QPointF(default, middle - radius + 2), QPointF(default, middle + radius - 2))
        painter.setBrush(theme.color("surface"))
        painter.setPen(QPen(theme.color("accent" if enabled else "edge"), 3))
        painter.drawEllipse(QPointF(thumb, middle), radius - 2, radius - 2)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(theme.color("accent"), 1.5))
            painter.drawEllipse(QPointF(thumb, middle), radius + 1, radius + 1)

    def _pick(self, value: float) -> None:
        if value != self._exact:
            self.show_value(value)
            self.picked.emit(value)

    def _stepped(self, index: int) -> None:
        self._exact = self._quantity.moved(self._quantity.low, index)
        self.update()
        self.picked.emit(self._exact)

    def _place(self, value: float) -> float:
        end = theme.px(_END)
        return end + self._quantity.fraction(value) * (self.width() - 2 * end)

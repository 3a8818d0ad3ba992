"""A spin box that keeps what was typed, takes comma or point, and writes a true minus."""

import re

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QKeyEvent, QValidator, QWheelEvent
from PySide6.QtWidgets import QDoubleSpinBox, QWidget

from hapkit_studio.gui.quantity import Quantity

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_BEGUN = re.compile(r"[+-]?\d*\.?\d*(e[+-]?\d*)?", re.IGNORECASE)
_BEYOND = 1e9


def _plain(text: str) -> str:
    return text.strip().replace("−", "-").replace(",", ".")


class NumberBox(QDoubleSpinBox):
    """Emits ``entered`` with a finished number in screen units, which may be out of range."""

    entered = Signal(float)

    def __init__(self, quantity: Quantity, parent: QWidget | None = None):
        super().__init__(parent)
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
        """Show a value without saying so to anyone."""
        self._typed = False
        blocked = self.blockSignals(True)
        self.setValue(value)
        text = self.textFromValue(value)
        if self.lineEdit().text() != text:
            self.lineEdit().setText(text)
        self.blockSignals(blocked)

    def textFromValue(self, value: float) -> str:
        return self._quantity.text(value)

    def valueFromText(self, text: str) -> float:
        match = _NUMBER.fullmatch(_plain(text))
        return float(match.group()) if match else self.value()

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        if _NUMBER.fullmatch(_plain(text)):
            return QValidator.State.Acceptable, text, position
        begun = _BEGUN.fullmatch(_plain(text))
        return (QValidator.State.Intermediate if begun else QValidator.State.Invalid), text, position

    def stepBy(self, steps: int) -> None:
        value = self._quantity.moved(self.valueFromText(self.lineEdit().text()), steps)
        self.show_value(value)
        self.selectAll()
        self.entered.emit(value)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Take Home and End for the limits unless a text is being edited, where they move the cursor."""
        ends = {Qt.Key.Key_Home: self._quantity.low, Qt.Key.Key_End: self._quantity.high}
        if event.key() in ends and not self._typed:
            self.show_value(ends[Qt.Key(event.key())])
            self.entered.emit(self.value())
            return
        super().keyPressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Turn values only where the focus is, so that scrolling past changes nothing."""
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()

    def _note_typing(self, _text: str) -> None:
        self._typed = True

    def _finish(self) -> None:
        if self._typed and _NUMBER.fullmatch(_plain(self.lineEdit().text())):
            self._typed = False
            self.entered.emit(self.valueFromText(self.lineEdit().text()))

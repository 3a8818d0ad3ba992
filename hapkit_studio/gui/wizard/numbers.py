"""Number boxes of the wizard: what a person types in mm or g, the wizard gets in m or kg."""

from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox, QWidget

from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import MINUS


class _Scaled(QDoubleSpinBox):
    """A box whose numbers are a thousand times the SI value."""

    unit = ""

    def __init__(self, name: str, low: float, high: float, decimals: int, parent: QWidget | None = None):
        super().__init__(parent)
        self.setDecimals(decimals)
        self.setRange(low, high)
        self.setSuffix(f" {self.unit}")
        self.setAccessibleName(f"{name} in {self.unit}")
        self.setMinimumWidth(118)
        dress(self, "QDoubleSpinBox { font-size: 14px; min-height: 32px; padding: 0 18px 0 0; }")
        self.lineEdit().setTextMargins(7, 0, 0, 0)

    def textFromValue(self, value: float) -> str:
        return super().textFromValue(value).replace("-", MINUS)

    def valueFromText(self, text: str) -> float:
        return super().valueFromText(text.replace(MINUS, "-"))

    def validate(self, text: str, at: int) -> tuple[QValidator.State, str, int]:
        state, _text, place = super().validate(text.replace(MINUS, "-"), at)
        return state, text, place


class Millimetres(_Scaled):
    """A length."""

    unit = "mm"

    @property
    def metres(self) -> float:
        """Return the length in m."""
        return 1e-3 * self.value()

    def show_metres(self, length: float) -> None:
        """Show a length in m."""
        self.setValue(1e3 * length)


class Grams(_Scaled):
    """A mass."""

    unit = "g"

    @property
    def kilograms(self) -> float:
        """Return the mass in kg."""
        return 1e-3 * self.value()

    def show_kilograms(self, mass: float) -> None:
        """Show a mass in kg."""
        self.setValue(1e3 * mass)

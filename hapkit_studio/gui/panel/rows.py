"""One row per parameter: a number with a box and a slider, or a choice between options."""

import math
import re
from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox, QGridLayout, QToolButton, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.numbers import NumberBox, ValueSlider
from hapkit_studio.gui.widgets.parts import Sign, hbox, keep_size_when_hidden, label
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import plain_tip, rich, tip
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import AnyParameter, Choice, Parameter
from hapkit_studio.quantity import Quantity

# maximum number of options, and of letters, for a segmented control; a larger choice is shown as a combo box
_MOST_SEGMENTS, _MOST_LETTERS = 3, 14
BOX_WIDE, BOX_NARROW = 92, 72
_WIDE = 260  # px: if the row is narrower than this, its number box has the width BOX_NARROW
_UNIT = 42  # px: width of the longest unit


class ChoiceRow(QWidget):
    """A choice between options; ``changed(key, index)`` is emitted when the user selects an option.

    ``value`` is the selected option's index.
    """

    changed = Signal(str, float)

    def __init__(self, choice: Choice, formula: str = ""):
        super().__init__()
        self.parameter, self._formula = choice, formula
        labels = choice.option_labels
        self.label = label(choice.label)
        self.picker: Segmented | QComboBox
        if len(labels) <= _MOST_SEGMENTS and sum(map(len, labels)) <= _MOST_LETTERS:
            self.picker = Segmented(choice.label, labels)
            self.picker.chosen.connect(self._pick)
        else:
            self.picker = QComboBox()
            self.picker.addItems(labels)
            self.picker.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            self.picker.activated.connect(self._pick)
        self.padlock = Sign(16, "lock")
        hbox((self.label, 1), self.padlock, self.picker, into=self, margins=(0, 3, 0, 3), gap=6)
        self.set_locked("")
        self.show_value(choice.default)

    def tab_stops(self) -> tuple[QWidget, ...]:
        """Return the widgets at which the Tab key stops, in order."""
        return self.picker.buttons if isinstance(self.picker, Segmented) else (self.picker,)

    def show_value(self, value: float) -> None:
        """Show the chosen option."""
        self.value = float(value)
        show = self.picker.show_index if isinstance(self.picker, Segmented) else self.picker.setCurrentIndex
        show(int(value))
        self.picker.setAccessibleName(f"{self.parameter.label}, {self.parameter.option_label(value)}")

    def set_locked(self, reason: str, padlock: bool = False) -> None:
        """Disable the row and show the reason; "" enables it. With ``padlock``, a padlock is shown, too."""
        self.setEnabled(not reason)
        self.padlock.setVisible(padlock)
        self.setToolTip(tip((reason, self.parameter.help), self._formula))

    def _pick(self, index: int) -> None:
        self.show_value(index)
        self.changed.emit(self.parameter.key, self.value)


def _label_text(parameter: Parameter) -> str:
    """Return label and symbol as HTML, with no line break before the symbol."""
    symbol = re.sub(r"_(\w+)", r"<sub>\1</sub>", rich(parameter.symbol)).replace("1/", "1/\N{WORD JOINER}")
    text = rich(parameter.label)
    gap = "&nbsp;" if " " in text else " "
    return f'{text}{gap}<i style="font-family: serif">{symbol}</i>' if symbol else text


class ParameterRow(QWidget):
    """A number with box and slider; ``changed(key, SI value)`` is emitted for every accepted number.

    A rejected number stays in the box and is marked.
    """

    changed = Signal(str, float)

    def __init__(self, parameter: Parameter, formula: str = ""):
        super().__init__()
        self.parameter, self.quantity, self._formula = parameter, Quantity(parameter), formula
        self._value = math.nan
        self.label = label(_label_text(parameter))
        self.label.setTextFormat(Qt.TextFormat.RichText)
        self.box, self.slider = NumberBox(self.quantity), ValueSlider(self.quantity)
        self.label.setBuddy(self.box)
        self.unit, self.error = label(self.quantity.unit, "hint", wrap=False), label(role="error")
        self.reset, self.padlock = QToolButton(), Sign(16, "lock")
        icons.bind(self.reset, "reset", "ink2", 16)
        keep_size_when_hidden(self.reset)
        default = self._spoken(self.quantity.default)
        self.reset.setAccessibleName(f"Reset {parameter.label} to {default}")
        self.reset.setToolTip(plain_tip(self.reset.accessibleName()))
        self._arrange()
        self.set_locked("")
        self.box.entered.connect(self._enter)
        self.slider.picked.connect(self._enter)
        self.reset.clicked.connect(lambda: self._enter(self.quantity.default))
        self.show_value(parameter.default)

    @property
    def value(self) -> float:
        """Return the last accepted value in SI."""
        return self._value / self.quantity.factor

    def show_value(self, value: float) -> None:
        """Show an SI value; if the value has not changed, a rejected number stays in the box."""
        if value != self.value:
            self._show(value * self.quantity.factor)

    def show_error(self, text: str) -> None:
        """Mark the box and show the error below it; the loop keeps the last accepted value."""
        self.error.setText(text)
        self.error.setVisible(bool(text))
        mark(self.box, "invalid", bool(text))

    def show_ranges(self, ranges: Sequence[tuple[float, float]]) -> None:
        """Hatch the slider's unstable ranges, which are given in SI."""
        factor = self.quantity.factor
        self.slider.show_ranges([(low * factor, high * factor) for low, high in ranges])

    def set_locked(self, reason: str, padlock: bool = False) -> None:
        """Disable the row and show the reason; "" enables it.

        If ``padlock`` is True, because an instructor has locked the row, a padlock replaces the reset button.
        """
        self.setEnabled(not reason)
        self.padlock.setVisible(padlock)
        self._show_reset()
        text = tip((reason, self.parameter.help, self.quantity.limits()), self._formula)
        for widget in (self, self.label, self.box, self.slider):
            widget.setToolTip(text)

    def tab_stops(self) -> tuple[QWidget, ...]:
        """Return the widgets at which the Tab key stops, in order."""
        return self.box, self.reset, self.slider

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Make the box narrower in a narrow panel."""
        super().resizeEvent(event)
        self.box.setFixedWidth(theme.px(BOX_WIDE if self.width() >= theme.px(_WIDE) else BOX_NARROW))
        self._grid.setColumnMinimumWidth(2, theme.px(_UNIT))

    def _enter(self, value: float) -> None:
        if not self.quantity.inside(value):
            self.show_error(self.quantity.limits())
            return
        self._show(value)
        self.changed.emit(self.parameter.key, self.quantity.si(value))

    def _show(self, value: float) -> None:
        """Show an accepted value, which is given in the displayed unit."""
        self._value = value
        self.box.show_value(value)
        self.slider.show_value(value)
        if not self.error.isHidden():
            self.show_error("")
        self._show_reset()
        for widget in (self.box, self.slider):
            widget.setAccessibleName(f"{self.parameter.label}, {self._spoken(value)}")

    def _show_reset(self) -> None:
        changed = abs(self._value - self.quantity.default) > 1e-9 * self.quantity.step
        self.reset.setVisible(changed and self.padlock.isHidden())

    def _spoken(self, value: float) -> str:
        return f"{self.quantity.text(value)} {self.quantity.unit}".rstrip()

    def _arrange(self) -> None:
        grid = self._grid = QGridLayout(self)
        grid.setContentsMargins(0, 1, 0, 1)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(0)
        grid.addWidget(self.label, 0, 0)
        grid.addWidget(self.box, 0, 1)
        grid.addWidget(self.unit, 0, 2)
        grid.addWidget(self.reset, 0, 3, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.padlock, 0, 3, Qt.AlignmentFlag.AlignCenter)
        grid.addWidget(self.slider, 1, 0, 1, 4)
        grid.addWidget(self.error, 2, 0, 1, 4)
        grid.setColumnStretch(0, 1)
        self.box.setFixedWidth(theme.px(BOX_NARROW))  # the box is narrow until the row's width is known
        self.error.hide()


Row = ParameterRow | ChoiceRow


def row_of(parameter: AnyParameter, formula: str = "") -> Row:
    """Return the row of a parameter."""
    if isinstance(parameter, Choice):
        return ChoiceRow(parameter, formula)
    return ParameterRow(parameter, formula)

"""One row per declared parameter: a number with box and slider, or a choice."""

import re

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QComboBox, QGridLayout, QHBoxLayout, QLabel, QToolButton, QWidget

from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.numbers import NumberBox, Quantity, ValueSlider
from hapkit_studio.gui.widgets.segmented import Segmented
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import plain, plain_tip, rich, tip
from hapkit_studio.parameters import Choice, Parameter

# more, or longer words, do not fit beside the label in a narrow panel
_MOST_SEGMENTS, _MOST_LETTERS = 3, 14
BOX_WIDE, BOX_NARROW = 92, 76
_WIDE = 260  # px of a row: with less its box is narrow


class ChoiceRow(QWidget):
    """Emits ``changed(key, index)`` when a person picks another option."""

    changed = Signal(str, float)

    def __init__(self, choice: Choice, formula: str = "", parent: QWidget | None = None):
        super().__init__(parent)
        self.parameter = choice
        words = choice.words
        self.label = plain(QLabel(choice.label))
        self.label.setWordWrap(True)
        self.picker: Segmented | QComboBox
        if len(words) <= _MOST_SEGMENTS and sum(map(len, words)) <= _MOST_LETTERS:
            self.picker = Segmented(choice.label, words)
            self.picker.chosen.connect(self._take)
        else:
            self.picker = QComboBox()
            self.picker.addItems(words)
            self.picker.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            self.picker.activated.connect(self._take)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 3, 0, 3)
        row.setSpacing(6)
        row.addWidget(self.label, 1)
        row.addWidget(self.picker)
        self._formula = formula
        self.set_locked("")
        self.show_value(choice.default)

    @property
    def value(self) -> float:
        """Return the chosen option's index."""
        picker = self.picker
        return float(picker.index if isinstance(picker, Segmented) else picker.currentIndex())

    def tab_stops(self) -> tuple[QWidget, ...]:
        """Return what Tab stops at, in order."""
        return self.picker.buttons if isinstance(self.picker, Segmented) else (self.picker,)

    def show_value(self, value: float) -> None:
        """Show the option that is in force."""
        index = int(value)
        if isinstance(self.picker, Segmented):
            self.picker.show_index(index)
        else:
            self.picker.setCurrentIndex(index)
        self._name(value)

    def set_locked(self, reason: str) -> None:
        """Leave the option readable but fixed, and say why; no reason unlocks it."""
        self.setEnabled(not reason)
        self.setToolTip(tip((reason, self.parameter.help), self._formula))

    def _name(self, value: float) -> None:
        self.picker.setAccessibleName(f"{self.parameter.label}, {self.parameter.word(value)}")

    def _take(self, index: int) -> None:
        self._name(index)
        self.changed.emit(self.parameter.key, float(index))


def _keep_size_when_hidden(widget: QWidget) -> None:
    """Let a widget keep its room while it is hidden, so that nothing moves when it comes and goes."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(True)
    widget.setSizePolicy(policy)


class ParameterRow(QWidget):
    """Emits ``changed(key, SI value)`` for every accepted number; a bad one stays in the box, marked."""

    changed = Signal(str, float)

    def __init__(self, parameter: Parameter, formula: str = "", parent: QWidget | None = None):
        super().__init__(parent)
        self.parameter = parameter
        self.quantity = Quantity.of(parameter)
        self._value = self.quantity.default
        self.label = QLabel(self._label_text(), textFormat=Qt.TextFormat.RichText)
        self.label.setWordWrap(True)
        self.box = NumberBox(self.quantity)
        self.box.setFixedWidth(BOX_WIDE)
        self.label.setBuddy(self.box)
        self.unit = plain(QLabel(self.quantity.unit))
        self.unit.setProperty("role", "hint")
        self.reset = QToolButton()
        icons.bind(self.reset, "reset", "ink2", 16)
        _keep_size_when_hidden(self.reset)
        self.slider = ValueSlider(self.quantity)
        self.error = plain(QLabel())
        self.error.setProperty("role", "error")
        self.error.setWordWrap(True)
        self._arrange()
        self._formula = formula
        self._name_reset()
        self.set_locked("")
        self._connect()
        self.show_value(parameter.default)

    @property
    def value(self) -> float:
        """Return the last good value, SI."""
        return self._value / self.quantity.factor

    def show_value(self, value: float) -> None:
        """Show an SI value that is already in force."""
        self._value = value * self.quantity.factor
        self.box.show_value(self._value)
        self._show_good()

    def show_error(self, text: str) -> None:
        """Mark the box and say below what the limit is; the loop keeps the last good value."""
        self.error.setText(text)
        self.error.setVisible(bool(text))
        mark(self.box, "invalid", bool(text))

    def tab_stops(self) -> tuple[QWidget, ...]:
        """Return what Tab stops at, in order."""
        return self.box, self.reset, self.slider

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Leave the label more room in a narrow panel."""
        super().resizeEvent(event)
        self.box.setFixedWidth(BOX_WIDE if self.width() >= _WIDE else BOX_NARROW)

    def set_compact(self, compact: bool) -> None:
        """Leave the slider out where the panel is low."""
        self.slider.setVisible(not compact)

    def _take(self, value: float) -> None:
        if not self.quantity.inside(value):
            self.show_error(self.quantity.limits())
            return
        self._value = value
        self.box.show_value(value)
        self._show_good()
        self.changed.emit(self.parameter.key, self._si(value))

    def _si(self, value: float) -> float:
        return min(self.parameter.high, max(self.parameter.low, value / self.quantity.factor))

    def _show_good(self) -> None:
        if not self.error.isHidden():
            self.show_error("")
        self.slider.show_value(self._value)
        self.reset.setVisible(abs(self._value - self.quantity.default) > 1e-9 * self.quantity.step)
        spoken = f"{self.parameter.label}, {self.quantity.text(self._value)} {self.quantity.unit}".rstrip()
        self.box.setAccessibleName(spoken)
        self.slider.setAccessibleName(spoken)

    def _label_text(self) -> str:
        symbol = re.sub(r"_(\w+)", r"<sub>\1</sub>", rich(self.parameter.symbol))
        label = rich(self.parameter.label)
        if not symbol:
            return label
        # a symbol stays on the line of its word
        gap = "&nbsp;" if " " in label else " "
        return f'{label}{gap}<i style="font-family: serif">{symbol}</i>'

    def _arrange(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 1, 0, 1)
        grid.setHorizontalSpacing(4)
        grid.setVerticalSpacing(0)
        grid.addWidget(self.label, 0, 0)
        grid.addWidget(self.box, 0, 1)
        grid.addWidget(self.unit, 0, 2)
        grid.addWidget(self.reset, 0, 3, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(self.slider, 1, 0, 1, 4)
        grid.addWidget(self.error, 2, 0, 1, 4)
        grid.setColumnStretch(0, 1)
        grid.setColumnMinimumWidth(2, 42)
        self.error.hide()

    def set_locked(self, reason: str) -> None:
        """Leave the value readable but fixed, and say why; no reason unlocks it."""
        self.setEnabled(not reason)
        words = tip((reason, self.parameter.help, self.quantity.limits()), self._formula)
        for widget in (self, self.label, self.box, self.slider):
            widget.setToolTip(words)

    def _name_reset(self) -> None:
        default = f"{self.quantity.text(self.quantity.default)} {self.quantity.unit}".rstrip()
        self.reset.setToolTip(plain_tip(f"Back to {default}"))
        self.reset.setAccessibleName(f"Reset {self.parameter.label} to {default}")

    def _connect(self) -> None:
        self.box.entered.connect(self._take)
        self.slider.picked.connect(self._take)
        self.reset.clicked.connect(self._to_default)

    def _to_default(self) -> None:
        self._take(self.quantity.default)

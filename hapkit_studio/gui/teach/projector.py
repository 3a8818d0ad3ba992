"""The large widgets of the projector view: title, two values with sliders, and the verdict."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial

from PySide6.QtCore import QSettings, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QLabel, QMenu, QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.gallery_row import icon_name
from hapkit_studio.gui.widgets.numbers import ValueSlider
from hapkit_studio.gui.widgets.parts import AnswerLine, Sign, hbox, label, refill, rule, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.text import show_formula
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.parameters import AnyParameter, Choice
from hapkit_studio.quantity import Quantity

VALUES = 2
# px: minimum heights of the card for two values, and for two values with sliders
_ROOM_FOR_VALUES, _ROOM_FOR_SLIDERS = 170, 200


class LargeValue(QWidget):
    """Shows one parameter's value in large letters; a menu at its name selects another parameter."""

    def __init__(self, studio: Studio, parameter: AnyParameter, choose: Callable[[str], None]):
        super().__init__()
        self._studio, self.parameter = studio, parameter
        self.quantity = None if isinstance(parameter, Choice) else Quantity(parameter)
        name = QPushButton(parameter.label)
        name.setProperty("flat", True)
        name.setProperty("menu", True)
        menu = QMenu(self)  # the menu is deleted together with this widget
        for other in studio.environment.parameters:
            menu.addAction(other.label, partial(choose, other.key))
        name.setMenu(menu)
        name.setToolTip("Show a different parameter here")
        name.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.figure = label(role="figure", wrap=False)
        unit = label(self.quantity.unit if self.quantity else "", "readout", wrap=False)
        value = hbox(self.figure, unit, None, gap=6)
        value.setAlignment(unit, Qt.AlignmentFlag.AlignBottom)
        self.padlock = Sign(16, "lock")
        self.slider = ValueSlider(self.quantity) if self.quantity else None
        if self.slider is not None and self.quantity is not None:
            self.slider.setAccessibleName(parameter.label)
            self.slider.picked.connect(lambda shown, to_si=self.quantity.si: self._set(to_si(shown)))
        vbox(hbox(name, self.padlock, None, gap=6), value, *([self.slider] if self.slider else []), into=self)
        self.show_value()

    def show_value(self) -> None:
        """Show the current value, and whether it is locked."""
        value = self._studio.values[self.parameter.key]
        fixed = self._studio.why_fixed("value", self._studio.environment.key, self.parameter.key)
        self.padlock.setVisible(bool(fixed))
        self.padlock.setToolTip(fixed)
        if self.slider is not None:
            self.slider.setEnabled(not fixed)
        if isinstance(self.parameter, Choice):
            self.figure.setText(self.parameter.option_label(value))
        elif self.quantity is not None and self.slider is not None:
            shown = value * self.quantity.factor
            self.figure.setText(self.quantity.text(shown))
            self.slider.show_value(shown)

    def step(self, steps: int) -> None:
        """Change the value by some steps of its spin box, or select another option."""
        value = self._studio.values[self.parameter.key]
        if self.quantity is None:
            self._set(min(max(value + steps, 0.0), self.parameter.high))
        else:
            self._set(self.quantity.si(self.quantity.moved(value * self.quantity.factor, steps)))

    def _set(self, value: float) -> None:
        with suppress(ParameterError):  # the device may refuse the value in combination with another one
            self._studio.set_value(self.parameter.key, value)
        self.show_value()


class ValueCard(QWidget):
    """Shows two values and the verdict below; at first these are the environment's first two parameters."""

    def __init__(self, studio: Studio, settings: QSettings):
        super().__init__()
        self._studio, self._settings = studio, settings
        self.values: list[LargeValue] = []
        self.verdict = AnswerLine()
        self._column = vbox(gap=4)
        vbox(self._column, None, rule(), self.verdict, into=self, margins=(14, 6, 14, 6), gap=4)
        studio.environment_changed.connect(self.rebuild)
        for changed in (studio.values_changed, studio.lock_changed):
            changed.connect(self._show_values)
        self.rebuild()

    @property
    def _place(self) -> str:
        return f"projected/{self._studio.environment.key}"

    @property
    def chosen(self) -> list[str]:
        """Return the keys of the shown parameters."""
        keys = [parameter.key for parameter in self._studio.environment.parameters]
        stored = str(self._settings.value(self._place, "")).split()
        stored = [key for key in dict.fromkeys(stored) if key in keys]
        return [*stored, *(key for key in keys if key not in stored)][:VALUES]

    def choose(self, index: int, key: str) -> None:
        """Show a parameter at an index; if it is already shown at the other index, swap both."""
        chosen = self.chosen
        if key in chosen:
            chosen[chosen.index(key)] = chosen[index]
        chosen[index] = key
        self._settings.setValue(self._place, " ".join(chosen))
        self.rebuild()

    def step(self, index: int, steps: int) -> None:
        """Change a value by some steps, if a value is shown at this index."""
        if index < len(self.values):
            self.values[index].step(steps)

    def rebuild(self) -> None:
        """Show the parameters of the current environment."""
        known = {parameter.key: parameter for parameter in self._studio.environment.parameters}
        self.values = [
            LargeValue(self._studio, known[key], partial(self.choose, index))
            for index, key in enumerate(self.chosen)
        ]
        refill(self._column, self.values)
        self._fit()

    def show_verdict(self, text: str, icon: str, token: str) -> None:
        """Show the verdict on stability with its icon and token."""
        self.verdict.show_text(text, icon, token)
        mark(self.verdict.label, "ink", token)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _show_values(self) -> None:
        for value in self.values:
            value.show_value()

    def _fit(self) -> None:
        """Hide the sliders in a low card, and also the second value in an even lower one."""
        for value in self.values[1:]:
            value.setVisible(self.height() >= theme.px(_ROOM_FOR_VALUES))
        for value in self.values:
            if value.slider is not None:
                value.slider.setVisible(self.height() >= theme.px(_ROOM_FOR_SLIDERS))


class Title(QWidget):
    """Shows icon, title and, if there is enough space, the formula of the current environment in one line."""

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self.setObjectName("projectorTitle")
        self.picture, self.title, self.formula = Sign(28), label(role="title", wrap=False), QLabel()
        self.formula.setTextFormat(Qt.TextFormat.RichText)
        hbox(self.picture, self.title, 8, self.formula, None, into=self)
        studio.environment_changed.connect(self.show_state)
        theme.changed.connect(self.show_state)
        self.show_state()

    def show_state(self) -> None:
        """Show the current environment."""
        environment = self._studio.environment
        self.picture.show_sign(icon_name(environment.scene), "ink")
        self.title.setText(environment.title)
        show_formula(self.formula, environment.formula)
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        taken = theme.px(28 + 16) + self.title.sizeHint().width() + self.formula.sizeHint().width()
        self.formula.setVisible(taken + 24 <= self.width())

"""The experiment on the just-noticeable difference: a blind comparison with a staircase procedure."""

import random
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QPushButton, QWidget

from hapkit_studio.analysis import discrimination
from hapkit_studio.analysis.discrimination import COMPARISON, UNITS, Comparison, Staircase
from hapkit_studio.charts.experiments import draw_threshold, threshold_text
from hapkit_studio.gui.state import permissions
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.teach.blind import BlindPage
from hapkit_studio.gui.teach.experiment import Experiment, RecordedTrials, ResultDialog
from hapkit_studio.gui.widgets.dialogs import FormDialog, text_dialog
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity

if TYPE_CHECKING:
    from hapkit_studio.environments.base import Values

TITLE = "Just-noticeable difference"
_ABOUT = (
    "You compare the value set now with a larger value, in random order, and say which is larger. The "
    "difference becomes smaller after three correct answers and larger after a wrong answer. After about 60 "
    "answers, the smallest difference that you notice is known (the just-noticeable difference). Every "
    "answer is recorded. Use a real Hapkit, because a simulated Hapkit can only be judged by sight."
)
_HOW = (
    "Feel setting 1 and setting 2 as often as you like: the key X switches between them. Then press the "
    "number of the setting with the larger value. If you are not sure, guess."
)
_LEAST_ROOM = 0.1  # smallest useful first step, as a fraction of the base value
_NONE = "This environment has no stiffness, damping or force that can be raised by 10 %."


def room(studio: Studio, parameter: Parameter) -> float:
    """Return the fraction by which a parameter can be raised within its limits and the stable range."""
    base = studio.values[parameter.key]
    unstable = (low for low, high in studio.unstable_ranges.get(parameter.key, ()) if high > base)
    return min(parameter.high, *unstable, base * (1.0 + discrimination.LARGEST)) / base - 1.0


def comparable(studio: Studio) -> list[Parameter]:
    """Return the parameters whose threshold can be measured at their current value."""
    return [
        parameter
        for parameter in studio.environment.parameters
        if isinstance(parameter, Parameter)
        and parameter.unit in UNITS
        and studio.values[parameter.key] > 0.0
        and parameter.key not in studio.environment.unused(studio.values)
        and room(studio, parameter) >= _LEAST_ROOM
    ]


class ThresholdDialog(FormDialog):
    """Asks for the parameter to be compared; ``begun`` is emitted with this parameter."""

    begun = Signal(object)

    def __init__(self, studio: Studio, parent: QWidget):
        super().__init__(TITLE, _ABOUT, parent)
        self.parameter, self.start = QComboBox(), QPushButton("Start")
        for one in comparable(studio):
            quantity = Quantity(one)
            text = f"{one.label}, {quantity.text(studio.values[one.key] * quantity.factor)} {quantity.unit}"
            self.parameter.addItem(text, one)
        self.add_fields([("Value to compare", self.parameter, None)])
        self.add_verdict(1)
        self.add_buttons(self.start)
        self.start.setDefault(True)
        self.start.setEnabled(self.parameter.count() > 0)
        self.verdict.show_text("" if self.parameter.count() else _NONE)
        self.verdict.setVisible(not self.parameter.count())
        self.start.clicked.connect(self._start)

    def _start(self) -> None:
        self.close()
        self.begun.emit(self.parameter.currentData())


class ThresholdPage(BlindPage):
    """Compares a base value with a larger one until the staircase has finished."""

    title, about, reason = TITLE, _HOW, permissions.THRESHOLD

    def __init__(self, studio: Studio, parameter: Parameter, source: random.Random | None = None):
        self.parameter, self.base = parameter, studio.values[parameter.key]
        largest = room(studio, parameter)
        self.stairs = Staircase(min(discrimination.FIRST, largest), largest)
        self.found: list[Comparison] = []
        self.trials: RecordedTrials | None = None
        super().__init__(studio, self._pair(studio.values), source)
        self.end_button.setText("Stop and evaluate")

    def _pair(self, values: "Values") -> "list[Values]":
        step = self.base * (1.0 + self.stairs.step)
        return [dict(values), {**values, self.parameter.key: step}]

    def begin(self) -> None:
        super().begin()
        if self.trials is None:
            self.trials = RecordedTrials(self._studio.recording)

    def answer(self, place: int) -> None:
        """Record an answer, and let the staircase choose the next difference."""
        turns, step = len(self.stairs.reversals), self.stairs.step * self.base
        more = self._order.index(self._wanted) + 1
        self.stairs.answer(place + 1 == more)
        turned = len(self.stairs.reversals) > turns
        key, unit = self.parameter.key, self.parameter.unit
        one = Comparison(self._studio.environment.key, key, unit, self.base, step, more, place + 1, turned)
        self.found.append(one)
        if self.trials is not None:
            self.trials.note(COMPARISON, discrimination.event(one))
        self._values = self._pair(self._studio.values)
        super().answer(place)
        if self.stairs.finished:
            self.finish()

    def count_text(self) -> str:
        turns = min(len(self.stairs.reversals), discrimination.REVERSALS)
        return (
            f"Answers: {self.answers}. The difference changed direction {turns} of "
            f"{discrimination.REVERSALS} times."
        )


class ThresholdExperiment(Experiment):
    """Asks for the parameter, shows the page, and shows the threshold at the end."""

    def show_settings(self) -> None:
        """Open the dialog of the parameter."""
        dialog = ThresholdDialog(self._studio, self._window)
        dialog.begun.connect(self.begin)
        dialog.show()

    def begin(self, parameter: Parameter, source: random.Random | None = None) -> None:
        """Start the experiment with a parameter of the active environment."""
        if not self.possible or parameter not in comparable(self._studio):
            return
        self._start(ThresholdPage(self._studio, parameter, source))

    def show_results(self, page: ThresholdPage, name: str) -> None:
        if not page.found:
            text_dialog(TITLE, ["No answer was given."], self._window).show()
            return
        (found,) = discrimination.evaluate(page.found)
        texts = [threshold_text(found)]
        if not page.stairs.finished:
            count = len(page.found)
            texts.append(f"You stopped after {count} answer{'s' * (count != 1)}, so the result is uncertain.")
        if name:
            texts.append(
                f"The answers are recorded in {name}. The view Speed and accuracy can use your threshold "
                "instead of the published ones."
            )
        ResultDialog(
            TITLE, texts, lambda figure, c: draw_threshold(figure, c, found), parent=self._window
        ).show()

"""The quiz: the user estimates a hidden stiffness or damping, which is drawn at random."""

import random
from dataclasses import replace
from functools import partial
from statistics import fmean
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.formatting import number
from hapkit_studio.gui.pages.base import SidePanel
from hapkit_studio.gui.pages.views import Views
from hapkit_studio.gui.panel.rows import BOX_WIDE
from hapkit_studio.gui.panel.stability_card import StabilityCard
from hapkit_studio.gui.state.background import Job, Progress
from hapkit_studio.gui.state.permissions import QUIZ
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.numbers import NumberBox
from hapkit_studio.gui.widgets.parts import AnswerLine, hbox, hint, label, primary
from hapkit_studio.parameters import Parameter
from hapkit_studio.quantity import Quantity

if TYPE_CHECKING:
    from hapkit_studio.analysis.stability.verdict import VerdictInput

LEAST, MOST = 0.5, 4.0
"""Range of the drawn values in multiples of the default.

They are perceptible, and below the stability limit.
"""
DRAWS = 20
_ABOUT = (
    "The scene has a hidden value. Estimate this value by feel, with the plots and with their cursors. "
    "Other settings are locked until you close the quiz. Then your settings come back."
)
_NONE = (
    "No stable value was found for the present loop settings and grip. Close the quiz and choose a shorter "
    "delay."
)


def asked_for(environment: Environment, values: Values) -> Parameter | None:
    """Return the parameter that the quiz asks for, which is the environment's first parameter.

    Return None if it is unsuitable, or if the law does not consist only of its declared terms.
    """
    first, terms = next(iter(environment.parameters), None), environment.force_terms(values)
    if not isinstance(first, Parameter) or first.default <= 0.0 or not terms.simple:
        return None
    return first if getattr(terms, first.key, None) == values[first.key] else None


def draw(parameter: Parameter, source: random.Random) -> list[float]:
    """Return different values in SI in random order; each is a multiple of the panel's step."""
    quantity = Quantity(parameter)
    low, high = (quantity.index(min(quantity.default * times, quantity.high)) for times in (LEAST, MOST))
    steps = range(max(low, 1), high + 1)
    drawn = source.sample(steps, min(DRAWS, len(steps)))
    return [quantity.si(quantity.moved(quantity.low, step)) for step in drawn]


def first_calm(asked: "VerdictInput", key: str, drawn: list[float], progress: Progress) -> float | None:
    """Return the first drawn value with the verdict "calm"; None if no value gets this verdict."""
    from hapkit_studio.analysis.stability.verdict import verdict  # imported late to keep start-up fast

    for done, value in enumerate(drawn):
        progress(done, len(drawn))
        if verdict(replace(asked, values={**asked.values, key: value})).calm:
            return value
    return None


def comparison(quantity: Quantity, guess: float, true: float) -> tuple[float, str]:
    """Return the error in % of an estimate in the displayed unit, and a sentence about the error."""
    error = 100.0 * (guess - true) / true
    side = "low" if error < 0.0 else "high"
    found = f"{number(abs(error), 1)} % too {side}" if round(error, 1) else "right"
    guess_text, true_text = (f"{quantity.text(value)} {quantity.unit}" for value in (guess, true))
    return error, f"You entered {guess_text}. The true value is {true_text}: {found}."


class QuizSide(SidePanel):
    """The side panel that asks for the hidden value."""

    def __init__(self, studio: Studio, asked: "VerdictInput", parameter: Parameter, source: random.Random):
        super().__init__("Quiz", _ABOUT)
        self._studio, self._asked, self._parameter, self._source = studio, asked, parameter, source
        self._true: float | None = None
        self.errors: list[float] = []
        self.quantity = Quantity(parameter)
        self.box, self.answer, self.count = NumberBox(self.quantity), AnswerLine(), hint()
        self.show_true, self.more, self.leave = map(
            QPushButton, ("Show true value", "Next value", "Close quiz")
        )
        self.job = Job(self, needs="verdict")
        self._arrange()
        self.job.running_changed.connect(self._offer)
        self.job.finished.connect(self._render)
        self.job.failed.connect(lambda why: self.answer.show_text(why, "triangle", "warn"))
        self.show_true.clicked.connect(self.compare)
        self.box.lineEdit().returnPressed.connect(self.compare)
        self.more.clicked.connect(self.ask)
        self.leave.clicked.connect(lambda: studio.hide_values(None))

    def begin(self) -> None:
        """Lock all settings, because the verdict is valid only for these settings; draw the first value."""
        self._studio.hide_values(self._asked.values, QUIZ)
        self.ask()

    def ask(self) -> None:
        """Draw another value for which the verdict is calm."""
        self.answer.show_text("Looking for a stable value…")
        drawn = draw(self._parameter, self._source)
        self.job.start(partial(first_calm, self._asked, self._parameter.key, drawn))

    def compare(self) -> None:
        """Show the true value beside the estimate."""
        self.box.interpretText()
        guess, true = self.box.value(), self._true
        if true is None:
            return
        if guess <= 0.0 or not self.quantity.inside(guess):
            self.answer.show_text(self.quantity.limits() if guess else "Enter your estimate first.")
            return
        error, text = comparison(self.quantity, guess, true * self.quantity.factor)
        self.errors.append(abs(error))
        self.count.setText(f"Estimates: {len(self.errors)}. Mean error: {number(fmean(self.errors), 1)} %.")
        self.answer.show_text(text)
        self._true = None
        self._offer()

    def _render(self, value: float | None) -> None:
        if value is None:
            self.answer.show_text(_NONE, "triangle", "warn")
            return
        self._true = value
        self._studio.hide_values({**self._asked.values, self._parameter.key: value}, QUIZ)
        self.box.show_value(0.0)
        self.answer.show_text(f"Estimate the hidden {self._parameter.label.lower()}.")
        self._offer()

    def _offer(self) -> None:
        """Enable the buttons for the next action: compare an estimate, or ask for another value."""
        self.more.setEnabled(self._true is None and not self.job.running)
        for part in (self.box, self.show_true):
            part.setEnabled(self._true is not None)

    def _arrange(self) -> None:
        name, row = label(f"Your estimate of {self._parameter.label.lower()}"), QWidget()
        name.setBuddy(self.box)
        self.box.setAccessibleName(f"{name.text()} in {self.quantity.unit}")
        self.box.setFixedWidth(BOX_WIDE)
        hbox((name, 1), self.box, label(self.quantity.unit, wrap=False), into=row)
        self.section(self._studio.environment.title)
        self.add(row, primary(self.show_true), self.answer, self.count, self.more, self.leave)


class Quiz(QObject):
    """Shows the quiz, and closes it as soon as the values are no longer hidden."""

    def __init__(self, studio: Studio, card: StabilityCard, views: Views, window: QWidget):
        super().__init__(window)
        self._studio, self._card, self._views = studio, card, views
        self.side: QuizSide | None = None
        studio.hidden_changed.connect(self._refresh)
        studio.engine_changed.connect(self.end)  # the verdict is valid for one device only

    @property
    def parameter(self) -> Parameter | None:
        """Return the parameter for the next question; None without a question, or if the value is locked."""
        studio, card = self._studio, self._card
        wanted = asked_for(studio.environment, studio.values)
        if wanted is None or studio.temporary or card.verdict_input() is None:
            return None
        return None if studio.why_fixed("value", studio.environment.key, wanted.key) else wanted

    def begin(self, source: random.Random | None = None) -> None:
        """Ask about the current environment; ``source`` generates the random values."""
        wanted, asked = self.parameter, self._card.verdict_input()
        if wanted is not None and asked is not None:
            self.side = QuizSide(self._studio, asked, wanted, source or random.Random())
            self._views.cover(self.side)
            self.side.begin()

    def end(self) -> None:
        """End a running quiz and render the values that the window shows."""
        if self.side is not None:
            self._studio.hide_values(None)

    def _refresh(self) -> None:
        if self.side is not None and not self._studio.hidden:
            side, self.side = self.side, None
            self._views.cover(None)
            side.job.end()
            side.deleteLater()

"""Blind comparison of A and B. They are shuffled before each answer, and the score is shown at the end."""

import random
from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QFrame, QPushButton, QWidget

from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import number
from hapkit_studio.gui.pages.base import Page, SidePanel
from hapkit_studio.gui.pages.views import Views
from hapkit_studio.gui.panel.two_settings import TwoSettings, TwoSettingsDialog
from hapkit_studio.gui.state import permissions
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.dialogs import text_dialog
from hapkit_studio.gui.widgets.parts import hbox, hint, label, primary, vbox
from hapkit_studio.parameters import Parameter

if TYPE_CHECKING:
    from hapkit_studio.environments.base import Values

_ABOUT = (
    "Setting 1 and setting 2 are A and B in random order. The order changes after each answer. Plots "
    "and values are hidden: judge by what you feel or, with the mouse, by how the handle moves. The key "
    "X switches between setting 1 and setting 2 as often as you like."
)

_OTHERS = "The demo has ended. A and B cannot be compared: they belong to the environment of the demo."


def score(right: int, answers: int) -> str:
    """Describe how many answers were right, and the score to expect from guessing."""
    guessed = number(answers / 2.0, answers % 2)
    return (
        f"{right} of {answers} answers are correct. Guessing would give {guessed}."
        if answers
        else "No answer was given."
    )


class BlindPage(Page):
    """The page of the comparison. It replaces the plots until ``ended`` is emitted with the score as text.

    The rendered values are hidden from the window; choosing another environment ends the comparison.
    """

    ended = Signal(str)
    title, about, reason = "Blind comparison", _ABOUT, permissions.BLIND

    def __init__(self, studio: Studio, pair: "Sequence[Values]", source: random.Random | None = None):
        """``pair`` contains the environment's values for A and for B."""
        super().__init__()
        self._studio, self._source, self._values = studio, source or random.Random(), list(pair)
        self._wanted, self._question = self._ask()
        self.right = self.answers = self.shown = 0
        self._order = [0, 1]
        self.sign, self.count = label(role="verdict"), label(role="hint", wrap=False)
        self.switch, self.end_button = QPushButton("Switch"), QPushButton("End and show score")
        self.choices = [QPushButton(f"{place}") for place in (1, 2)]
        for button in self.choices:
            button.setAccessibleName(f"Answer: {button.text()}")
        self._arrange()
        self.switch.clicked.connect(self.turn)
        for place, button in enumerate(self.choices):
            button.clicked.connect(lambda _on=False, place=place: self.answer(place))
        self.end_button.clicked.connect(self.finish)
        studio.hidden_changed.connect(self._refresh)

    def begin(self) -> None:
        """Shuffle A and B, and render the first; raise ParameterError if a value of A or B is locked."""
        if not self._studio.hidden:
            for values in self._values:
                self._studio.check_values(self._studio.environment.key, values)
        self._order = self._source.sample((0, 1), 2)
        self.shown = 0
        self._render()

    def turn(self) -> None:
        """Render the setting that is not rendered now."""
        self.shown = 1 - self.shown
        self._render()

    def answer(self, place: int) -> None:
        """Count an answer (0: the first setting, 1: the second), and shuffle again."""
        self.answers += 1
        self.right += self._order[place] == self._wanted
        self.begin()

    def finish(self) -> None:
        """End the comparison with the score, and render the values that the window shows."""
        self._studio.hide_values(None)

    def _refresh(self) -> None:
        if not self._studio.hidden:
            self._studio.hidden_changed.disconnect(self._refresh)
            self.ended.emit(score(self.right, self.answers))

    def _render(self) -> None:
        self._studio.hide_values(self._values[self._order[self.shown]], self.reason)
        self.sign.setText(f"Setting {self.shown + 1} is active")
        self.count.setText(self.count_text())

    def count_text(self) -> str:
        """Return a text with the number of answers so far."""
        return f"Answers so far: {self.answers}"

    def _ask(self) -> tuple[int, str]:
        """Return the index of the right answer, and the question to the user.

        If only one number differs between A and B, the question is about this number.
        """
        a, b = self._values
        differ = [p for p in self._studio.environment.parameters if a[p.key] != b[p.key]]
        if len(differ) == 1 and isinstance(differ[0], Parameter):
            more = int(b[differ[0].key] > a[differ[0].key])
            return more, f"Which setting has more {differ[0].label.lower()}?"
        return 0, "Which setting is A?"

    def _arrange(self) -> None:
        card = QFrame()
        card.setProperty("card", True)
        self.sign.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        head = hbox(None, label(self._question, "title", wrap=False), *self.choices, None)
        foot = hbox(None, self.switch, hint("X"), None)
        vbox(None, self.sign, foot, head, hbox(None, self.count, None), None, into=card, gap=16)
        self.column.addWidget(card)
        self.side = SidePanel(self.title, self.about)
        self.side.add(primary(self.end_button))


class BlindComparison(QObject):
    """Shows the page of the comparison, and the score at the end; the key X calls ``step``."""

    beginning = Signal()
    """Emitted before the start: other temporary changes of settings must be restored first."""

    def __init__(self, studio: Studio, two: TwoSettings, views: Views, window: QWidget):
        super().__init__(window)
        self._studio, self._two, self._views, self._window = studio, two, views, window
        self.page: BlindPage | None = None

    def step(self) -> None:
        """Render the other settings of a running comparison, or store the current settings as A or B."""
        if self.page is not None:
            self.page.turn()
        else:
            self._two.step()

    def show_settings(self) -> None:
        """Open the dialog of the settings A and B."""
        dialog = TwoSettingsDialog(self._two, self._window)
        dialog.blind.connect(self.begin)
        dialog.show()

    def begin(self, source: random.Random | None = None) -> None:
        """Start the comparison of A and B, shuffled by ``source``."""
        if not self._two.comparable:
            return
        if self._studio.hidden:
            self._studio.refused.emit(f"{self._studio.hidden}.")
            return
        self.beginning.emit()
        if not self._two.comparable:  # the settings belong to another environment
            self._studio.refused.emit(_OTHERS)
            return
        key = self._studio.environment.key
        pair = [{p[2]: v for p, v in kept.items() if p[:2] == ("value", key)} for kept in self._two.stored]
        page = BlindPage(self._studio, pair, source)
        try:
            page.begin()
        except ParameterError as error:  # the settings were locked meanwhile
            self._studio.refused.emit(str(error))
            return
        self.page = page
        page.ended.connect(self._end)
        self._views.cover(page.side, page)

    def _end(self, text: str) -> None:
        page, self.page = self.page, None
        self._views.cover(None)
        if page is not None and page.side is not None:
            page.side.deleteLater()
            page.deleteLater()
        text_dialog("Blind comparison", [text], self._window).show()

"""The widgets of a step: checks with their answers, questions, hints, and plots to look at."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import (
    QButtonGroup,
    QFrame,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QRadioButton,
    QWidget,
)

from hapkit_studio.gui.pages.lessons.text import text_label
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.parts import Sign, hbox, hint, label, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.lessons.evaluate import CORRECT, WAITING, WRONG, Result
from hapkit_studio.lessons.lesson import Check, Hint, Plot, Question

# signs of a result's states; every other state is shown as a circle
_SIGNS = {CORRECT: ("check", "ok"), WRONG: ("triangle", "warn"), "review": ("check", "ok")}
_WAITS = "circle", "ink2"
_NUMBER_WIDE, _TEXT_HIGH = 110, 78
_OVER = {"time": "Plots over time", "position": "Force over position", "velocity": "Force over velocity"}


class Task(QFrame):
    """A card with a sign, a task and the result; ``entry`` is an optional widget between them."""

    def __init__(self, title: str):
        super().__init__()
        self.setProperty("card", True)
        self.sign, self.title, self.label = Sign(18), label(title, "strong"), label()
        self.entry = vbox()
        column = vbox(self.title, self.entry, self.label, gap=5)
        hbox(vbox(self.sign, None), (column, 1), into=self, margins=(10, 9, 10, 9), gap=8)

    def show_result(self, result: Result) -> None:
        """Show the task's result in a sentence."""
        self.sign.show_sign(*_SIGNS.get(result.state, _WAITS))
        self.label.setText(result.text)
        mark(self.label, "ink", {CORRECT: "ok", WRONG: "warn"}.get(result.state, "ink2"))
        state = "done" if result.state in (CORRECT, "review") else "not done"
        self.setAccessibleName(f"{self.title.text()}: {state}. {result.text}")

    def stops(self) -> list[QWidget]:
        """Return the widgets at which the Tab key stops, in order."""
        return []


class CheckTask(Task):
    """Shows a check of the student's actions."""

    def __init__(self, check: Check):
        super().__init__(check.title)


class _Option(QWidget):
    """A radio button with a text of several lines."""

    def __init__(self, text: str):
        super().__init__()
        self.button, self._label = QRadioButton(), label(text)
        self.button.setAccessibleName(text)
        hbox(self.button, (self._label, 1), into=self, gap=6)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self.button.setFocus(Qt.FocusReason.MouseFocusReason)
            self.button.click()


class QuestionTask(Task):
    """Shows a question; emits ``answered`` with the entry. Enter or Tab completes a number."""

    answered = Signal(str)

    def __init__(self, question: Question, given: str):
        self.options: list[QRadioButton] = []
        self.field: QLineEdit | None = None
        self.text: QPlainTextEdit | None = None
        super().__init__(question.text)
        self.entry.addWidget(self._entry(question, given))

    def _entry(self, question: Question, given: str) -> QWidget:
        if question.kind == "choice":
            return self._choice(question, given)
        if question.kind == "number":
            return self._number(question, given)
        self.text = QPlainTextEdit(given)
        self.text.setAccessibleName(question.text)
        self.text.setProperty("field", True)
        self.text.setTabChangesFocus(True)
        self.text.setFixedHeight(theme.px(_TEXT_HIGH))
        self.text.textChanged.connect(lambda: self.answered.emit(self.text.toPlainText()))
        return self.text

    def _choice(self, question: Question, given: str) -> QWidget:
        entry, group = QWidget(), QButtonGroup(self)
        column = vbox(into=entry, gap=3)
        for at, text in enumerate(question.options):
            option = _Option(text)
            option.button.setChecked(text == given)
            group.addButton(option.button, at)
            self.options.append(option.button)
            column.addWidget(option)
        group.idClicked.connect(lambda at: self.answered.emit(question.options[at]))
        return entry

    def _number(self, question: Question, given: str) -> QWidget:
        entry, field = QWidget(), QLineEdit(given)
        field.setAccessibleName(f"{question.text} in {question.unit}" if question.unit else question.text)
        field.setFixedWidth(theme.px(_NUMBER_WIDE))
        field.editingFinished.connect(lambda: self.answered.emit(field.text()))
        self.field = field
        hbox(field, label(question.unit, "axis", wrap=False), None, into=entry)
        return entry

    def show_result(self, result: Result) -> None:
        super().show_result(result)
        self.label.setVisible(result.state != WAITING)

    def stops(self) -> list[QWidget]:
        return [part for part in (*self.options, self.field, self.text) if part is not None]


class HintPart(QWidget):
    """A hint that is shown after a click on its button."""

    def __init__(self, block: Hint):
        super().__init__()
        self.button, self.label = QPushButton("Hint", autoDefault=True), text_label(block.tokens)
        self.button.setProperty("flat", True)
        self.button.setCheckable(True)
        icons.bind(self.button, "info", "accent", 18)
        self.button.toggled.connect(self.label.setVisible)
        self.label.hide()
        vbox(hbox(self.button, None), self.label, into=self, gap=3)

    def stops(self) -> list[QWidget]:
        """Return the widgets at which the Tab key stops."""
        return [self.button]


def plot_part(block: Plot) -> QWidget:
    """Return the line that names the plot to look at."""
    part, caption = QWidget(), hint(f"{_OVER[block.over]}: {block.caption}".rstrip(": "))
    hbox(Sign(18, "gauge", "ink2"), (caption, 1), into=part, gap=8)
    return part

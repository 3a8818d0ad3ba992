"""What the page of a step is made of: words, pictures, buttons, and below them what was found."""

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox, QFrame, QLabel, QPushButton, QScrollArea, QWidget, QWizardPage

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION, Calibration
from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.formatting import MINUS
from hapkit_studio.gui.widgets.parts import across, down, label
from hapkit_studio.gui.widgets.parts import primary as as_primary
from hapkit_studio.gui.wizard.board_dialog import Recent, ResultBox
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import HandleView

Job = Callable[[Calibration], Any]
_SIDE, _SPACE = 24, 12


class StepPage(QWizardPage):
    """One step. It is complete once it has a result; until then it may only be skipped.

    name: in the list of steps; heading, words: on the page; begin: what the box says at first; if_skipped:
    what is assumed then; pushes: the motor does; needs_direction: not before that is known; first: the button
    that gets the keyboard, never one that starts the motor. ``job_started``: a job runs from now on;
    ``changed``: the result did.
    """

    job_started, changed = Signal(), Signal()
    name = heading = words = begin = if_skipped = ""
    pushes = needs_direction = False
    first: QPushButton | None = None
    handle: HandleView | None = None

    def __init__(self, board: BoardThread) -> None:
        super().__init__()
        self.board = board
        self.result: CheckResult | None = None
        self._buttons: list[tuple[QPushButton, Callable[[], bool]]] = []
        self.box, self.hint = ResultBox(), label()
        self.hint.setProperty("ink", "ink2")
        self.column = down(label(self.heading, "title"), margins=(_SIDE, 18, _SIDE, _SPACE), gap=_SPACE)
        self.foot = down(self.box, self.hint, margins=(_SIDE, 0, _SIDE, _SPACE), gap=6)
        content, area = QWidget(), QScrollArea()
        content.setLayout(self.column)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidgetResizable(True)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(content)
        content.setAutoFillBackground(False)
        area.viewport().setAutoFillBackground(False)
        down((area, 1), self.foot, into=self)
        if self.words:
            self.add_text(self.words)
        self.box.show_text(self.begin)

    @property
    def calibration(self) -> Calibration:
        """Return the calibration under way; there is none before the board is open."""
        return self.board.subject

    def isComplete(self) -> bool:
        return self.result is not None and not self.board.busy

    # what a step declares

    def enter(self) -> None:
        """Show what holds now; the page has come into sight, or the board has been opened."""
        if self.needs_direction and self.result is None and self.calibration is not None:
            if self.calibration.direction_known:
                self.box.show_text("The motor is off until you press a button.")
            else:
                self.box.show_warning(NO_DIRECTION)

    def show_recent(self, recent: Recent) -> None:
        """Draw what the board reports; twenty times a second while in sight."""
        if self.handle is not None:
            self.handle.show_handle(float(recent.position[-1]), recent.force)

    def reset(self) -> None:
        """Forget what was found: it holds no longer."""
        self.result = None
        self.box.show_text("Not done yet. The motor is off.")

    # what a step uses

    def add_text(self, words: str = "") -> QLabel:
        """Add words on what to do; return their label."""
        made = label(words)
        self.column.addWidget(made)
        return made

    def add_row(self, *parts: QWidget) -> None:
        """Add parts side by side, from the left."""
        self.column.addLayout(across(*parts, None, gap=10))

    def add_handle(self, picture: QWidget | None = None) -> None:
        """Add a picture of the handle, whose hand a person drags where the board has one; beside another."""
        view = self.handle = HandleView(with_force=self.pushes)
        view.hand_moved.connect(self.board.move_hand)
        view.hand_released.connect(lambda: self.board.move_hand(None))
        self.board.opened.connect(lambda _subject: view.set_hand_enabled(self.board.has_hand))
        if picture is None:
            self.column.addWidget(view)
        else:
            self.column.addLayout(across((picture, 1), (view, 1), gap=10), 1)

    def button(
        self,
        words: str,
        press: Callable[[], object],
        primary: bool = False,
        motor: bool = False,
        ready: Callable[[], bool] = lambda: True,
    ) -> QPushButton:
        """Return a button of the step, disabled while a job runs or it is not ready.

        One that starts the motor waits for the direction where the step needs it.
        """
        made = as_primary(QPushButton(words)) if primary else QPushButton(words)
        made.setProperty("tall", True)
        made.setProperty("motor", motor)
        made.clicked.connect(lambda: press())
        if motor and self.needs_direction:
            ready = lambda: self.calibration.direction_known  # noqa: E731
        self._buttons.append((made, ready))
        return made

    def job_button(
        self, words: str, says: str, job: Job, after: Callable[[Any], object], **options: Any
    ) -> QPushButton:
        """Return a button that runs a job, which needs nothing that is typed; options: as of ``button``."""
        return self.button(words, lambda: self.run_job(says, job, after), **options)

    def run_job(self, words: str, job: Job, after: Callable[[Any], object]) -> None:
        """Hand the board's thread a job, say meanwhile what it does, then call after(result)."""
        if self.board.run_job(job, after):
            self.box.show_working(words)
            self.job_started.emit()

    def finish(self, result: CheckResult) -> None:
        """Show and keep what the step found."""
        self.result = result
        self.box.show_result(result)
        self.changed.emit()

    def show_refusal(self, words: str, remedy: str = "") -> None:
        """Show why a job ended without a result, and what to do."""
        self.box.show_warning(words, remedy)

    def offer_buttons(self) -> None:
        """Enable the buttons that are ready, and Next; none while a job runs or there is no board."""
        free = not self.board.busy and self.calibration is not None
        for button, ready in self._buttons:
            button.setEnabled(free and ready())
        self.completeChanged.emit()


class ThousandthsBox(QDoubleSpinBox):
    """A number box in mm or g, whose value in SI units is a thousandth of what it shows."""

    def __init__(self, name: str, unit: str, low: float, high: float, decimals: int) -> None:
        super().__init__()
        self.setDecimals(decimals)
        self.setRange(low, high)
        self.setSuffix(f" {unit}")
        self.setAccessibleName(f"{name} in {unit}")
        self.setMinimumWidth(118)
        self.lineEdit().setTextMargins(7, 0, 0, 0)

    @property
    def si(self) -> float:
        """Return the value in m or kg."""
        return 1e-3 * self.value()

    def show_si(self, value: float) -> None:
        """Show a value in m or kg."""
        self.setValue(1e3 * value)

    def textFromValue(self, value: float) -> str:
        return super().textFromValue(value).replace("-", MINUS)

    def valueFromText(self, text: str) -> float:
        return super().valueFromText(text.replace(MINUS, "-"))

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        state, _text, place = super().validate(text.replace(MINUS, "-"), position)
        return state, text, place

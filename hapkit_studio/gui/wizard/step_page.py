"""The base class of a step's page: texts, pictures, buttons, and the result below them."""

from collections.abc import Callable
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QFrame,
    QLabel,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QWidget,
    QWizardPage,
)

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION, Calibration
from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.formatting import MINUS
from hapkit_studio.gui.widgets.parts import hbox, label, vbox
from hapkit_studio.gui.widgets.parts import primary as as_primary
from hapkit_studio.gui.wizard.board_dialog import Recent, ResultBox
from hapkit_studio.gui.wizard.board_thread import BoardThread
from hapkit_studio.gui.wizard.pictures import HandleView

Job = Callable[[Calibration], Any]
_SIDE, _SPACE = 24, 12


class StepPage(QWizardPage):
    """One step. It is complete once it has a result; until then the user can only skip it.

    ``name`` is shown in the list of steps, ``heading`` and ``intro`` on the page. ``begin`` is the initial
    text of the result's box. ``if_skipped`` is the assumption if the step is skipped. ``pushes`` is True if
    the motor pushes in this step, ``needs_direction`` if the step requires the direction test. ``first`` is
    the button with the initial focus; it never starts the motor. ``job_started`` is emitted when a job
    starts, ``changed`` when the result has changed.
    """

    job_started, changed = Signal(), Signal()
    name = heading = intro = begin = if_skipped = ""
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
        self.column = vbox(margins=(_SIDE, 18, _SIDE, _SPACE), gap=_SPACE)
        self.foot = vbox(self.box, self.hint, margins=(_SIDE, 0, _SIDE, _SPACE), gap=6)
        content, area = QWidget(), QScrollArea()
        vbox((self.column, 1), into=content).addStretch(0)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setWidgetResizable(True)
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        area.setWidget(content)
        content.setAutoFillBackground(False)
        area.viewport().setAutoFillBackground(False)
        vbox((area, 1), self.foot, into=self)
        self.add_text(self.heading, "title")
        if self.intro:
            self.add_text(self.intro)
        self.box.show_text(self.begin)

    @property
    def calibration(self) -> Calibration:
        """Return the current calibration; requires an open board."""
        return self.board.subject

    def isComplete(self) -> bool:
        return self.result is not None and not self.board.busy

    # methods for subclasses

    def enter(self) -> None:
        """Update the page when it becomes visible or the board is opened."""
        if self.needs_direction and self.result is None and self.calibration is not None:
            if self.calibration.direction_known:
                self.box.show_text("The motor is off until you press a button.")
            else:
                self.box.show_warning(NO_DIRECTION)

    def show_recent(self, recent: Recent) -> None:
        """Draw the board's samples; this is called twenty times per second while the page is visible."""
        if self.handle is not None:
            self.handle.show_handle(float(recent.position[-1]), recent.force)

    def reset(self) -> None:
        """Clear an outdated result."""
        self.result = None
        self.box.show_text("This step is not done yet. The motor is off.")

    # building blocks

    def add_text(self, text: str = "", role: str = "") -> QLabel:
        """Add an instruction and return its label, which is only as high as its text."""
        made = label(text, role)
        made.setAlignment(Qt.AlignmentFlag.AlignTop)
        policy = made.sizePolicy()
        policy.setVerticalPolicy(QSizePolicy.Policy.Maximum)
        made.setSizePolicy(policy)
        self.column.addWidget(made)
        return made

    def add_row(self, *parts: QWidget) -> None:
        """Add a row of widgets, aligned to the left."""
        self.column.addLayout(hbox(*parts, None, gap=6))

    def add_handle(self, picture: QWidget | None = None) -> None:
        """Add a picture of the handle beside another picture.

        If the board has a simulated hand, the user can drag this hand.
        """
        view = self.handle = HandleView(with_force=self.pushes)
        view.hand_moved.connect(self.board.move_hand)
        view.hand_released.connect(lambda: self.board.move_hand(None))
        self.board.opened.connect(lambda _subject: view.set_hand_enabled(self.board.has_hand))
        if picture is None:
            self.column.addWidget(view)
        else:
            self.column.addLayout(hbox((picture, 1), (view, 1), gap=10), 1)

    def button(
        self,
        text: str,
        press: Callable[[], object],
        primary: bool = False,
        motor: bool = False,
        ready: Callable[[], bool] = lambda: True,
    ) -> QPushButton:
        """Return a button of the step; it is disabled during a job, or if ``ready()`` is False.

        If the step needs the direction test, a button that starts the motor is disabled before that test.
        """
        made = as_primary(QPushButton(text)) if primary else QPushButton(text)
        made.setProperty("tall", True)
        made.setProperty("motor", motor)
        made.clicked.connect(lambda: press())
        if motor and self.needs_direction:
            ready = lambda: self.calibration.direction_known  # noqa: E731
        self._buttons.append((made, ready))
        return made

    def job_button(
        self, text: str, says: str, job: Job, after: Callable[[Any], object], **options: Any
    ) -> QPushButton:
        """Return a button that runs a job which needs no typed input.

        ``options`` are passed to ``button``.
        """
        return self.button(text, lambda: self.run_job(says, job, after), **options)

    def run_job(self, text: str, job: Job, after: Callable[[Any], object]) -> None:
        """Run a job in the board's thread and show ``text`` meanwhile; afterwards call ``after(result)``."""
        if self.board.run_job(job, after):
            self.box.show_working(text)
            self.job_started.emit()

    def finish(self, result: CheckResult) -> None:
        """Show and store the step's result."""
        self.result = result
        self.box.show_result(result)
        self.changed.emit()

    def show_refusal(self, text: str, remedy: str = "") -> None:
        """Show the reason why a job ended without a result, and the remedy."""
        self.box.show_warning(text, remedy)

    def enable_buttons(self) -> None:
        """Enable the buttons that are ready, and Next.

        During a job or without a board, enable none of them.
        """
        free = not self.board.busy and self.calibration is not None
        for button, ready in self._buttons:
            button.setEnabled(free and ready())
        self.completeChanged.emit()


class ThousandthsBox(QDoubleSpinBox):
    """A number box in mm or g; its value is also available in SI units."""

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

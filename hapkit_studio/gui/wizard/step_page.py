"""What the page of a step is made of: words, pictures, buttons, and below them what was found."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QValidator
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QFrame,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QWidget,
    QWizardPage,
)

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION
from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.formatting import MINUS
from hapkit_studio.gui.widgets.parts import across, down, label
from hapkit_studio.gui.widgets.parts import primary as as_primary
from hapkit_studio.gui.wizard.board_dialog import Recent, ResultBox
from hapkit_studio.gui.wizard.pictures import HandleView

if TYPE_CHECKING:
    from hapkit_studio.analysis.calibrate.calibration import Calibration
    from hapkit_studio.gui.wizard.board_thread import BoardThread

_SIDE, _SPACE = 24, 12


class StepPage(QWizardPage):
    """One step. It is complete once it has a result; until then it may only be skipped.

    name: in the list of steps; heading, words: on the page; begin: what the box says at first; if_skipped:
    what is assumed then; ``job_started``: a job runs from now on.
    """

    job_started = Signal()
    name = heading = words = begin = if_skipped = ""
    needs_direction = False

    def __init__(self, board: "BoardThread") -> None:
        super().__init__()
        self.board = board
        self.result: CheckResult | None = None
        self.box, self.hint = ResultBox(), label()
        self.hint.setProperty("ink", "ink2")
        self.column = down(label(self.heading, "title"), margins=(_SIDE, 18, _SIDE, _SPACE), gap=_SPACE)
        self.foot = down(self.box, self.hint, margins=(_SIDE, 0, _SIDE, _SPACE), gap=6)
        content = QWidget()
        content.setLayout(self.column)
        down((_scrolling(content), 1), self.foot, into=self)
        if self.words:
            self.add_text(self.words)
        if self.begin:
            self.box.show_text(self.begin)

    def isComplete(self) -> bool:
        return self.result is not None and not self.board.busy

    @property
    def calibration(self) -> "Calibration":
        """Return the calibration under way."""
        return self.board.subject

    @property
    def direction_known(self) -> bool:
        """Say whether the direction was tried, and force and position agree."""
        work = self.board.subject
        return work is not None and work.direction is not None and bool(work.direction.agrees)

    # what a step declares

    def enter(self) -> None:
        """Show what holds now; the page has come into sight, or the board has been opened."""
        if self.needs_direction and self.result is None and self.board.subject is not None:
            if self.direction_known:
                self.box.show_text("The motor is off until you press a button.")
            else:
                self.box.show_warning(NO_DIRECTION)

    def show_recent(self, recent: Recent) -> None:
        """Draw what the board reports; twenty times a second while in sight."""

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

    def add_row(self, *parts: QWidget) -> QHBoxLayout:
        """Add parts side by side, from the left."""
        row = across(*parts, None, gap=10)
        self.column.addLayout(row)
        return row

    def add_handle(self, picture: QWidget | None = None) -> HandleView:
        """Add a picture of the handle, whose hand a person drags where the board has one; beside another."""
        view = HandleView()
        view.hand_moved.connect(self.board.move_hand)
        self.board.opened.connect(lambda _subject: view.set_hand_enabled(self.board.has_hand))
        if picture is None:
            self.column.addWidget(view)
        else:
            self.column.addLayout(across((picture, 1), (view, 1), gap=10), 1)
        return view

    def button(
        self, words: str, press: Callable[[], object], primary: bool = False, motor: bool = False
    ) -> QPushButton:
        """Return a button of the step; one that starts the motor never gets the keyboard by itself."""
        made = as_primary(QPushButton(words)) if primary else QPushButton(words)
        made.setProperty("tall", True)
        made.setAutoDefault(False)
        made.setProperty("takes_focus", primary and not motor)
        made.setProperty("motor", motor)
        made.clicked.connect(lambda: press())
        return made

    def run_job(
        self, words: str, job: Callable[["Calibration"], object], after: Callable[..., object]
    ) -> bool:
        """Hand the board's thread a job, say meanwhile what it does, then call after(result)."""
        if not self.board.run_job(job, after):
            return False
        self.box.show_working(words)
        self.set_busy(True)
        self.job_started.emit()
        return True

    def finish(self, result: CheckResult) -> None:
        """Show and keep what the step found."""
        self.result = result
        self.box.show_result(result)
        self.completeChanged.emit()

    def show_refusal(self, words: str, remedy: str = "") -> None:
        """Show why a job ended without a result, and what to do."""
        self.box.show_warning(words, remedy)

    def set_busy(self, busy: bool) -> None:
        """Disable buttons while a job runs."""
        for button in self.findChildren(QPushButton):
            if not button.property("always_enabled"):
                waits = self.needs_direction and bool(button.property("motor")) and not self.direction_known
                button.setEnabled(not busy and not waits)


def _scrolling(content: QWidget) -> QScrollArea:
    """Return an area that scrolls up and down where the height is short, never sideways."""
    area = QScrollArea()
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setWidgetResizable(True)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setWidget(content)
    content.setAutoFillBackground(False)
    area.viewport().setAutoFillBackground(False)
    return area


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

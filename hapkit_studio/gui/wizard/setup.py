"""The dialog *Set up my Hapkit*: seven steps on the board, each of which can be skipped."""

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import QListWidget, QListWidgetItem, QPushButton, QWidget, QWizard

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.analysis.calibrate.result import PASS, SKIP, CheckResult
from hapkit_studio.devices.padding import measure_padding
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.dialogs import on_screen
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.gui.wizard.board_dialog import NEUTRAL, SIGNS, BoardDialog, Recent
from hapkit_studio.gui.wizard.step_connect import ConnectStep
from hapkit_studio.gui.wizard.step_direction import DirectionStep
from hapkit_studio.gui.wizard.step_friction import FrictionStep
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.gui.wizard.step_save import Notes, SaveStep
from hapkit_studio.gui.wizard.step_scale import ScaleStep
from hapkit_studio.gui.wizard.step_sensor import SensorStep
from hapkit_studio.gui.wizard.step_strength import StrengthStep

if TYPE_CHECKING:
    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.state.studio import Studio

_SIZE, _SMALLEST = (1060, 700), (860, 560)
_ROW_HEIGHT, _LIST_WIDTH, _ICON = 44, 200, 18
_AFTER_STOP = "Press Release E-stop above, take your hands off, then start this step again."
_BUTTONS = QWizard.WizardButton
_SKIP, _AGAIN, _CLOSE = _BUTTONS.CustomButton1, _BUTTONS.CustomButton2, _BUTTONS.CustomButton3
_BACK, _NEXT, _SPACE = _BUTTONS.BackButton, _BUTTONS.NextButton, _BUTTONS.Stretch
_WORDS = {_BACK: "Back", _NEXT: "Next", _SKIP: "Skip", _AGAIN: "Try again"}


class _Pages(QWizard):
    """The wizard with the steps' pages.

    It passes all keys to the dialog, where Esc stops the motor and Enter presses the focused button.
    """

    def keyPressEvent(self, event: QKeyEvent) -> None:
        event.ignore()


class SetupDialog(BoardDialog):
    """Shows the steps, a list of them, and the buttons Back, Next and Skip.

    The board acts only after the user has pressed a button.
    """

    title = "Set up my Hapkit"

    def __init__(self, studio: "Studio", parent: QWidget) -> None:
        super().__init__(studio, parent)
        self.setMinimumSize(on_screen(self, _SMALLEST))
        self.resize(on_screen(self, _SIZE))
        board = self.board
        self.connect_step, self.direction_step = ConnectStep(board), DirectionStep(board)
        self.save_step = SaveStep(board, self.notes)
        self.steps: list[StepPage] = [
            self.connect_step, SensorStep(board), ScaleStep(board), self.direction_step,
            StrengthStep(board), FrictionStep(board), self.save_step,
        ]  # fmt: skip
        self._skipped: dict[int, CheckResult] = {}
        self.list = self._make_list()
        self.pages = self._make_pages()
        self.back, self.next, self.skip, self.again = (self.pages.button(which) for which in _WORDS)
        self.column.addWidget(self.pages, 1)
        self._connect()
        self.pages.restart()
        around = self.list.parentWidget()  # QWizard has created this widget with a margin
        around.layout().setContentsMargins(0, 0, 0, 0)  # type: ignore[union-attr]
        self._show_opening()

    @staticmethod
    def prepare(runner: "BoardRunner") -> Calibration:
        """Return a calibration.

        If the USB chip delays frames, also measure how much padding shortens the delay.
        """
        work = Calibration(runner)
        if runner.board.usb_chip:
            work.padding = measure_padding(runner.board)
        return work

    # user actions

    @property
    def index(self) -> int:
        """Return the index of the visible step, counted from 0."""
        return self.pages.currentId()

    @property
    def step(self) -> StepPage:
        """Return the visible step."""
        return self.steps[self.index]

    def go(self, index: int) -> None:
        """Show a step; Back and Next lead to its neighbours."""
        while self.index < index:
            self.pages.next()
        while self.index > index:
            self.pages.back()

    def skip_step(self) -> None:
        """Skip a step, and show the assumption that replaces its result."""
        self._skipped[self.index] = CheckResult(SKIP, f"This step was skipped. {self.step.if_skipped}")
        self.pages.next()

    def try_again(self) -> None:
        """Open the board again and start with the first step; earlier results are discarded."""
        self.board.start()
        self.reset()
        self._show_opening()
        self.setFocus()

    def reset(self) -> None:
        """Clear results and notes of all steps, and go to the first."""
        self._skipped.clear()
        for step in self.steps:
            step.reset()
        self.pages.restart()

    def notes(self) -> Notes:
        """Return notes for every step except the last, by the step's name.

        A note states whether the step is done, and describes its result or the assumption that replaces it.
        """
        return {
            step.name: (step.result is not None, step.result.text if step.result else step.if_skipped)
            for step in self.steps[:-1]
        }

    def show_recent(self, recent: Recent) -> None:
        if self.board.subject is not None and self.board.runner is not None:
            self.step.show_recent(recent)
            self.step.box.show_progress(*self.board.runner.progress)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Stop the motor if settings have changed, because the handle may now be inside a wall.
        If the user has released the E-stop in this dialog, the motor is not stopped again.
        """
        work = self.board.subject
        changed = (
            work is not None and replace(of_settings(work.original), label=work.board.label) != work.board
        )
        if self.studio.link.state == "idle" and changed and not self.released:
            self.studio.stop()
        super().closeEvent(event)

    # events

    def _entered(self, index: int) -> None:
        """Start the step that has become visible; the index is −1 while the wizard restarts."""
        if index < 0:
            return
        for step in self.steps:
            if step.handle is not None:
                step.handle.let_go.click()
        self.list.setCurrentRow(index)
        ways_on = [_BACK] if self.step is self.save_step else [_SKIP, _BACK, _NEXT]
        self.pages.setButtonLayout([_CLOSE, _SPACE, *ways_on])
        self.step.enter()
        self._show_state()
        self._focus()

    def _focus(self) -> None:
        """Move the focus to Next if the step is done, otherwise to the step's first button.

        If that button starts the motor, the page itself gets the focus, so that Enter has no effect.
        """
        done = self.step.result is not None and self.step.result.good
        on = self.close_button if self.step is self.save_step else self.next
        (on if done else self.step.first or self.step).setFocus()

    def _show_opening(self) -> None:
        self.steps[0].box.show_working("Starting the board…")
        self._show_state()

    def _opened(self, _subject: object) -> None:
        self.step.enter()
        self._show_state()
        self._focus()

    def _job_started(self) -> None:
        """Give the focus to the E-stop during a job."""
        self._show_state()
        self.stop.setFocus()

    def _job_ended(self, text: str = "") -> None:
        if text:
            self.step.show_refusal(text, _AFTER_STOP if self.studio.stopped else "")
        self._show_state()
        if not self.board.busy and self.stop.hasFocus():
            self._focus()

    def _failed(self, text: str) -> None:
        """Show the failure on every page; only the buttons Try again and Close remain."""
        for step in self.steps:
            step.box.show_text(
                text, "The motor is off. Check the cable, then press Try again.", ("unplugged", "warn")
            )
        self._show_state()
        self.pages.setButtonLayout([_CLOSE, _SPACE, _AGAIN])
        self.again.setFocus()

    def _undone(self) -> None:
        """Restart the steps, because all results have been undone."""
        self.reset()
        text = "The board has its old settings again, so there is nothing to save."
        self.step.box.show_text(text, sign=SIGNS[PASS])

    def _changed(self) -> None:
        """Show a step's result; if the step is done, move the focus to Next."""
        tried, work = self.direction_step, self.board.subject
        if tried.result is not None and work is not None and work.direction is None:
            tried.reset()  # force or position has been reversed since this test
        self._show_state()
        if self.step.result is not None and self.step.result.good:
            self._focus()

    def _show_state(self) -> None:
        """Show the state of the steps, the possible actions, and what Skip would do."""
        for index, step in enumerate(self.steps):
            result, row = step.result or self._skipped.get(index), self.list.item(index)
            text = result.text if result is not None else "This step is not done yet."
            sign, color = SIGNS[result.level] if result is not None else NEUTRAL
            row.setIcon(icons.icon(sign, color, _ICON))
            row.setToolTip(text)
            row.setData(Qt.ItemDataRole.AccessibleTextRole, f"{step.name}: {text}")
            step.enable_buttons()
        step, free = self.step, not self.board.busy
        last, good = step is self.save_step, step.result is not None and step.result.good
        step.hint.setText("" if good or last else f"If you skip this step: {step.if_skipped}")
        self.list.setEnabled(free)
        self.skip.setEnabled(free)
        self.back.setEnabled(free and self.index > 0)
        self.close_button.setText("Cancel" if self.board.job_running else "Close")

    # construction

    def _make_pages(self) -> QWizard:
        pages = _Pages(self)
        # the pages are a part of this dialog, not a separate window
        pages.setWindowFlags(Qt.WindowType.Widget)
        pages.setWizardStyle(QWizard.WizardStyle.ModernStyle)
        pages.setOption(QWizard.WizardOption.IndependentPages)
        pages.setOption(QWizard.WizardOption.NoDefaultButton)
        pages.setSideWidget(self.list)
        for step in self.steps:
            pages.addPage(step)
        pages.setButton(_CLOSE, self.close_button)
        for which, text in _WORDS.items():
            pages.setButtonText(which, text)
        for button in pages.findChildren(QPushButton):
            button.setAutoDefault(False)
        return pages

    def _make_list(self) -> QListWidget:
        rows = QListWidget()
        rows.setFixedWidth(_LIST_WIDTH)
        rows.setIconSize(QSize(_ICON, _ICON))
        rows.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        rows.setAccessibleName("Steps")
        for number, step in enumerate(self.steps, 1):
            row = QListWidgetItem(f"{number}   {step.name}", rows)
            row.setSizeHint(QSize(_LIST_WIDTH - 2, _ROW_HEIGHT))
        return rows

    def _connect(self) -> None:
        self.list.currentRowChanged.connect(self.go)
        self.pages.currentIdChanged.connect(self._entered)
        self.skip.clicked.connect(self.skip_step)
        self.again.clicked.connect(self.try_again)
        self.board.opened.connect(self._opened)
        self.board.done.connect(lambda _result: self._job_ended())
        self.board.refused.connect(self._job_ended)
        self.board.failed.connect(self._failed)
        for step in self.steps:
            step.changed.connect(self._changed)
            step.job_started.connect(self._job_started)
        self.save_step.undone.connect(self._undone)
        self.connect_step.padding_chosen.connect(self.studio.device.set_padding)
        theme.changed.connect(self._show_state)

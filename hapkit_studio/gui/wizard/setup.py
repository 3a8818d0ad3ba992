"""Set up my Hapkit: seven steps on the board itself, each of which may be skipped."""

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import (
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QWidget,
    QWizard,
)

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.analysis.calibrate.result import PASS, CheckResult, skipped
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.padding import measure_padding
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.gui.widgets import icons
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.gui.wizard.board_dialog import NEUTRAL, SIGNS, BoardDialog, Recent
from hapkit_studio.gui.wizard.pictures import HandleView
from hapkit_studio.gui.wizard.step_page import StepPage
from hapkit_studio.gui.wizard.step_save import Notes, SaveStep
from hapkit_studio.gui.wizard.step_scale import ScaleStep
from hapkit_studio.gui.wizard.step_strength import StrengthStep
from hapkit_studio.gui.wizard.steps import ConnectStep, DirectionStep, FrictionStep, SensorStep

if TYPE_CHECKING:
    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.studio import Studio

_SIZE, _SMALLEST = (1060, 700), (860, 560)
_ROW_HEIGHT, _LIST_WIDTH, _ICON = 44, 200, 18
_AFTER_STOP = "Press Release E-stop above, hands off, then begin this step again."
_BUTTONS = QWizard.WizardButton
_CLOSE, _SKIP, _AGAIN = _BUTTONS.CancelButton, _BUTTONS.CustomButton1, _BUTTONS.CustomButton2
_BACK, _NEXT, _SPACE = _BUTTONS.BackButton, _BUTTONS.NextButton, _BUTTONS.Stretch


class _Pages(QWizard):
    """Leaves keys to the dialog that it stands in; ``close_pressed`` where a wizard would close itself."""

    close_pressed = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        event.ignore()

    def done(self, result: int) -> None:
        self.close_pressed.emit()


class SetupDialog(BoardDialog):
    """Back, Next and Skip, or any step from the list; nothing runs without a button being pressed."""

    title = "Set up my Hapkit"

    def __init__(self, studio: "Studio", parent: QWidget) -> None:
        super().__init__(studio, parent)
        self.setMinimumSize(*_SMALLEST)
        self.resize(*_SIZE)
        board = self.board
        self.connect_step, self.direction_step = ConnectStep(board), DirectionStep(board)
        self.save_step = SaveStep(board, self.notes)
        self.steps: list[StepPage] = [
            self.connect_step, SensorStep(board), ScaleStep(board), self.direction_step,
            StrengthStep(board), FrictionStep(board), self.save_step,
        ]  # fmt: skip
        self._skipped: dict[int, CheckResult] = {}
        self.list, self.pages = self._make_list(), _Pages(self)
        self.pages.setWindowFlags(Qt.WindowType.Widget)  # part of this dialog, no window of its own
        self.pages.setWizardStyle(QWizard.WizardStyle.ModernStyle)
        for option in (QWizard.WizardOption.IndependentPages, QWizard.WizardOption.NoDefaultButton):
            self.pages.setOption(option)
        self.pages.setSideWidget(self.list)
        for step in self.steps:
            self.pages.addPage(step)
        self.close_button, self.skip, self.again, self.back, self.next = (
            self._make_button(which, words)
            for which, words in (
                (_CLOSE, "Close"), (_SKIP, "Skip"), (_AGAIN, "Try again"), (_BACK, "Back"), (_NEXT, "Next"),
            )
        )  # fmt: skip
        self._show_failed(False)
        self.column.addWidget(self.pages, 1)
        self._connect()
        self.pages.restart()
        around = self.list.parentWidget()  # made by QWizard, with a margin
        around.layout().setContentsMargins(0, 0, 0, 0)  # type: ignore[union-attr]
        self._show_opening()

    @staticmethod
    def prepare(runner: "BoardRunner") -> Calibration:
        """Return a calibration; where a USB chip may hold frames back, with what filling them gains."""
        work = Calibration(runner)
        if isinstance(runner.board, HapkitBoard) and not isinstance(runner.board, VirtualBoard):
            work.padding = measure_padding(runner.board)
        return work

    # what a person does

    @property
    def index(self) -> int:
        """Return the number of the step in sight, from 0."""
        return self.pages.currentId()

    @property
    def step(self) -> StepPage:
        """Return the step in sight."""
        return self.steps[self.index]

    def go(self, index: int) -> None:
        """Show a step; its neighbours stay those of Back and Next."""
        while self.index < index:
            self.pages.next()
        while self.index > index:
            self.pages.back()

    def skip_step(self) -> None:
        """Leave a step out, and say what is assumed then."""
        self._skipped[self.index] = skipped(f"Left out. Assumed: {self.step.if_skipped}.")
        self._show_results()
        self.pages.next()

    def close_or_cancel(self) -> None:
        """Cancel the job that runs; close where none does."""
        if self.board.job_running:
            self.board.cancel()
        else:
            self.close()

    def try_again(self) -> None:
        """Open the board anew and begin with the first step: what was found before is not in force."""
        self._show_failed(False)
        self.board.start()
        self.reset()
        self.go(0)
        self._show_opening()
        self.setFocus()

    def reset(self) -> None:
        """Forget results and notes of all steps."""
        self._skipped.clear()
        for step in self.steps:
            step.reset()
        self._show_results()

    def notes(self) -> Notes:
        """Return for every step but the last whether it is done, and what was found or is assumed."""
        return {
            step.name: (step.result is not None, step.result.words if step.result else step.if_skipped)
            for step in self.steps[:-1]
        }

    def show_recent(self, recent: Recent) -> None:
        if self.board.subject is not None and self.board.runner is not None:
            self.step.show_recent(recent)
            self.step.box.show_progress(*self.board.runner.progress)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Hand a board with other settings back stopped: its handle may stand inside a wall now."""
        if self.studio.link.state == "idle" and _changed(self.board.subject):
            self.studio.stop()
        super().closeEvent(event)

    # what happens

    def _entered(self) -> None:
        """Begin the step that has come into sight."""
        self.board.move_hand(None)
        for view in self.findChildren(HandleView):
            view.show_hand(None)
        self.list.setCurrentRow(self.index)
        self.step.enter()
        self._update_buttons()
        self._focus()

    def _focus(self) -> None:
        """Give the keyboard to Next where the step is done, or to the step's own button.

        Never to one that starts the motor: then to the page itself, where Enter does nothing.
        """
        if self.step.result is not None and self.step.result.good:
            (self.next if self.next.isVisibleTo(self) else self.close_button).setFocus()
            return
        own = [b for b in self.step.findChildren(QPushButton) if b.property("takes_focus")]
        (next((b for b in own if b.isVisibleTo(self)), self.step)).setFocus()

    def _show_opening(self) -> None:
        for step in self.steps:
            step.set_busy(True)
        self.steps[0].box.show_working("Starting the board…")
        self._update_buttons()

    def _opened(self, _subject: object) -> None:
        for step in self.steps:
            step.set_busy(False)
        self.step.enter()
        self._update_buttons()
        self._focus()

    def _job_started(self) -> None:
        """Give the keyboard to the E-stop while something runs."""
        self._update_buttons()
        self.stop.setFocus()

    def _job_ended(self, words: str = "") -> None:
        for step in self.steps:
            step.set_busy(self.board.busy)
        if words:
            self.step.show_refusal(words, _AFTER_STOP if self.studio.stopped else "")
        self._update_buttons()
        if not self.board.busy and self.stop.hasFocus():
            self._focus()

    def _failed(self, words: str) -> None:
        """Say it on every page; the only ways on are Try again and Close."""
        for step in self.steps:
            step.set_busy(True)
            step.box.show_text(words, "Motor off. Check the cable, then try again.", ("unplugged", "warn"))
        self._update_buttons()
        self._show_failed(True)
        self.again.setFocus()

    def _undone(self) -> None:
        """Begin again: nothing that was found is in force any more."""
        self.reset()
        self.go(0)
        words = "The board has its old settings again. Nothing is left to save."
        self.step.box.show_text(words, look=SIGNS[PASS])

    def _complete_changed(self) -> None:
        """Show what became of the steps, and go on with the keyboard where this one is done."""
        tried, work = self.direction_step, self.board.subject
        if tried.result is not None and work is not None and work.direction is None:
            tried.reset()  # what was changed since has reversed force or position
        self._show_results()
        self._update_buttons()
        if self.step.result is not None and self.step.result.good:
            self._focus()

    def _show_results(self) -> None:
        for index, step in enumerate(self.steps):
            result, row = step.result or self._skipped.get(index), self.list.item(index)
            words = result.words if result is not None else "not done yet"
            sign, color = SIGNS.get(result.level, NEUTRAL) if result is not None else NEUTRAL
            row.setIcon(icons.icon(sign, color, _ICON))
            row.setToolTip(words)
            row.setData(Qt.ItemDataRole.AccessibleTextRole, f"{step.name}: {words}")

    def _update_buttons(self) -> None:
        """Offer what can be done now, and say what Skip means."""
        step, busy = self.step, self.board.busy
        last, done = step is self.save_step, step.result is not None and step.result.good
        step.hint.setText("" if done or last else f"If skipped, the studio assumes: {step.if_skipped}.")
        self.list.setEnabled(not busy)
        self.next.setEnabled(step.isComplete())
        self.back.setEnabled(self.index > 0 and not busy)
        self.skip.setVisible(not last)
        self.skip.setEnabled(not busy)
        self.close_button.setText("Cancel" if self.board.job_running else "Close")

    def _show_failed(self, failed: bool) -> None:
        """Offer to try again after a failure, or the steps."""
        buttons = [_AGAIN] if failed else [_SKIP, _BACK, _NEXT]
        self.pages.setButtonLayout([_CLOSE, _SPACE, *buttons])
        self.again.setVisible(failed)

    # putting together

    def _make_button(self, which: QWizard.WizardButton, words: str) -> QPushButton:
        button = QPushButton(words)
        button.setAutoDefault(False)
        self.pages.setButton(which, button)
        self.pages.setButtonText(which, words)
        return button

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
        self.list.currentRowChanged.connect(self._choose)
        self.pages.currentIdChanged.connect(lambda _id: self._entered())
        self.pages.close_pressed.connect(self.close_or_cancel)
        self.skip.clicked.connect(self.skip_step)
        self.again.clicked.connect(self.try_again)
        self.board.opened.connect(self._opened)
        self.board.done.connect(lambda _result: self._job_ended())
        self.board.refused.connect(self._job_ended)
        self.board.failed.connect(self._failed)
        for step in self.steps:
            step.completeChanged.connect(self._complete_changed)
            step.job_started.connect(self._job_started)
        self.save_step.undone.connect(self._undone)
        self.connect_step.padding_chosen.connect(self.studio.device.set_padding)
        theme.changed.connect(self._show_results)

    def _choose(self, index: int) -> None:
        if index != self.index and not self.board.busy:
            self.go(index)


def _changed(work: Calibration | None) -> bool:
    """Return whether a calibration changed anything but the kit's name."""
    return work is not None and replace(of_settings(work.original), label=work.board.label) != work.board

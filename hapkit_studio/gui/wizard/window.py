"""Set up my Hapkit: seven steps on the board itself, each of which may be skipped."""

from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QHBoxLayout, QPushButton, QScrollArea, QStackedWidget, QWidget

from hapkit_studio.analysis.calibrate.calibration import Calibration
from hapkit_studio.analysis.calibrate.result import CheckResult, skipped
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.padding import measure_padding
from hapkit_studio.devices.profiles import of_settings
from hapkit_studio.devices.virtual_board import VirtualBoard
from hapkit_studio.gui.wizard.foot import Foot
from hapkit_studio.gui.wizard.page import Seen, StepPage
from hapkit_studio.gui.wizard.rail import Rail
from hapkit_studio.gui.wizard.shell import Shell
from hapkit_studio.gui.wizard.step_connect import ConnectStep
from hapkit_studio.gui.wizard.step_direction import DirectionStep
from hapkit_studio.gui.wizard.step_paddle import PaddleStep
from hapkit_studio.gui.wizard.step_save import SaveStep
from hapkit_studio.gui.wizard.step_scale import ScaleStep
from hapkit_studio.gui.wizard.step_sensor import SensorStep
from hapkit_studio.gui.wizard.step_strength import StrengthStep
from hapkit_studio.gui.wizard.steps_list import StepsList

if TYPE_CHECKING:
    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.studio import Studio

TITLE = "Set up my Hapkit"
_NAMES = ("Connect", "Sensor", "Zero and scale", "Direction", "Strength", "Friction", "Save")
_DIRECTION = _NAMES.index("Direction")
_SIZE = (1060, 672)
_AFTER_STOP = "Press Release E-stop above, hands off, then begin this step again."
_SMALLEST = (860, 560)


def prepared(bench: "BoardRunner") -> Calibration:
    """Return a calibration on a bench; where a USB chip may hold frames back, what filling them gains."""
    work = Calibration(bench)
    if isinstance(bench.board, HapkitBoard) and not isinstance(bench.board, VirtualBoard):
        work.padding = measure_padding(bench.board)
    return work


class WizardWindow(Shell):
    """Back, Next and Skip, or any step from the list; nothing runs without a button being pressed."""

    def __init__(self, studio: "Studio", parent: QWidget):
        super().__init__(TITLE, studio, prepared, parent)
        self.setMinimumSize(*_SMALLEST)
        self.resize(*_SIZE)
        self.connect_step, self.save_step = ConnectStep(self.desk), SaveStep(self.desk, self.notes)
        self.steps: list[StepPage] = [
            self.connect_step, SensorStep(self.desk), ScaleStep(self.desk), DirectionStep(self.desk),
            StrengthStep(self.desk), PaddleStep(self.desk), self.save_step,
        ]  # fmt: skip
        self._left: dict[int, CheckResult] = {}
        self.list, self.pages = StepsList(_NAMES), QStackedWidget()
        self._areas = [_scrolled(step) for step in self.steps]
        for area in self._areas:
            self.pages.addWidget(area)
        body = QHBoxLayout()
        body.setSpacing(0)
        body.addWidget(self.list)
        body.addWidget(self.pages, 1)
        self.column.addLayout(body, 1)
        self.foot = Foot()
        self.hint, self.skip, self.back, self.next = (
            self.foot.hint, self.foot.skip, self.foot.back, self.foot.next,
        )  # fmt: skip
        self.column.addWidget(self.foot)
        self._join()
        self.go(0)
        self._say_opening()

    # what a person does

    @property
    def step(self) -> StepPage:
        """Return the step in sight."""
        return self.steps[self.pages.currentIndex()]

    def go(self, index: int) -> None:
        """Show a step."""
        self.pages.setCurrentIndex(index)
        self.desk.lead(None)
        for rail in self.findChildren(Rail):
            rail.forget_hand()
        self.list.show_current(index)
        self.back.setEnabled(index > 0)
        last = index == len(self.steps) - 1
        self.next.setText("Close" if last else "Next")
        self.skip.setVisible(not last)
        self.step.enter()
        self._offer()
        self._focus()

    def _focus(self) -> None:
        """Give the keyboard to Next where the step is done, or to the step's own button.

        Never to one that starts the motor: then to the page itself, where Enter does nothing.
        """
        done = self.step.verdict is not None and self.step.verdict.good
        first = [
            b for b in self.step.findChildren(QPushButton) if b.property("first") and b.isVisibleTo(self)
        ]
        (self.next if done else first[0] if first else self.step).setFocus()

    def go_on(self) -> None:
        """Show the next step, or close after the last; what was not done is left out."""
        index = self.pages.currentIndex()
        if index == len(self.steps) - 1:
            self.close()
        elif self.step.verdict is None:
            self.skip_step()
        else:
            self.go(index + 1)

    def skip_step(self) -> None:
        """Leave a step out, and say what is assumed then."""
        index = self.pages.currentIndex()
        self._left[index] = skipped(f"Left out. Assumed: {self.step.assumed}.")
        self._changed()
        self.go(index + 1)

    def notes(self) -> dict[str, tuple[bool, str]]:
        """Return for every step but the last whether it is done, and what was found or is assumed."""
        return {
            name: (step.verdict is not None, step.verdict.words if step.verdict else step.assumed)
            for name, step in zip(_NAMES[:-1], self.steps[:-1], strict=True)
        }

    def show_seen(self, seen: Seen) -> None:
        if self.desk.subject is not None and self.desk.bench is not None:
            self.step.show_seen(seen)
            self.step.box.show_progress(*self.desk.bench.progress)

    # what happens

    def _say_opening(self) -> None:
        for step in self.steps:
            step.set_busy(True)
        self.steps[0].box.say("Starting the board…", "", "circle", "accent")

    def _opened(self, _subject: object) -> None:
        for step in self.steps:
            step.set_busy(False)
        self.step.enter()
        self._offer()
        self._focus()

    def _started(self) -> None:
        """While something runs, the keyboard has the E-stop."""
        self._offer()
        self._show_box()
        self.stop.setFocus()

    def _ended(self, words: str = "") -> None:
        for step in self.steps:
            step.set_busy(self.desk.busy)
        if words:
            self.step.show_refusal(words, _AFTER_STOP if self.studio.stopped else "")
        self._offer()
        self._show_box()
        if not self.desk.busy and self.stop.hasFocus():
            self._focus()

    def _show_box(self) -> None:
        """Bring what a step says into sight, once it has the room it needs."""
        area, box = self._areas[self.pages.currentIndex()], self.step.box
        QTimer.singleShot(0, box, lambda: area.ensureWidgetVisible(box, 0, 14))

    def _failed(self, words: str) -> None:
        """Say it on every page; the only ways on are Try again and Close."""
        for step in self.steps:
            step.set_busy(True)
            step.box.say(words, "Motor off. Check the cable, then try again.", "unplugged", "warn")
        self._offer()
        self.foot.show_failed(True)

    def try_again(self) -> None:
        """Open the board anew and begin with the first step: what was found before is not in force."""
        self.foot.show_failed(False)
        self.desk.again()
        self.withdraw_all()
        self.go(0)
        self._say_opening()
        self.setFocus()

    def withdraw_all(self) -> None:
        """Forget verdicts and notes of all steps."""
        self._left.clear()
        for step in self.steps:
            step.withdraw()
        self._changed()

    def _changed(self) -> None:
        """Show what became of the steps."""
        direction = self.steps[_DIRECTION]
        if direction.verdict is not None and self.desk.subject and self.desk.subject.direction is None:
            direction.withdraw()  # what was changed since has turned force or position round
        for index, step in enumerate(self.steps):
            self.list.show_verdict(index, step.verdict or self._left.get(index))
        self._offer()
        if self.step.verdict is not None and self.step.verdict.good:
            self._focus()

    def _offer(self) -> None:
        """Say beside the buttons what the next one means."""
        done = self.step.verdict is not None and self.step.verdict.good
        words = "" if done or self.step is self.steps[-1] else f"Skipped, it is assumed: {self.step.assumed}."
        self.hint.setText(words)
        self.list.setEnabled(not self.desk.busy)
        self.skip.setEnabled(not self.desk.busy)
        self.next.setEnabled(not self.desk.busy)
        self.back.setEnabled(self.pages.currentIndex() > 0 and not self.desk.busy)

    # putting together

    def _join(self) -> None:
        self.list.chosen.connect(self._choose)
        self.back.clicked.connect(lambda: self.go(self.pages.currentIndex() - 1))
        self.next.clicked.connect(self.go_on)
        self.skip.clicked.connect(self.skip_step)
        self.desk.opened.connect(self._opened)
        self.desk.done.connect(lambda _result: self._ended())
        self.desk.refused.connect(self._ended)
        self.desk.failed.connect(self._failed)
        for step in self.steps:
            step.changed.connect(self._changed)
            step.started.connect(self._started)
        self.foot.again.clicked.connect(self.try_again)
        self.foot.shut.clicked.connect(self.close)
        self.save_step.undone.connect(self._undone)
        self.connect_step.padding_wished.connect(self.studio.set_padding)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Hand a board with other settings back stopped: its handle may stand inside a wall now."""
        if self.studio.link.state == "idle" and _differs(self.desk.subject):
            self.studio.stop()
        super().closeEvent(event)

    def _undone(self) -> None:
        """Nothing that was found is in force any more: begin again."""
        self.withdraw_all()
        self.go(0)
        self.step.box.say("The board has its old settings again. Nothing is left to save.", "", "check", "ok")

    def _choose(self, index: int) -> None:
        if not self.desk.busy:
            self.go(index)


def _differs(work: Calibration | None) -> bool:
    """Return whether a calibration changed anything but the kit's name."""
    return work is not None and replace(of_settings(work.original), label=work.board.label) != work.board


def _scrolled(page: QWidget) -> QScrollArea:
    """Return a page that scrolls where the room is short."""
    area = QScrollArea()
    area.setWidgetResizable(True)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setWidget(page)
    page.setAutoFillBackground(False)
    area.viewport().setAutoFillBackground(False)
    return area

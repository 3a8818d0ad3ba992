"""What a step's page is: words, a picture, buttons, and one verdict."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.analysis.calibrate.calibration import NO_DIRECTION
from hapkit_studio.analysis.calibrate.result import CheckResult
from hapkit_studio.gui.pages.measuring import PRIMARY
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.wizard.verdict_box import VerdictBox

if TYPE_CHECKING:
    import numpy as np

    from hapkit_studio.analysis.calibrate.calibration import Calibration
    from hapkit_studio.gui.wizard.desk import Desk
    from hapkit_studio.gui.wizard.rail import Rail

BIG = "QLabel { font-size: 15px; }"


@dataclass(frozen=True)
class Seen:
    """What the board reports now: time s (n,), reading (n,), position m (n,), force N, for pictures."""

    time: "np.ndarray"
    raw: "np.ndarray"
    position: "np.ndarray"
    force: float


class StepPage(QWidget):
    """One step. ``changed``: finished, or no longer; ``started``: a job; assumed: what holds if skipped."""

    changed = Signal()
    started = Signal()
    title, assumed = "", ""
    needs_direction = False

    def __init__(self, desk: "Desk", parent: QWidget | None = None):
        super().__init__(parent)
        self.desk = desk
        self.verdict: CheckResult | None = None
        self.box = VerdictBox()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(24, 18, 24, 14)
        self.column.setSpacing(12)
        heading = QLabel(self.title)
        dress(heading, "QLabel { font-size: 22px; font-weight: 650; }")
        self.column.addWidget(heading)

    @property
    def subject(self) -> "Calibration":
        """Return the calibration under way."""
        return self.desk.subject

    @property
    def directed(self) -> bool:
        """Say whether the direction was tried, and force and position agree."""
        subject = self.desk.subject
        return subject is not None and subject.direction is not None and bool(subject.direction.agrees)

    # what a step declares

    def enter(self) -> None:
        """Come into sight."""
        if self.needs_direction and self.verdict is None and self.desk.subject is not None:
            if self.directed:
                self.box.say("The motor is off until you press a button.")
            else:
                self.box.say(NO_DIRECTION, "", "triangle", "warn")

    def show_seen(self, seen: Seen) -> None:
        """Draw what the board reports now; twenty times a second while in sight."""

    def withdraw(self) -> None:
        """Forget what was found: it holds no longer."""
        self.verdict = None
        self.box.say("Not done yet. The motor is off.")

    # what a step uses

    def say(self, words: str) -> None:
        """Add words on what to do."""
        label = QLabel(words)
        label.setWordWrap(True)
        dress(label, BIG)
        self.column.addWidget(label)

    def row(self, *parts: QWidget, stretch: bool = True) -> QHBoxLayout:
        """Add parts side by side."""
        row = QHBoxLayout()
        row.setSpacing(10)
        for part in parts:
            row.addWidget(part)
        if stretch:
            row.addStretch(1)
        self.column.addLayout(row)
        return row

    def pictures(self, drawing: QWidget, rail: QWidget) -> None:
        """Add a drawing with the rail beside it; they take the room there is."""
        row = QHBoxLayout()
        row.setSpacing(10)
        row.addWidget(drawing, 1)
        row.addWidget(rail, 1)
        self.column.addLayout(row, 1)

    def with_hand(self, rail: "Rail") -> "Rail":
        """Let the rail move the hand of a board that has one."""
        rail.led.connect(self.desk.lead)
        self.desk.opened.connect(lambda _subject: rail.show_hand(self.desk.hand_is_ours))
        return rail

    def button(
        self, words: str, press: Callable[[], object], primary: bool = False, motor: bool = False
    ) -> QPushButton:
        """Return a button of the step; one that starts the motor never gets the keyboard by itself."""
        made = QPushButton(words)
        made.setProperty("tall", True)
        made.setAutoDefault(False)
        made.setProperty("first", primary and not motor)
        made.setProperty("motor", motor)
        made.clicked.connect(lambda: press())
        dress(made, PRIMARY + "QPushButton { font-size: 14px; }" if primary else "* { font-size: 14px; }")
        return made

    def do(self, words: str, job: Callable[["Calibration"], object], after: Callable[..., object]) -> bool:
        """Hand the thread a job, say meanwhile what it does, then call after(result)."""
        if not self.desk.start(job, after):
            return False
        self.box.say(words, "", "circle", "accent")
        self.set_busy(True)
        self.started.emit()
        return True

    def show_verdict(self, verdict: CheckResult) -> None:
        """Show and keep what the step found."""
        self.verdict = verdict
        self.box.show_verdict(verdict)
        self.changed.emit()

    def show_refusal(self, words: str, remedy: str = "") -> None:
        """Show why a job ended, and what to do."""
        self.box.say(words, remedy, "triangle", "warn")

    def set_busy(self, busy: bool) -> None:
        """Let buttons rest while a job runs."""
        for button in self.findChildren(QPushButton):
            if not button.property("always"):
                waits = self.needs_direction and bool(button.property("motor")) and not self.directed
                button.setEnabled(not busy and not waits)

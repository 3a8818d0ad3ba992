"""A dialog that uses the board in place of the loop. It has an E-stop, and Esc stops the motor."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, QTimer, SignalInstance
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import QDialog, QFrame, QProgressBar, QPushButton, QWidget

from hapkit_studio.analysis.calibrate.result import FAIL, PASS, SKIP, WARN, CheckResult
from hapkit_studio.devices.board_runner import motor_force
from hapkit_studio.devices.profiles import readings
from hapkit_studio.gui.panel.stop_button import StopButton
from hapkit_studio.gui.widgets.parts import Sign, hbox, keep_size_when_hidden, label, vbox
from hapkit_studio.gui.widgets.style import mark
from hapkit_studio.gui.wizard.board_thread import BoardThread

if TYPE_CHECKING:
    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.state.studio import Studio

FRAME_MS = 50
NEUTRAL = ("circle", "ink3")
SIGNS = {PASS: ("check", "ok"), WARN: ("triangle", "warn"), FAIL: ("triangle", "danger"), SKIP: NEUTRAL}
"""Icon and colour token for each level of a result."""
LONG_SECONDS = 5.0
"""s: a run that takes at least this long shows its progress."""
_EVERY = 5
"""Every n-th sample is drawn, where n is this number."""


@dataclass(frozen=True)
class Recent:
    """The last ten seconds of a board: time in s (n,), reading (n,), position in m (n,), force in N."""

    time: np.ndarray
    raw: np.ndarray
    position: np.ndarray
    force: float


class BoardDialog(QDialog):
    """A non-modal dialog that takes the board from the loop, and returns it when the dialog is closed."""

    title = ""

    def __init__(self, studio: "Studio", parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("boardDialog")
        self.setWindowTitle(self.title)
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.studio = studio
        entry = studio.entry
        assert entry is not None
        self.board = BoardThread(entry.make, self.prepare, self)
        self.stop, self.release = StopButton(studio), QPushButton("Release E-stop")
        self.released = False  # True if the user has released the E-stop in this dialog
        self.close_button = QPushButton("Close")
        self.close_button.clicked.connect(self.close_or_cancel)
        self.column = vbox(self._header(), into=self)
        self._frames = QTimer(self, interval=FRAME_MS)
        self._frames.timeout.connect(self._show_frame)
        studio.stop_changed.connect(self._stop_changed)
        studio.link_changed.connect(self._link_changed)
        self._stop_changed()

    @classmethod
    def open_over(cls, studio: "Studio", window: QWidget, closed: SignalInstance) -> "BoardDialog":
        """Open a dialog, which the signal ``closed`` closes, or bring an open board dialog to the front."""
        for dialog in window.findChildren(BoardDialog):
            if dialog.isVisible():
                dialog.raise_()
                dialog.activateWindow()
                return dialog
        made = cls(studio, window)
        closed.connect(made.close)
        made.show()
        made.begin()
        return made

    # methods for subclasses

    @staticmethod
    def prepare(runner: "BoardRunner") -> Any:
        """Return the argument of every job; the board's thread calls this when the board is open."""
        return runner

    def show_recent(self, recent: Recent) -> None:
        """Draw the board's samples; this is called twenty times per second."""

    # the board

    def begin(self) -> None:
        """Take the board from the loop."""
        self.studio.device.release_port(self.windowTitle())
        self.setFocus()  # the E-stop must not have the focus, because an accidental Enter would latch it
        self.board.start()
        self._frames.start()

    def close_or_cancel(self) -> None:
        """Cancel the running job, or close the dialog."""
        if self.board.job_running:
            self.board.cancel()
        else:
            self.close()

    def _show_frame(self) -> None:
        runner = self.board.runner
        samples = list(runner.recent) if runner is not None else []
        if runner is None or not samples:
            return
        # drawing every sample would delay the thread that answers the board
        shown = samples[(len(samples) - 1) % _EVERY :: _EVERY]
        clock, raw, count = np.array([(s.time_us, s.raw, s.count) for s in shown]).T
        time = 1e-6 * np.cumsum(np.diff(clock, prepend=clock[0]) % 2**32)
        force = float(motor_force(runner.settings, np.array([samples[-1].pwm]))[0])
        position = count * runner.settings.quantum
        self.show_recent(Recent(time, readings(raw, runner.settings.sensor), position, force))

    def _release(self) -> None:
        """Release the E-stop for the board in this dialog, and for the loop that uses the board later."""
        self.released = True
        # the user has released the E-stop, so the loop does not wait for Render
        self.studio.stop_state.restored = False
        self.studio.release_stop()

    def _stop_changed(self) -> None:
        self.release.setVisible(self.studio.stopped)
        if self.studio.stopped:
            self.released = False
            self.board.stop()
        else:
            self.board.release()

    def _link_changed(self) -> None:
        """Release the board if the user has chosen another device."""
        if self.studio.link.state != "idle" and self.isVisible():
            self.close()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Stop the motor on Esc; on Enter press only the focused button.

        Neither a typed number nor key repeat may start the motor.
        """
        if event.key() == Qt.Key.Key_Escape:
            self.studio.stop()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            focused = self.focusWidget()
            if isinstance(focused, QPushButton) and not event.isAutoRepeat():
                focused.click()
        else:
            super().keyPressEvent(event)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Switch the motor off and return the board to the loop."""
        self._frames.stop()
        self.board.end()
        self.studio.stop_changed.disconnect(self._stop_changed)
        self.studio.link_changed.disconnect(self._link_changed)
        if self.studio.link.state == "idle":
            self.studio.device.reconnect()
        super().closeEvent(event)

    def _header(self) -> QWidget:
        header = QWidget()
        header.setObjectName("boardDialogHeader")
        header.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        header.setFixedHeight(56)
        self.release.setProperty("tall", True)
        self.release.clicked.connect(self._release)
        for button in (self.release, self.stop):
            button.setAutoDefault(False)
        title = label(self.title, "title")
        hbox((title, 1), self.release, self.stop, into=header, margins=(24, 0, 12, 0), gap=12)
        return header


class ResultBox(QFrame):
    """Shows an icon, the result and its remedy; a progress bar is at the bottom."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("resultBox")
        self.sign, self.label, self.remedy = Sign(22), label(role="headline"), label()
        self.bar = QProgressBar()
        self.bar.setFixedHeight(5)
        self.bar.setAccessibleName("Progress")
        keep_size_when_hidden(self.bar)
        self.bar.hide()
        text = vbox(None, self.label, self.remedy, None, gap=4)
        vbox((hbox(self.sign, (text, 1), gap=12), 1), self.bar, into=self, margins=(14, 7, 14, 4), gap=2)
        self.setMinimumHeight(66)  # two lines are reserved, so that most results do not move other widgets

    def show_text(self, text: str, remedy: str = "", sign: tuple[str, str] = NEUTRAL) -> None:
        """Show text and remedy with an icon and its colour."""
        self.label.setText(text)
        self.remedy.setText(remedy)
        self.remedy.setVisible(bool(remedy))
        self.sign.show_sign(*sign)
        mark(self, "tone", sign[1])
        self.setAccessibleName(f"{text} {remedy}".strip())

    def show_result(self, result: CheckResult) -> None:
        """Show the result of a check."""
        self.show_text(result.text, result.remedy, SIGNS[result.level])

    def show_warning(self, text: str, remedy: str = "") -> None:
        """Show a problem and its remedy."""
        self.show_text(text, remedy, SIGNS[WARN])

    def show_working(self, text: str) -> None:
        """Show what the board is doing now."""
        self.show_text(text, "", ("circle", "accent"))

    def show_progress(self, passed: float, seconds: float) -> None:
        """Show the progress of a run of ``seconds``; a short or endless run shows no progress."""
        shown = LONG_SECONDS <= seconds < math.inf
        if shown:
            self.bar.setValue(round(100 * passed / seconds))
        self.bar.setVisible(shown)

"""A window that has the board for itself: E-stop in its corner, Esc stops, closing lets go."""

from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QCloseEvent, QKeyEvent
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from hapkit_studio.devices.board_runner import motor_force
from hapkit_studio.devices.profiles import readings
from hapkit_studio.gui.header import StopButton
from hapkit_studio.gui.widgets.style import dress
from hapkit_studio.gui.widgets.theme import theme
from hapkit_studio.gui.wizard.desk import Desk
from hapkit_studio.gui.wizard.page import Seen

if TYPE_CHECKING:
    from collections.abc import Callable

    from hapkit_studio.devices.board_runner import BoardRunner
    from hapkit_studio.gui.studio import Studio

FRAME_MS = 50
_EVERY = 5
"""Of so many samples pictures show one."""
_SHEET = """
#shellTop { background: @side; border-bottom: 1px solid @line; }
#shellFoot { background: @side; border-top: 1px solid @line; }
#shell { background: @surface; }
"""


class Shell(QDialog):
    """Takes the board over from the loop while it is open, and hands it back. Never blocks the window."""

    def __init__(
        self, title: str, studio: "Studio", prepared: "Callable[[BoardRunner], Any]", parent: QWidget
    ):
        super().__init__(parent)
        self.setObjectName("shell")
        self.setWindowTitle(title)
        self.setModal(False)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.studio = studio
        entry = studio.entry
        assert entry is not None
        self.desk = Desk(entry.make, prepared, self)
        self.stop, self.release = StopButton(studio), QPushButton("Release E-stop")
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(0)
        self.column.addWidget(self._top(title))
        dress(self, _SHEET)
        self._frames = QTimer(self, interval=FRAME_MS)
        self._frames.timeout.connect(self._look)
        studio.stop_changed.connect(self._stop_changed)
        studio.link_changed.connect(self._link_changed)
        self._stop_changed()

    def begin(self) -> None:
        """Take the board over."""
        self.studio.let_go(self.windowTitle())
        self.setFocus()  # not the E-stop: an Enter too many would latch it
        self.desk.begin()
        self._frames.start()

    def show_seen(self, seen: Seen) -> None:
        """Draw what the board reports now."""

    def _top(self, title: str) -> QWidget:
        top = QWidget()
        top.setObjectName("shellTop")
        top.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        top.setFixedHeight(56)
        words = QLabel(title)
        words.setFont(theme.font("title"))
        self.release.setProperty("tall", True)
        self.release.setAutoDefault(False)
        self.release.clicked.connect(self.studio.release_stop)
        self.stop.setAutoDefault(False)
        row = QHBoxLayout(top)
        row.setContentsMargins(24, 0, 12, 0)
        row.setSpacing(12)
        row.addWidget(words, 1)
        row.addWidget(self.release)
        row.addWidget(self.stop)
        return top

    def _look(self) -> None:
        bench = self.desk.bench
        if bench is None:
            return
        samples = self.desk.samples()
        if not samples:
            return
        # every sample would cost the thread that answers them its time
        shown = samples[(len(samples) - 1) % _EVERY :: _EVERY]
        clock, raw, count = np.array([(s.time_us, s.raw, s.count) for s in shown]).T
        time = 1e-6 * np.cumsum(np.diff(clock, prepend=clock[0]) % 2**32)
        force = float(motor_force(bench.settings, np.array([samples[-1].pwm]))[0])
        raw = readings(raw, bench.settings.sensor)
        self.show_seen(Seen(time, raw, count * bench.settings.quantum, force))

    def _stop_changed(self) -> None:
        stopped = self.studio.stopped
        self.release.setVisible(stopped)
        if stopped:
            self.desk.stop()
        else:
            self.desk.release()

    def _link_changed(self) -> None:
        """Leave the board to another device that was chosen meanwhile."""
        if self.studio.link.state != "idle" and self.isVisible():
            self._let_go()
            self.close()

    def _let_go(self) -> None:
        self._frames.stop()
        self.desk.end()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.studio.stop()
            return
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            # only what has the focus: a number that is typed must not start the motor, nor a key held down
            focused = self.focusWidget()
            if isinstance(focused, QPushButton) and not event.isAutoRepeat():
                focused.click()
            return
        super().keyPressEvent(event)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Motor off, and the board back to the loop."""
        self._let_go()
        for changed, slot in (
            (self.studio.stop_changed, self._stop_changed),
            (self.studio.link_changed, self._link_changed),
        ):
            changed.disconnect(slot)
        if self.studio.link.state == "idle":
            self.studio.reconnect()
        super().closeEvent(event)

"""A dialog on a simulated kit in this process, operated as by a student."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.errors import NoDataError
from hapkit_studio.gui.state.studio import Studio
from tests.analysis.calibrate import student
from tests.devices.paddle_kit import PaddleKit
from tests.gui.window_support import PATIENCE_MS, SIMULATED

PACE = 2e-5
"""Real time in s per period of the kit, so that the kit's thread leaves processor time to the window."""


def no_engine(_entry):
    """Prevent the window from starting a loop on a kit that a dialog returns."""
    raise NoDataError("Nobody renders on the bench.")


class Bench(QWidget):
    """Substitute for the window: it has the interface that a dialog needs and opens faster."""

    closed = Signal()

    def __init__(self):
        super().__init__()
        self.studio = Studio(lambda: [SIMULATED], no_engine)


class Played:
    """A dialog (set-up or test) on a kit, inside a window that has released its device."""

    def __init__(self, kind, window, qtbot, kit=None, **truth):
        self.kit = kit or PaddleKit(pace=PACE, **truth)
        self.qtbot, self.window = qtbot, window
        window.studio.device.entry = DeviceEntry("kit", "Hapkit on test", lambda: self.kit)
        self.dialog = kind.open_over(window.studio, window, window.closed)
        self.wait()

    def wait(self):
        """Wait until no job runs."""
        board = self.dialog.board
        self.qtbot.waitUntil(lambda: board.runner is not None and not board.busy, timeout=PATIENCE_MS)

    def press(self, button):
        """Press a button and wait for its job."""
        assert button.isEnabled()
        button.click()
        self.wait()

    def lead(self, place):
        """Move the handle to a position in m and hold it there."""
        student.lead(self.kit, place)
        self.qtbot.waitUntil(lambda: abs(self.kit.x - place) < 1e-9, timeout=PATIENCE_MS)

    def end_to_end(self):
        """Move the handle from end to end from now on."""
        student.swing(self.kit)

    def let_go(self):
        """Let go of the handle in the middle."""
        self.lead(0.0)
        student.leave(self.kit)

    def direct(self):
        """Run the direction test, which Strength and Friction require."""
        self.let_go()
        self.dialog.go(3)
        self.press(self.dialog.step.push)
        assert self.dialog.step.result.good

    def hang(self, mass):
        """Hang a mass in kg on the handle; the hand lets go 1.2 s after the motor begins to carry it."""
        self.lead(0.0)
        student.hang(self.kit, mass)

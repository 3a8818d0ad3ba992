"""A dialog on a kit in this process: opened, its buttons pressed as a student does."""

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.errors import NoDataError
from hapkit_studio.gui.state.studio import Studio
from tests.analysis.calibrate import student
from tests.devices.paddle_kit import PaddleKit
from tests.gui.window_support import PATIENCE_MS, SIMULATED

PACE = 2e-5
"""s that a period of the kit takes, so that its thread leaves the window some time."""


def no_engine(_entry):
    """Build no loop on a kit that was handed back."""
    raise NoDataError("Nobody renders on the bench.")


class Bench(QWidget):
    """Stands for the window, of which a dialog knows no more; it costs less to open."""

    closed = Signal()

    def __init__(self):
        super().__init__()
        self.studio = Studio(lambda: [SIMULATED], no_engine)


class Played:
    """A dialog (set-up or test) over a kit, inside a window that has let go of its device."""

    def __init__(self, kind, window, qtbot, kit=None, **truth):
        self.kit = kit or PaddleKit(pace=PACE, **truth)
        self.qtbot, self.window = qtbot, window
        window.studio.device.entry = DeviceEntry("kit", "Hapkit on test", lambda: self.kit)
        self.dialog = kind.open_over(window.studio, window, window.closed)
        self.wait()

    def wait(self):
        """Wait until nothing runs."""
        board = self.dialog.board
        self.qtbot.waitUntil(lambda: board.runner is not None and not board.busy, timeout=PATIENCE_MS)

    def press(self, button):
        """Press a button and wait for what it began."""
        assert button.isEnabled()
        button.click()
        self.wait()

    def lead(self, place):
        """Lead the handle to a place in m and hold it there."""
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
        """Have the direction tried, which Strength and Friction wait for."""
        self.let_go()
        self.dialog.go(3)
        self.press(self.dialog.step.push)
        assert self.dialog.step.result.good

    def hang(self, mass):
        """Hold the handle with a mass in kg on it, and let go a second after it is carried."""
        self.lead(0.0)
        student.hang(self.kit, mass)

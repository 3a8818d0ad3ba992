"""A dialog on a kit in this process: opened, its buttons pressed as a student does."""

import math

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.gui.studio import Studio
from tests.devices.paddle_kit import PaddleKit
from tests.gui.window_support import PATIENCE_MS, SIMULATED, build_engine

PACE = 2e-5
"""s that a period of the kit takes, so that its thread leaves the window some time."""


class Bench(QWidget):
    """Stands for the window, of which a dialog knows no more; it costs less to open."""

    closed = Signal()

    def __init__(self):
        super().__init__()
        self.studio = Studio(lambda: [SIMULATED], build_engine)


class Played:
    """A dialog (set-up or test) over a kit, inside a window that has let go of its device."""

    def __init__(self, kind, window, qtbot, kit=None, **truth):
        self.kit = kit or PaddleKit(pace=PACE, **truth)
        self.qtbot, self.window = qtbot, window
        window.studio.device.entry = DeviceEntry("kit", "Hapkit on test", lambda: self.kit)
        self.dialog = kind.open_over(window)
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

    def lead(self, place, seconds=0.3):
        """Lead the handle to a place in m and hold it there."""
        kit, start, begin = self.kit, self.kit.x, self.kit.time

        def leading(k):
            k.hand = start + (place - start) * min((k.time - begin) / seconds, 1.0)

        kit.student = leading
        self.qtbot.waitUntil(lambda: abs(kit.x - place) < 1e-9, timeout=PATIENCE_MS)

    def end_to_end(self, seconds=5.0):
        """Move the handle from end to end from now on."""
        begin = self.kit.time
        self.kit.student = lambda k: setattr(
            k, "hand", -0.048 * math.cos(2.0 * math.pi * (k.time - begin) / seconds)
        )

    def let_go(self):
        """Let go of the handle in the middle."""
        self.lead(0.0)
        self.kit.student, self.kit.hand = (lambda k: None), None

    def direct(self):
        """Have the direction tried, which Strength and Friction wait for."""
        self.let_go()
        self.dialog.go(3)
        self.press(self.dialog.step.push)
        assert self.dialog.step.result.good

    def hang(self, mass):
        """Hold the handle with a mass in kg on it, and let go after a second."""
        self.lead(0.0)
        kit, begin = self.kit, []
        kit.weight = -9.81 * mass

        def lets_go(k):
            if k.forces[-1] != 0.0 and not begin:
                begin.append(k.time)
            k.hand = None if begin and k.time > begin[0] + 1.2 else 0.0

        kit.student = lets_go

"""The real window, offscreen, with its loop running, for benchmarks of the whole program."""

import math
import os
import time
from collections.abc import Callable

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from hapkit_studio.arguments import window_parser
from hapkit_studio.gui.shell import app
from hapkit_studio.gui.shell.window import MainWindow

FRAME_MS = 16


def open_window(*arguments: str) -> tuple[QApplication, MainWindow]:
    """Return application and window once rows arrive from the loop; raise TimeoutError after two minutes."""
    application = QApplication.instance() or QApplication(["bench"])
    options = window_parser().parse_args(list(arguments))
    window = app.build(options)
    window.show()
    app.begin(window, options)
    process_until(application, lambda: window.live.last is not None, 120.0)
    return application, window


def process_until(application: QApplication, condition: Callable[[], bool], seconds: float) -> None:
    """Run the event loop until a condition holds; raise TimeoutError after ``seconds``."""
    end = time.perf_counter() + seconds
    while not condition():
        application.processEvents()
        time.sleep(1e-3)
        if time.perf_counter() > end:
            raise TimeoutError(f"nothing came within {seconds:g} s")


def keep_busy(window: MainWindow) -> QTimer:
    """Move the hand and repaint everything, sixty times per second."""
    timer = QTimer(window, interval=FRAME_MS)
    timer.setTimerType(window.live._frames.timerType())

    def step() -> None:
        window.studio.move_hand(0.012 * math.sin(2.0 * math.pi * 0.7 * time.perf_counter()))
        window.update()

    timer.timeout.connect(step)
    timer.start()
    return timer

"""What the jitter that the running loop recorded costs in stiffness, asked for by a button."""

import math
import time
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QPushButton, QScrollArea, QWidget

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import irregular
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.background import Job
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.parts import down, label
from hapkit_studio.haptics.engine import COMPUTER

SECONDS = 10.0
"""So long a loop has to run before anything is said of its jitter."""
_TIP = "By the last 10 minutes, the computer rendering. Not for objects, nor a filter that is not linear."


def said(setting: Setting, damping: float, lateness: np.ndarray, simulated: bool) -> str:
    """Return in a sentence what a lateness (n,) in s costs; raise ParameterError where it is too short.

    The delay that was measured on a real line is a mean, in which the lateness is.
    """
    missing = SECONDS - lateness.size / setting.rate
    if missing > 0.0:
        raise ParameterError(f"Ask again in {math.ceil(missing)} s: the loop has just begun.")
    if simulated:
        found = irregular.cost(setting, damping, lateness)
        return f"On a real Hapkit this jitter would cost {found.words}. The simulated one is not late."
    on_time = replace(setting, delay=max(setting.delay - float(lateness.mean()), 0.0))
    return f"This loop's jitter costs {irregular.cost(on_time, damping, lateness).words}."


class LoopJitter(QWidget):
    """A button and a line; what it says holds for one loop and one damping, and goes with them."""

    def __init__(self, studio: Studio, column: QScrollArea):
        """column: where it is to be seen when it says something."""
        super().__init__()
        self._studio, self._column = studio, column
        self._since = 0.0
        self._about: tuple[Setting, float] | None = None
        self.button, self.words = QPushButton("What does it cost?"), label()
        self.button.setToolTip(_TIP)
        self.job = Job(self, needs="verdict")
        down(self.button, self.words, into=self, gap=8)
        self.button.clicked.connect(self.ask)
        self.job.running_changed.connect(self._look)
        self.job.finished.connect(self._say)
        self.job.failed.connect(self._say)
        for signal in (studio.engine_changed, studio.loop_changed):
            signal.connect(self._begin_anew)
        self._begin_anew()
        self._say("")

    def follow(self, about: tuple[Setting, float] | None) -> None:
        """Take over the loop and the damping in N·s/m that are shown, None for none."""
        if about != self._about:
            self._about = about
            self.job.cancel()
            self._say("")
        self._look()

    def ask(self) -> None:
        """Compute what the loop's jitter costs."""
        if self._about is not None:
            about, since, studio = self._about, self._since, self._studio
            read, simulated = studio.recording.lateness, studio.simulated
            self.job.start(lambda _progress: said(*about, read(since), simulated))

    def _say(self, text: str) -> None:
        self.words.setText(text)
        self.words.setVisible(bool(text))
        if text:  # it has its place a moment later
            QTimer.singleShot(0, lambda: self._column.ensureWidgetVisible(self))

    def _begin_anew(self) -> None:
        self._since = time.perf_counter()

    def _look(self) -> None:
        engine, about = self._studio.engine, self._about
        possible = engine is not None and engine.rendering == COMPUTER
        possible = possible and about is not None and about[0].linear
        self.button.setEnabled(possible and not self.job.running)

"""What the jitter that the running loop recorded costs in stiffness, asked for by a button."""

import math
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QPushButton, QWidget

from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.stability import irregular
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.background import Job
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.widgets.parts import down, label
from hapkit_studio.haptics.engine import COMPUTER

SECONDS = 10.0
"""So long a loop has to run before anything is said of its jitter."""
_ABOUT = (
    "What the samples of the last 10 minutes cost by coming late, while the computer renders: in the limit "
    "of a spring, so not for objects, nor for a velocity filter that is not linear"
)
ASK, ASKING = "What does it cost?", "Computing…"


def said(setting: Setting, damping: float, lateness: np.ndarray, simulated: bool) -> str:
    """Return in a sentence what a lateness (n,) in s costs; raise ParameterError where it is too short.

    The delay that was measured on a real line is a mean, in which the lateness is.
    """
    seconds = lateness.size / setting.rate
    if seconds < SECONDS:
        raise ParameterError(f"Ask again in {math.ceil(SECONDS - seconds)} s: the loop has just begun.")
    if simulated:
        found = irregular.cost(setting, damping, lateness)
        return f"On a real Hapkit this jitter would cost {found.words}. The simulated one is not late."
    on_time = replace(setting, delay=max(setting.delay - float(lateness.mean()), 0.0))
    return f"This loop's jitter costs {irregular.cost(on_time, damping, lateness).words}."


class LoopJitter(QWidget):
    """A button and a line; what it says holds for one loop and one damping, and goes with them.

    Emits ``told`` when the line is there.
    """

    told = Signal()

    def __init__(self, studio: Studio):
        super().__init__()
        self._studio = studio
        self._since = time.perf_counter()
        self._about: tuple[Setting, float] | None = None
        self.button, self.words = QPushButton(ASK), label()
        self.button.setToolTip(_ABOUT)
        self.job = Job(self, needs="verdict")
        down(self.button, self.words, into=self, gap=8)
        self._say("")
        self.button.clicked.connect(self.ask)
        self.job.running_changed.connect(self._look)
        self.job.finished.connect(self._say)
        self.job.failed.connect(self._say)
        for signal in (studio.engine_changed, studio.loop_changed):
            signal.connect(self._begin_anew)

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
            read: Callable[[float], np.ndarray] = self._studio.recording.lateness
            about, since, simulated = self._about, self._since, self._studio.simulated
            self.job.start(lambda _progress: said(*about, read(since), simulated))

    def _say(self, text: str) -> None:
        self.words.setText(text)
        self.words.setVisible(bool(text))
        if text:  # once it has its place
            QTimer.singleShot(0, self.told.emit)

    def _begin_anew(self) -> None:
        self._since = time.perf_counter()

    def _look(self) -> None:
        engine, about = self._studio.engine, self._about
        possible = engine is not None and engine.rendering == COMPUTER
        self.button.setEnabled(possible and about is not None and about[0].linear and not self.job.running)
        self.button.setText(ASKING if self.job.running else ASK)

"""A hand that moves by itself so that every term shows: slow and fast, far and near, both ways."""

import math
import time
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, QTimer, Signal

if TYPE_CHECKING:
    from hapkit_studio.gui.studio import Studio

_STEP_MS = 8
# m, Hz, rad: no small common period, so that the sensor's steps fall otherwise each time
_SINES = ((0.0085, 0.83, 0.0), (0.0045, 2.37, 1.0), (0.0020, 4.91, 2.0))
_INTO_SURFACE = 0.003


class Shake(QObject):
    """Moves the hand for some seconds, then lets go; ``finished(True)`` unless it was ended before."""

    finished = Signal(bool)

    def __init__(self, studio: "Studio", parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self._begin, self._seconds = 0.0, 0.0
        self._timer = QTimer(self, interval=_STEP_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._move)

    @property
    def running(self) -> bool:
        """Say whether the hand moves."""
        return self._timer.isActive()

    def start(self, seconds: float) -> None:
        """Begin to move."""
        self._begin, self._seconds = time.perf_counter(), seconds
        self._timer.start()

    def end(self) -> None:
        """Let go now."""
        if self.running:
            self._timer.stop()
            self._studio.move_hand(None)
            self.finished.emit(False)

    def target(self, t: float) -> float:
        """Return where the hand is after t s, in m: about the surface, where there is one."""
        values = self._studio.values
        place = values.get("position", values.get("center", 0.0))
        if self._studio.environment.shades and "position" in values:
            place += _INTO_SURFACE if values.get("side", 0.0) == 0.0 else -_INTO_SURFACE
        soft = min(t / 0.3, 1.0)
        return place + soft * sum(a * math.sin(2.0 * math.pi * f * t + p) for a, f, p in _SINES)

    def _move(self) -> None:
        t = time.perf_counter() - self._begin
        if t >= self._seconds:
            self._timer.stop()
            self._studio.move_hand(None)
            self.finished.emit(True)
        else:
            self._studio.move_hand(self.target(t))

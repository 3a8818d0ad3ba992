"""The frame timer: sixty times per second it moves rows from the loop's ring to history, scene and plots."""

import math
import time
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject, Qt, QTimer, Signal

from hapkit_studio.gui.live.history import LiveHistory
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.haptics import rows

if TYPE_CHECKING:
    from hapkit_studio.haptics.rows import RingReader

FRAME_MS = 16
HIDDEN_MS = 200
HEALTH_MS = 500
HISTORY_SECONDS = 60.0


class Live(QObject):
    """Drains the ring without waiting.

    Emits ``frame(row, clamped)`` for each frame, and ``health`` at 2 Hz.
    """

    frame = Signal(object, bool)
    health = Signal(object)
    paused_changed = Signal(bool)
    replay_wanted = Signal(object)
    """Emitted with the path of a session to be replayed."""

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self._reader: RingReader | None = None
        self._device = ""
        self._changing = False
        self.history = LiveHistory(HISTORY_SECONDS)
        self.paused = self.replaying = False
        self.hidden = False
        self.lost = 0
        self.last: np.ndarray | None = None
        self._frames = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._frames.timeout.connect(self.tick)
        self._health = QTimer(self, interval=HEALTH_MS)
        self._health.timeout.connect(self.refresh)
        studio.engine_changed.connect(self._follow)
        studio.environment_changed.connect(self._divide)
        for changed in (studio.settings_changed, studio.hidden_changed, studio.engine_changed):
            changed.connect(self._note_change)

    def start(self) -> None:
        """Start the timers; the window calls this once it is shown."""
        self._frames.start()
        self._health.start()

    def stop(self) -> None:
        """Stop the timers permanently, before the engine closes."""
        self._frames.stop()
        self._health.stop()

    def set_hidden(self, hidden: bool) -> None:
        """While the window is hidden, only drain the ring, and do so at a low rate."""
        self._frames.setInterval(HIDDEN_MS if hidden else FRAME_MS)
        self.hidden = hidden

    def toggle_paused(self) -> None:
        """Pause or resume the display; the history still receives samples."""
        self.set_paused(not self.paused)

    def set_paused(self, paused: bool) -> None:
        """Pause or resume scene, plots and numbers."""
        if paused != self.paused:
            self.paused = paused
            self.paused_changed.emit(paused)

    def tick(self) -> None:
        """Drain the ring and emit the newest row."""
        new = self._take()
        if len(new) and not self.hidden:
            clamped = bool(np.any(new[:, rows.FLAGS].astype(np.int64) & rows.CLAMPED))
            self.frame.emit(self.last, clamped)

    def refresh(self) -> None:
        """Emit the loop's health."""
        engine = self._studio.engine
        if engine is not None:
            health = engine.health()
            self._studio.note_health(health)
            self.health.emit(health)

    def _take(self) -> np.ndarray:
        """Move new rows from the ring into the history and return them."""
        if self._reader is None:
            return np.empty((0, rows.ROW_WIDTH))
        engine = self._studio.engine
        # read this before draining the ring, because it applies to the rows read below
        settled = engine is not None and engine.settled
        new = self._reader.read()
        self.lost = int(self._reader.lost)
        if len(new):
            self.history.append(new, self._object_position(new))
            self.last = new[-1]
        if self._changing:
            self.history.end_environment()
            self._changing = not settled
        return new

    def _object_position(self, new: np.ndarray) -> np.ndarray | None:
        """Return the positions (n,) in m of the environment's object.

        Return None if they are unknown or if there is no object.
        """
        engine, environment = self._studio.engine, self._studio.environment
        known = engine is not None and engine.renders(environment) and not self._changing
        if not known:
            return None
        return environment.place(self._studio.values, new[:, rows.POSITION], new[:, rows.STATE :])

    def note(self, text: str, instead: float | None = None) -> float:
        """Add a divider at the current time and remove the one at ``instead`` in s.

        Return the new divider's time.
        """
        self._take()
        self.history.divide(text, instead=instead)
        return self.history.now

    def _divide(self) -> None:
        """Add a divider at a change of environment; during a replay, the divider has no label.

        The plots resume if they were paused: the paused samples belong to the previous environment.
        """
        self.set_paused(self.paused and self.replaying)
        self._changing = True  # rows up to here belong to the previous environment
        self._take()
        last = self.history.before(self._studio.environment_since)
        text = "" if self.replaying else self._studio.environment.title
        self.history.divide(text, None if math.isnan(last) else last)
        self.history.end_environment()
        self._changing = True

    def _note_change(self) -> None:
        """Record a change of settings at the current time of the rows' clock."""
        self.history.changes.append(time.perf_counter())

    def _follow(self) -> None:
        engine = self._studio.engine
        self._reader = None if engine is None else engine.reader()
        entry = self._studio.entry
        if engine is not None and entry is not None and entry.key != self._device:
            self._device = entry.key
            self.set_paused(False)
            self.history.divide(entry.title)
            self.history.end_environment()
            self.last = None

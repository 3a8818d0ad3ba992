"""The frame: sixty times a second rows go from the loop's ring into history, scene and plots."""

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
KEPT_SECONDS = 60.0


class Live(QObject):
    """Drains the ring, never waits; emits ``frame(row, clamped)`` for pictures and ``health`` at 2 Hz."""

    frame = Signal(object, bool)
    health = Signal(object)
    paused_changed = Signal(bool)
    replay_wanted = Signal(object)
    """The path of a session that is to be shown in place of what comes."""

    def __init__(self, studio: Studio, parent: QObject | None = None):
        super().__init__(parent)
        self._studio = studio
        self._reader: RingReader | None = None
        self._device = ""
        self._changing = False
        self.history = LiveHistory(KEPT_SECONDS)
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
        """Begin; call once the window is up."""
        self._frames.start()
        self._health.start()

    def stop(self) -> None:
        """End for good, e.g. before the engine closes."""
        self._frames.stop()
        self._health.stop()

    def set_hidden(self, hidden: bool) -> None:
        """Only drain the ring, at a low rate, while the window is hidden."""
        self._frames.setInterval(HIDDEN_MS if hidden else FRAME_MS)
        self.hidden = hidden

    def toggle_paused(self) -> None:
        """Hold the picture still or let it go on; the history goes on filling."""
        self.set_paused(not self.paused)

    def set_paused(self, paused: bool) -> None:
        """Hold scene, plots and numbers still, or let them go on."""
        if paused != self.paused:
            self.paused = paused
            self.paused_changed.emit(paused)

    def tick(self) -> None:
        """Take what the loop wrote since the last frame and show its newest row."""
        new = self._take()
        if len(new) and not self.hidden:
            clamped = bool(np.any(new[:, rows.FLAGS].astype(np.int64) & rows.CLAMPED))
            self.frame.emit(self.last, clamped)

    def refresh(self) -> None:
        """Ask the loop how it is doing."""
        engine = self._studio.engine
        if engine is not None:
            health = engine.health()
            self._studio.note_health(health)
            self.health.emit(health)

    def _take(self) -> np.ndarray:
        """Move what the loop wrote into the history; return these rows."""
        if self._reader is None:
            return np.empty((0, rows.ROW_WIDTH))
        engine = self._studio.engine
        settled = engine is not None and engine.settled  # asked first: it holds for what comes after
        new = self._reader.read()
        self.lost = int(self._reader.lost)
        if len(new):
            self.history.append(new, self._object_position(new))
            self.last = new[-1]
        if self._changing:
            self.history.begin_anew()
            self._changing = not settled
        return new

    def _object_position(self, new: np.ndarray) -> np.ndarray | None:
        """Return the position (n,) in m of the environment's object in rows, None without its state."""
        engine, environment = self._studio.engine, self._studio.environment
        known = engine is not None and engine.renders(environment) and not self._changing
        if not known:
            return None
        return environment.place(self._studio.values, new[:, rows.POSITION], new[:, rows.STATE :])

    def note(self, words: str, instead: float | None = None) -> float:
        """Note in the history what changes now, in place of what was noted for a time in s; return when."""
        self._take()
        self.history.divide(words, instead=instead)
        return self.history.now

    def _divide(self) -> None:
        """Note in the history that another environment comes into force, unless a replay puts it there.

        Its samples begin once it has done so. It is seen at once: what stood while paused was the other's.
        """
        self.set_paused(self.paused and self.replaying)
        self._changing = True  # what came until now is the other's
        self._take()
        last = self.history.before(self._studio.environment_since)
        words = "" if self.replaying else self._studio.environment.title
        self.history.divide(words, None if math.isnan(last) else last)
        self.history.begin_anew()
        self._changing = True

    def _note_change(self) -> None:
        """Remember since when, by the rows' clock, all rows were rendered with the same settings."""
        self.history.changes.append(time.perf_counter())

    def _follow(self) -> None:
        engine = self._studio.engine
        self._reader = None if engine is None else engine.reader()
        entry = self._studio.entry
        if engine is not None and entry is not None and entry.key != self._device:
            self._device = entry.key
            self.set_paused(False)
            self.history.divide(entry.title)
            self.history.begin_anew()
            self.last = None

"""Replay: shows a recorded session in place of live data, with the settings of the recording.

The settings are changed temporarily, as for a measurement, and restored at the end. The motor gives no force
during the replay. After the replay, it gives no force until the user enables the force. The device's live
samples are still stored and recorded.
"""

import math
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from hapkit_studio.dynamics.loop_settings import from_table
from hapkit_studio.errors import ParameterError
from hapkit_studio.gui.live.live import FRAME_MS, Live
from hapkit_studio.gui.live.recorded import Recorded
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.state.environment_library import usable
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.state.undo import ENVIRONMENT, HAND, Snapshot, put, settings_of
from hapkit_studio.sessions.session import Session

_SETTLE_MS = 80  # ms: all samples are read when the replay position has not been dragged for this time
SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
FRAME = 1.0 / 60.0
"""Length in s of a single-frame step."""


class Replay(QObject):
    """Plays a session, and stops while ``live`` is paused.

    ``changed`` is emitted when a session was opened or closed. ``frame(row, clamped)`` is emitted like the
    signal ``frame`` of ``Live``. If the user changes a setting, the replay ends, and this setting is applied
    after the previous settings are restored.
    """

    beginning = Signal()
    """Emitted before settings are saved; other temporary changes of settings must end now."""
    changed = Signal()
    moved = Signal()
    sought = Signal()
    """Emitted when the user has moved the replay position."""
    frame = Signal(object, bool)
    failed = Signal(str)

    def __init__(self, studio: Studio, live: Live, clock: Callable[[], float] = time.perf_counter):
        """``clock()`` returns the time in s that drives the playback."""
        super().__init__(live)
        self._studio, self._live, self._clock = studio, live, clock
        self.history: Recorded | None = None
        """The session that is replayed; None while live data are shown."""
        self.speed, self.refusal = 1.0, ""
        """refusal: why the recorded settings could not be applied; "" if they were applied"""
        self._last = 0.0
        self._putting = False
        self._before: Snapshot = {}
        self._set: Snapshot = {}
        self._wanted: Snapshot = {}
        self._now_set: Mapping[str, Any] = {}
        self._reading = Job(self, needs="")
        self._reading.finished.connect(self._begin)
        self._reading.failed.connect(self.failed)
        self._frames = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._frames.timeout.connect(self.tick)
        self._settled = QTimer(self, interval=_SETTLE_MS, singleShot=True)
        self._settled.timeout.connect(self.settle)
        self._end = QTimer(self, interval=0, singleShot=True)
        self._end.timeout.connect(self.close)
        live.paused_changed.connect(self._go_on)
        live.replay_wanted.connect(self.open)
        studio.stop_changed.connect(self._notice_release)
        studio.settings_changed.connect(self._notice)

    # actions of the user

    def open(self, path: Path) -> None:
        """Read a session in a thread, then show its beginning.

        If this fails, emit ``failed`` with the error.
        """
        known = dict(self._studio.environments)
        self._reading.start(lambda _progress: Recorded(Session(path), known))

    def close(self) -> None:
        """Return to live data and the previous settings; settings changed by the user are kept."""
        if self.history is None:
            return
        self._end.stop()
        self._frames.stop()
        chosen = self._chosen_by_person()
        with suppress(ParameterError):  # an environment file was deleted meanwhile
            self._put(self._before)
        session = self.history.session
        self.history, self._live.replaying, self._studio.permissions.temporary = None, False, False
        self._live.set_paused(False)
        self.changed.emit()
        session.close()
        with suppress(ParameterError):  # these settings may be locked, or may not fit the restored settings
            put(self._studio, chosen)

    def shut(self) -> None:
        """Stop reading and replaying before the window closes."""
        self._reading.end()
        self.close()

    @property
    def time(self) -> float:
        """Return the replay position in s after the beginning."""
        return self.history.now - self.history.start if self.history is not None else 0.0

    @property
    def seconds(self) -> float:
        """Return the duration of the session in s."""
        return self.history.stop - self.history.start if self.history is not None else 0.0

    @property
    def settings(self) -> Mapping[str, Any]:
        """Return the recorded settings at the replay position; {} without a session."""
        return self.history.settings() if self.history is not None else {}

    @property
    def max_force(self) -> float | None:
        """Return the recorded force limit in N at the replay position; None without a session."""
        limit = self.settings.get("max_force_N")
        return float(limit) if isinstance(limit, int | float) else None

    def seek(self, seconds: float) -> None:
        """Go to a time in s after the beginning; all samples are read once the position stops changing."""
        if self.history is not None:
            self.history.complete = False
            self._move_to(self.history.start + seconds)
            self._settled.start()
            self.sought.emit()

    def settle(self) -> None:
        """Read and show all samples around the position."""
        self._settled.stop()
        if self.history is not None:
            self.history.complete = True
            self._show()

    def step(self, direction: int, sample: bool = False) -> None:
        """Pause, then move by one frame or by one sample: forward (direction 1) or back (-1)."""
        history = self.history
        if history is None:
            return
        self._live.set_paused(True)
        to = history.now + direction * FRAME
        if sample:
            to = history.after(history.now) if direction > 0 else history.before(history.now)
        if not math.isnan(to):
            self._move_to(to)
            self.sought.emit()

    def set_speed(self, speed: float) -> None:
        """Set the playback speed as a multiple of real time."""
        self.speed = speed
        self.moved.emit()

    # playing

    def tick(self) -> None:
        """Advance the position by the elapsed time; pause at the end."""
        now = self._clock()
        passed, self._last = now - self._last, now
        if self.history is None or self._live.paused or self._settled.isActive():
            return
        self._move_to(self.history.now + self.speed * passed)
        if self.history.now >= self.history.stop:
            self._live.set_paused(True)

    def _go_on(self, paused: bool) -> None:
        """Restart from the beginning when the user resumes at the end."""
        self._last = self._clock()
        if self.history is not None and not paused and self.history.now >= self.history.stop:
            self.seek(0.0)

    def _begin(self, history: Recorded) -> None:
        studio = self._studio
        if studio.hidden:
            history.session.close()
            self.failed.emit(f"{studio.hidden}.")
            return
        self.close()
        self.beginning.emit()
        studio.stop_state.wait_for_render()
        self._before = self._set = settings_of(studio)
        self._now_set, self._wanted, self.refusal = {}, {}, ""
        history.dividers = sorted([*history.markers, *self._environments(history)])
        studio.permissions.temporary = self._live.replaying = True
        self.history = history
        self._live.set_paused(False)
        self._last = self._clock()
        self.changed.emit()
        self.seek(0.0)
        self._frames.start()

    def _environments(self, history: Recorded) -> list[tuple[float, str]]:
        known = self._studio.environments
        return [
            (when, known[key].title if key in known else key)
            for when, key in history.begun
            if history.start < when <= history.stop
        ]

    def _move_to(self, time: float) -> None:
        history = self.history
        assert history is not None
        before = history.now
        history.move_to(min(max(time, history.start), history.stop))
        self._put_in_force(history.settings())
        self._show(before)
        self.moved.emit()

    def _show(self, since: float = math.inf) -> None:
        row = self.history.row() if self.history is not None else None
        if row is not None and self.history is not None:
            self.frame.emit(row, self.history.clamped_since(since))

    # settings

    def _put_in_force(self, what: Mapping[str, Any]) -> None:
        """Apply the recorded settings if they changed since the last call."""
        if what is self._now_set or self._end.isActive():
            return
        self._now_set = what
        try:
            self._wanted, self.refusal = recorded_settings(self._studio, what), ""
            self._check_locked(self._wanted)
            self._put(self._wanted)
        except ParameterError as error:
            self.refusal = str(error)

    def _check_locked(self, wanted: Snapshot) -> None:
        """Raise ParameterError if a setting to be applied is locked by an instructor."""
        locks = [lock for lock, _ in self._studio.permissions.lasting_locks()]
        places = ((*place, value) if place == ENVIRONMENT else place
                  for place, value in self._differing(wanted).items())  # fmt: skip
        if any(lock.covers(place) for place in places for lock in locks):
            raise ParameterError(
                "Some of these settings are locked, so the scene and the stability verdict do not change."
            )

    def _differing(self, wanted: Snapshot) -> Snapshot:
        """Return the wanted settings that differ from the current ones."""
        now = settings_of(self._studio)
        return {where: value for where, value in wanted.items() if now.get(where, value) != value}

    def _put(self, wanted: Snapshot) -> None:
        """Apply the wanted settings that differ from the current ones."""
        now, differing = settings_of(self._studio), self._differing(wanted)
        rate = ("loop", "rate")
        if self._studio.opened is not None and self._studio.opened.own_clock and rate in differing:
            self._studio.loop = replace(self._studio.loop, rate=differing.pop(rate))
        self._putting = True
        try:
            put(self._studio, {ENVIRONMENT: wanted.get(ENVIRONMENT, now[ENVIRONMENT]), **differing})
        finally:
            self._putting = False
            self._set = settings_of(self._studio)

    def _chosen_by_person(self) -> Snapshot:
        """Return the settings that the user has changed.

        The replay's own environment may arrive later than the other settings, because it is compiled first.
        """
        now, late = settings_of(self._studio), self._wanted.get(ENVIRONMENT)
        changed = {where: value for where, value in now.items() if self._set.get(where, value) != value}
        return {where: value for where, value in changed.items() if where != ENVIRONMENT or value != late}

    def _notice(self) -> None:
        if self.history is not None and not self._putting and self._chosen_by_person():
            self._end.start()  # the check is queued, so that it sees simultaneous changes together

    def _notice_release(self) -> None:
        """End the replay when the user enables the force; the force fades in with the previous settings."""
        opened = self._studio.opened
        if not self._studio.stopped and (opened is None or opened.motor):
            self.close()


def recorded_settings(studio: Studio, what: Mapping[str, Any]) -> Snapshot:
    """Return the recorded settings that can be applied on this device.

    A board keeps its own loop rate. Raise ParameterError for an unknown environment.
    """
    key = str(what.get("environment", ""))
    if key not in studio.environments:
        raise ParameterError(
            f"The environment {key} is not installed, so the scene and the stability verdict do not change."
        )
    parameters, device = what.get("parameters"), studio.opened
    ours = device is not None and not device.own_clock
    kept = ("delay_s", "estimator", "controller", "grip", *(["rate_Hz"] if ours else []))
    loop = from_table({key: what[key] for key in kept if what.get(key) is not None}, studio.loop)
    found: Snapshot = {ENVIRONMENT: key, HAND: studio.grip, ("loop", "controller"): False}
    values = usable(studio.environments[key], parameters if isinstance(parameters, dict) else {})
    found |= {("value", key, one): value for one, value in values.items()}
    return found | {("loop", one): value for one, value in loop.items()}

"""Passes the live telemetry rows to the widgets that show them: scene, plots, clamp light, status bar."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal

from hapkit_studio.analysis import oscillation
from hapkit_studio.gui.live import kept_curves
from hapkit_studio.gui.live.centre import Centre
from hapkit_studio.gui.live.history import Samples, highest_speed
from hapkit_studio.gui.live.live import HISTORY_SECONDS, Live
from hapkit_studio.gui.live.replay import Replay
from hapkit_studio.gui.panel.warnings import WarningLines
from hapkit_studio.gui.shell.status_bar import StatusBar
from hapkit_studio.gui.state.permissions import BARE_SCENE
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.haptics import rows

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Recording
    from hapkit_studio.haptics.health import Health

_MAX_FORCE = 3.0
_DRAWN = rows.POSITION, rows.APPLIED_FORCE, rows.FORCE, rows.HAND_TARGET
_USUAL_S = 12.0  # s: typical duration of the first compilation on two processors
_NEARLY = 0.95  # the progress bar stops at this fraction if compiling takes longer
_BAR_MS = 250
_RECORDED = ("position", "velocity", "force", "applied_force")  # signals that a Recording contains
_WORDS = {
    "preparing": "Preparing the loop. This happens only once.",
    "connecting": "Connecting…",
    "idle": "Not connected",
    "gone": "No device",
    "failed": "No device",
}


class LiveDisplay(QObject):
    """Passes every frame, parameter and state to the widgets that show them.

    ``releasing`` is emitted when the user is about to release the handle at its current position.
    """

    releasing = Signal()

    def __init__(
        self,
        studio: Studio,
        live: Live,
        replay: Replay,
        centre: Centre,
        status: StatusBar,
        warnings: WarningLines,
    ):
        super().__init__()
        self._warnings, self._replay = warnings, replay
        self._studio, self._live, self._centre, self._status = studio, live, centre, status
        self._seen: np.ndarray | None = None
        self._acting: float | None = None
        self._measured_delay: float | None = None
        self._since, self._bar = QElapsedTimer(), QTimer(centre, interval=_BAR_MS)
        self._since.start()
        self._bar.timeout.connect(self._show_preparing)
        replay.changed.connect(self.show_source)
        replay.frame.connect(self.show_frame)
        replay.sought.connect(lambda: centre.view.follow())
        live.frame.connect(self.show_live_frame)
        live.health.connect(self.show_health)
        live.paused_changed.connect(self.show_paused)
        centre.scene.grabbed.connect(lambda: live.set_paused(False))
        centre.scene.hand_moved.connect(studio.move_hand)
        centre.scene.hand_released.connect(lambda: studio.move_hand(None))
        centre.toolbar.release.clicked.connect(self.release_here)
        centre.toolbar.keep.clicked.connect(self.keep_curves)
        for plots in (centre.time, *centre.phase.beside):
            plots.back_pressed.connect(self.go_live)
        studio.environment_changed.connect(self.show_environment)
        studio.values_changed.connect(self.show_values)
        studio.loop_changed.connect(lambda: centre.scene.set_grip(studio.grip))
        for signal in (studio.engine_changed, studio.hidden_changed, studio.lock_changed):
            signal.connect(self.show_environment)
        studio.engine_changed.connect(self.show_link)
        studio.link_changed.connect(self.show_link)
        self.show_environment()
        self.show_source()

    @property
    def max_force(self) -> float:
        """Return the current force limit in N; during a replay, return the recorded limit."""
        engine, replayed = self._studio.engine, self._replay.max_force
        if replayed is not None:
            return replayed
        return engine.max_force if engine is not None else _MAX_FORCE

    def show_paused(self, paused: bool) -> None:
        """Pause or resume scene, plots and numbers; the status bar is not paused.

        During a replay, this pauses the replay position, which the user can still move.
        """
        self._show_oscillation()
        self._centre.scene.set_paused(paused)
        self._centre.view.set_paused(paused and not self._live.replaying)
        self._update_acting_force()
        self.show_values()

    @property
    def _may_change(self) -> bool:
        """Return whether the display may change; a paused display changes only during a replay."""
        return self._live.replaying or not self._live.paused

    def show_source(self) -> None:
        """Show live data, or the replayed session."""
        replayed = self._replay.history
        history = self._live.history if replayed is None else replayed
        self._centre.trigger.disarm()
        self._centre.view.set_history(history)
        self._centre.time.cursors.show(False)
        self.show_link()
        self.show_values()
        if self._live.last is not None and history is self._live.history:
            self._show_scene(self._live.last)

    def show_live_frame(self, row: np.ndarray, clamped: bool) -> None:
        """Show a live row, unless a session is replayed."""
        if not self._live.replaying:
            self.show_frame(row, clamped)

    def show_frame(self, row: np.ndarray, clamped: bool) -> None:
        """Show a row in all widgets; while paused, only the status bar shows its force."""
        if self._may_change:
            self._show_scene(row)
        if self._live.replaying:
            self._show_delay()
        self._centre.refresh()
        self._status.show_clamp(clamped, self.max_force, self._acting)

    def _show_scene(self, row: np.ndarray) -> None:
        environment, engine = self._studio.environment, self._studio.engine
        known = engine is not None and engine.renders(environment)
        if self._live.replaying:
            known = self._replay.settings.get("environment") == environment.key
        width = len(environment.state_names) if known else 0
        position, applied, asked, target = (float(row[column]) for column in _DRAWN)
        flags = int(row[rows.FLAGS])
        clamped, stopped = bool(flags & rows.CLAMPED), bool(flags & (rows.STOPPED | rows.FAULT))
        hand = None if math.isnan(target) else target
        state = row[rows.STATE : rows.STATE + width]
        self._centre.scene.update_state(position, applied, asked, hand, clamped, stopped, state)

    def _update_acting_force(self) -> None:
        """Store the newest force for the status bar a few times per second, so that users can read it."""
        last = self._live.last
        self._acting = float(last[rows.APPLIED_FORCE]) if self._live.paused and last is not None else None

    def keep_curves(self) -> None:
        """Hold the plotted traces of the current environment; their name describes the settings."""
        view, text = (
            self._centre.view,
            kept_curves.settings_name(self._studio.environment, self._studio.values),
        )
        start, stop = view.stretch
        self._centre.kept_curves.keep(
            view.history, (max(start, view.history.begin), stop), text, zero=view.zero
        )

    def hold_recording(self, recording: "Recording", path: Path) -> None:
        """Hold the last part of a recording from a file, at most as long as the longest time window."""
        time = recording.time
        history = Samples.of(time, ((name, getattr(recording, name)) for name in _RECORDED))
        self._centre.kept_curves.keep(
            history, (max(time[0], time[-1] - HISTORY_SECONDS), time[-1]), path.name
        )

    def go_live(self) -> None:
        """Return to live data and disarm the trigger."""
        self._replay.close()
        self._centre.trigger.disarm()
        self._live.set_paused(False)
        self._centre.view.follow()

    def release_here(self) -> None:
        """Stop the simulated handle at its current position and release it, even if it was moving."""
        self.releasing.emit()
        self._live.set_paused(False)
        self._studio.release_at_rest()
        self._centre.scene.release()

    def _own_rate(self) -> tuple[float | None, bool]:
        """Return the nominal rate in Hz (None if unknown), and whether the board's clock sets this rate."""
        engine = self._studio.engine
        if engine is None or not engine.device.own_clock:
            return None, False
        plan = engine.decision().in_force if engine.rendering == engine.where else None
        return (engine.loop.rate, False) if plan is None else (float(plan.rate), True)

    def show_health(self, health: "Health") -> None:
        """Show the loop's health in the status bar; while no frames arrive, also repaint the plots."""
        self._centre.view.keep_samples()
        self._measured_delay = health.delay
        self._show_delay()
        if self._live.last is None or self._live.last is self._seen:
            self._centre.refresh()
        self._seen = self._live.last
        if self._studio.link.state == "running":
            last = self._live.last
            compute = math.nan if last is None else float(last[rows.COMPUTE])
            self._status.show_health(health, *self._own_rate(), compute)
            self._warnings.watch(highest_speed(self._live.history))
            self._update_acting_force()
            if not self._live.paused:
                self._show_oscillation()

    def _show_delay(self) -> None:
        """Pass the delay with which the shown samples were rendered to the force plot and the kept curves."""
        delay = self._measured_delay
        if self._live.replaying:
            recorded = self._replay.settings.get("delay_s")
            delay = float(recorded) if isinstance(recorded, int | float) else None
        self._centre.phase.set_delay(delay)
        self._centre.kept_curves.delay = delay

    def _show_oscillation(self) -> None:
        history = self._centre.view.history
        window = history.between(history.now - oscillation.SECONDS, math.inf).known()
        self._centre.time.show_oscillation(oscillation.sustained(window.x, window.y["position"]))

    def show_environment(self) -> None:
        """Show another environment; in a blind comparison only the handle is shown."""
        environment, values = self._studio.environment, self._studio.values
        left_out = self._studio.permissions.left_out
        self._centre.phase.hide_theory(bool(self._studio.hidden) or "theory" in left_out)
        # a kept curve is named after its settings, and this name would reveal hidden settings
        self._centre.toolbar.keep.setEnabled(not self._studio.hidden)
        self._centre.scene.show_force(self._studio.hidden not in BARE_SCENE)
        if self._studio.hidden in BARE_SCENE:
            environment, values = self._studio.environments["free"], {}
        self._centre.scene.set_environment(environment, values)
        self._centre.lay_out()
        self.show_values()

    def show_values(self) -> None:
        """Show changed parameters; while paused, wait until the user resumes."""
        if not self._may_change:
            return
        environment, values = self._studio.environment, self._studio.values
        if self._studio.hidden in BARE_SCENE:
            return
        self._centre.scene.set_values(values)
        self._centre.trigger.set_environment(environment)
        self._centre.time.set_environment(environment, values, self.max_force)
        self._centre.phase.set_environment(environment, values, self.max_force)

    def show_link(self) -> None:
        """Show whether a device is connected."""
        state = self._studio.link.state
        self._show_preparing()
        replaying = self._live.replaying
        self._centre.scene.set_hand_enabled(self._studio.hand_is_ours and not replaying)
        self._centre.toolbar.show_release(self._studio.models_handle and not replaying)
        self._centre.time.set_stale(state in ("gone", "failed", "idle") and not replaying)
        if state != "running":
            self._centre.time.show_oscillation(None)
            waiting = self._studio.link.text if state in ("connecting", "idle") else ""
            self._status.show_nothing(waiting or _WORDS.get(state, ""))

    def _show_preparing(self) -> None:
        """Show the estimated progress of the loop's first compile."""
        preparing = self._studio.link.state == "preparing" and not self._live.replaying
        fraction = min(1e-3 * self._since.elapsed() / _USUAL_S, _NEARLY)
        self._centre.scene.set_preparing(preparing, fraction if preparing else None)
        if preparing != self._bar.isActive():
            self._bar.start() if preparing else self._bar.stop()

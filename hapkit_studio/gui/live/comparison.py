"""Comparison of computer and board: both render the same movement, and their traces are overlaid."""

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from PySide6.QtCore import QObject, Qt, QTimer

from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.dynamics.loop_settings import BOARD, RENDERERS
from hapkit_studio.gui.live.history import History
from hapkit_studio.gui.live.kept_curves import KeptCurve
from hapkit_studio.gui.live.live import FRAME_MS, Live
from hapkit_studio.gui.panel.rendering import RenderingSwitch
from hapkit_studio.gui.state.studio import Studio
from hapkit_studio.gui.widgets.theme import number

if TYPE_CHECKING:
    from hapkit_studio.gui.live.centre import Centre

COMPARED_SECONDS = 4.0
SETTLE_SECONDS = 0.6
"""s: from the handover to the first movement; meanwhile the force fades in and the handle comes to rest."""
PATIENCE = 5.0
"""s: the new renderer must have started within this time."""
_ORDER = "press", "tap", "stroke", "sweep", "pet"
_FAULT = "A fault ended the comparison. Clear the fault, then compare again."
_STOPPED = "The force is off, so nothing can be compared. Release the E-stop or clear the fault first."
_CHANGED = "The settings changed, so the comparison ended without a result. Compare again."
HELD_SECONDS = 5.0
UNWATCHED = (
    "While the board renders, there is no alarm if the scene adds energy, because only the computer's loop "
    "measures this energy."
)


class Part(NamedTuple):
    """An interval with one renderer: the renderer, and start and stop in s of the rows' clock."""

    where: str
    start: float
    stop: float


def movement(hands: tuple[str, ...]) -> Hand:
    """Return the hand movement that compares an environment.

    Return a press if the environment declares no suitable movement.
    """
    return hand_named(next((name for name in hands if name in _ORDER), "press"))


class RenderingComparison(QObject):
    """Compares rendering on the computer and on the board; keeps the last trace of the previous renderer.

    Both renderers get the same movement; afterwards the original renderer renders again.
    """

    def __init__(self, studio: Studio, live: Live, centre: "Centre", switch: RenderingSwitch):
        super().__init__(centre)
        self._studio, self._live, self._centre, self._switch = studio, live, centre, switch
        self._rendered_by = self._home = RENDERERS[0]
        self._began = time.perf_counter()
        self._compared = False
        self._kept: KeptCurve | None = None
        self._left: list[str] = []
        self._parts: list[Part] = []
        self._hand = movement(())
        self._moving_since = self._asked_at = 0.0
        self._timer = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._go_on)
        live.health.connect(switch.note_health)
        live.frame.connect(lambda _row, _clamped: self._refresh())
        live.paused_changed.connect(self._resume)
        switch.compare.connect(self.toggle)
        studio.stop_changed.connect(lambda: self.cancel(_STOPPED))
        for changed in (studio.environment_changed, studio.values_changed, studio.engine_changed):
            changed.connect(lambda: self.cancel(_CHANGED))
        for changed in (studio.environment_changed, studio.engine_changed):
            changed.connect(self._forget)

    @property
    def running(self) -> bool:
        """Return whether a comparison is running."""
        return bool(self._left)

    def toggle(self) -> None:
        """Start a comparison, or cancel the running one; if neither is possible, show the reason."""
        if self.running:
            self.cancel("")
            return
        engine = self._studio.engine
        if engine is None or not self._studio.hand_is_ours or engine.decision().refusal:
            return
        if self._studio.stopped or engine.fault is not None:
            self._switch.show_message(_STOPPED)
            return
        self._live.set_paused(False)
        self._home = self._studio.loop.where
        self._parts, self._left = [], list(RENDERERS)
        self._hand = movement(self._studio.environment.hands)
        self._drop()
        self._begin()

    def cancel(self, why: str) -> None:
        """Release the hand, restore the original renderer and show ``why``.

        Do nothing if no comparison is running.
        """
        if self.running:
            self._left = []
            self._end(why)

    def _begin(self) -> None:
        self._moving_since, self._asked_at = 0.0, time.perf_counter()
        self._studio.move_hand(0.0)
        with self._studio.temporarily():
            self._studio.set_loop(where=self._left[0])
        self._switch.set_busy(
            f"Comparing: movement {len(self._parts) + 1} of 2, rendered by the {self._left[0]}."
        )
        self._timer.start()

    def _go_on(self) -> None:
        engine, now = self._studio.engine, time.perf_counter()
        if engine is None or engine.fault is not None:
            self.cancel(_FAULT)
        elif self._moving_since:
            self._move(now)
        elif now - self._asked_at > PATIENCE:
            self.cancel(f"The {self._left[0]} did not start to render, so nothing was compared.")
        elif engine.rendering == self._left[0] and now - self._asked_at > SETTLE_SECONDS:
            self._moving_since = now

    def _move(self, now: float) -> None:
        passed = now - self._moving_since
        held = passed < self._hand.release
        self._studio.move_hand(float(self._hand.target(passed)) if held else None)
        if passed < COMPARED_SECONDS:
            return
        self._parts.append(Part(self._left.pop(0), self._moving_since, now))
        if self._left:
            self._begin()
        else:
            self._end("")
            self._show_compared(*self._parts)

    def _end(self, why: str) -> None:
        self._timer.stop()
        self._studio.move_hand(None)
        self._switch.set_busy("")
        with self._studio.temporarily():
            self._studio.set_loop(where=self._home)
        self._switch.show_message(why)

    def _refresh(self) -> None:
        """Detect that the renderer has changed from computer to board or back."""
        engine = self._studio.engine
        if engine is None or engine.rendering == self._rendered_by:
            return
        before, now = self._rendered_by, time.perf_counter()
        self._rendered_by = engine.rendering
        self._centre.phase.set_note(UNWATCHED if engine.rendering == BOARD else "")
        if not (self.running or self._compared):
            self._hold(Part(before, max(self._began, now - HELD_SECONDS), now))
        self._began = now

    def _hold(self, part: Part, shift: float | None = None) -> None:
        """Replace the kept curve by this interval.

        The interval is shown at the right edge, or shifted by ``shift`` s.
        """
        self._drop()
        stretch = part.start, part.stop
        self._kept = self._centre.kept_curves.keep(self._live.history, stretch, f"on the {part.where}", shift)

    def _show_compared(self, one: Part, other: Part) -> None:
        """Overlay the plots of both intervals and show by how much the forces differ."""
        self._live.tick()
        self._centre.view.follow()
        self._hold(one, other.start - one.start)
        self._compared = True
        self._live.set_paused(True)
        self._switch.show_message(difference_text(self._live.history, one, other))

    def _resume(self, paused: bool) -> None:
        self._compared &= paused

    def _drop(self) -> None:
        self._centre.kept_curves.drop(self._kept)

    def _forget(self) -> None:
        self._began, self._compared = time.perf_counter(), False
        self._drop()


def difference_text(history: History, one: Part, other: Part) -> str:
    """Describe by how much the applied forces of two intervals with the same movement differ."""
    first, second = (history.between(part.start, part.stop).known() for part in (one, other))
    if min(len(first.x), len(second.x)) < 2:
        return ""
    there = np.interp(first.x - one.start, second.x - other.start, second.y["applied_force"])
    apart = np.abs(first.y["applied_force"] - there)
    usual, most = (number(value, 2) for value in (float(np.sqrt(np.mean(apart**2))), float(apart.max())))
    return (
        f"The hand moved twice in the same way. Kept curve: rendered by the {one.where}. Coloured curve: "
        f"rendered by the {other.where}. The forces differ by {usual} N (RMS) and by at most {most} N."
    )

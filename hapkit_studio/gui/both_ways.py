"""Both ways of rendering on top of each other: what was rendered before a switch stays in the plots, grey.

Compare does it with the same movement of the simulated hand, each way once, and then holds the plots.
"""

import time
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Qt, QTimer

from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.gui.live import FRAME_MS, Live
from hapkit_studio.gui.plots.held import held
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.where_facts import WAYS
from hapkit_studio.gui.where_switch import WhereSwitch

if TYPE_CHECKING:
    from hapkit_studio.gui.centre import Centre

HELD_SECONDS = 5.0
COMPARED_SECONDS = 4.0
SETTLE_SECONDS = 0.6
"""From the handing over to the first movement: the force has faded in, the handle rests."""
_PATIENCE = 5.0
_ORDER = "press", "tap", "stroke", "sweep", "pet"


def movement(hands: tuple[str, ...]) -> Hand:
    """Return the movement by which an environment is compared: one of its own, a press by default."""
    return hand_named(next((name for name in hands if name in _ORDER), "press"))


class BothWays(QObject):
    """Follows who renders; keeps the other way's last seconds in the plots, and compares on demand."""

    def __init__(self, studio: Studio, live: Live, centre: "Centre", switch: WhereSwitch):
        super().__init__(centre)
        self._studio, self._live, self._centre, self._switch = studio, live, centre, switch
        self._rendered_by = WAYS[0]
        self._began = time.perf_counter()
        self._left: list[str] = []
        self._parts: list[tuple[str, float, float]] = []
        self._hand: Hand | None = None
        self._moving_since = self._asked_at = 0.0
        self._timer = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._go_on)
        live.health.connect(switch.note_health)
        live.frame.connect(lambda _row, _clamped: self._look())
        switch.compare.connect(self.compare)
        studio.environment_changed.connect(self._forget)
        studio.engine_changed.connect(self._forget)
        studio.stop_changed.connect(self.cancel)

    @property
    def comparing(self) -> bool:
        """Say whether a comparison goes on."""
        return bool(self._left)

    def compare(self) -> None:
        """Render some seconds each way with the same movement of the hand, then show both; again: cancel."""
        if self.comparing:
            self.cancel()
            return
        engine = self._studio.engine
        if engine is None or not self._studio.hand_is_ours or engine.board_refusal():
            return
        self._forget()
        self._live.set_paused(False)
        self._parts, self._left = [], list(WAYS)
        self._hand = movement(self._studio.environment.hands)
        self._begin()

    def cancel(self) -> None:
        """Let the hand go and stop comparing."""
        if self.comparing:
            self._left = []
            self._timer.stop()
            self._studio.move_hand(None)
            self._switch.set_busy("")

    # a switch by hand

    def _look(self) -> None:
        engine = self._studio.engine
        if engine is None or engine.rendering == self._rendered_by:
            return
        before, now = self._rendered_by, time.perf_counter()
        self._rendered_by = engine.rendering
        if not self.comparing:
            start = max(self._began, now - HELD_SECONDS)
            self._show(before, start, now, now - start)
        self._began = now

    def _show(self, where: str, start: float, stop: float, shift: float) -> None:
        past = held(self._live.history, f"on the {where}", start, stop, shift)
        self._centre.time.set_held(past)
        self._centre.phase.set_held(past)

    def _forget(self) -> None:
        self.cancel()
        self._began = time.perf_counter()
        self._centre.time.set_held(None)
        self._centre.phase.set_held(None)

    # both by the same movement

    def _begin(self) -> None:
        self._moving_since, self._asked_at = 0.0, time.perf_counter()
        self._studio.move_hand(0.0)
        self._studio.set_loop(where=self._left[0])
        self._switch.set_busy(f"Cancel: on the {self._left[0]} …")
        self._timer.start()

    def _go_on(self) -> None:
        engine, now = self._studio.engine, time.perf_counter()
        if engine is None or self._hand is None or now - self._asked_at > _PATIENCE + COMPARED_SECONDS:
            self.cancel()
            return
        if not self._moving_since:
            if engine.rendering == self._left[0] and now - self._asked_at > SETTLE_SECONDS:
                self._moving_since = now
            return
        passed = now - self._moving_since
        let_go = passed >= self._hand.release
        self._studio.move_hand(None if let_go else float(self._hand.target(passed)))
        if passed >= COMPARED_SECONDS:
            self._end_of_part(now)

    def _end_of_part(self, now: float) -> None:
        self._parts.append((self._left.pop(0), self._moving_since, now))
        if self._left:
            if len(self._parts) == 1:
                self._begin()
            return
        self._timer.stop()
        self._switch.set_busy("")
        (where, start, stop), (_, second, _) = self._parts
        self._live.tick()
        self._show(where, start, stop, second - start)
        self._studio.move_hand(None)
        self._live.set_paused(True)

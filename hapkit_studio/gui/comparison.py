"""Rendering some seconds each way with the same movement of the simulated hand."""

import time
from typing import NamedTuple

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.gui.live import FRAME_MS, Live
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.where_facts import WAYS
from hapkit_studio.gui.where_switch import WhereSwitch

COMPARED_SECONDS = 4.0
SETTLE_SECONDS = 0.6
"""From the handing over to the first movement: the force has faded in, the handle rests."""
PATIENCE = 5.0
"""s in which who is to render must have begun."""
_ORDER = "press", "tap", "stroke", "sweep", "pet"
_FAULT = "A fault ended the comparison. Clear it, then compare again."
_STOPPED = "Nothing to compare while the force is off. Release the E-stop or clear the fault first."
_CHANGED = "Changed meanwhile: nothing was compared."


class Part(NamedTuple):
    """Who rendered, from when to when in s of the rows' clock."""

    where: str
    start: float
    stop: float


def movement(hands: tuple[str, ...]) -> Hand:
    """Return the movement by which an environment is compared: one of its own, a press by default."""
    return hand_named(next((name for name in hands if name in _ORDER), "press"))


class Comparison(QObject):
    """Emits ``began``, and ``finished`` with both parts; who rendered before renders again in the end."""

    began = Signal()
    finished = Signal(object, object)

    def __init__(self, studio: Studio, live: Live, switch: WhereSwitch, parent: QObject):
        super().__init__(parent)
        self._studio, self._live, self._switch = studio, live, switch
        self._left: list[str] = []
        self._parts: list[Part] = []
        self._hand: Hand | None = None
        self._home = WAYS[0]
        self._moving_since = self._asked_at = 0.0
        self._timer = QTimer(self, interval=FRAME_MS, timerType=Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self._go_on)
        switch.compare.connect(self.toggle)
        studio.stop_changed.connect(lambda: self.cancel(_STOPPED))
        for signal in (studio.environment_changed, studio.values_changed, studio.engine_changed):
            signal.connect(lambda: self.cancel(_CHANGED))

    @property
    def running(self) -> bool:
        """Say whether a comparison goes on."""
        return bool(self._left)

    def toggle(self) -> None:
        """Begin, or cancel what goes on; say why where neither is possible."""
        if self.running:
            self.cancel("")
            return
        engine = self._studio.engine
        if engine is None or not self._studio.hand_is_ours or engine.board_refusal():
            return
        if self._studio.stopped or engine.fault is not None:
            self._switch.tell(_STOPPED)
            return
        self._live.set_paused(False)
        self._home = self._studio.loop.where
        self._parts, self._left = [], list(WAYS)
        self._hand = movement(self._studio.environment.hands)
        self.began.emit()
        self._begin()

    def cancel(self, why: str) -> None:
        """Let the hand go, give back who rendered, and say why; nothing where nothing goes on."""
        if self.running:
            self._left = []
            self._end(why)

    def _begin(self) -> None:
        self._moving_since, self._asked_at = 0.0, time.perf_counter()
        self._studio.move_hand(0.0)
        self._studio.set_loop(where=self._left[0])
        self._switch.set_busy(f"Comparing: on the {self._left[0]}, {len(self._parts) + 1} of {len(WAYS)}.")
        self._timer.start()

    def _go_on(self) -> None:
        engine, now = self._studio.engine, time.perf_counter()
        if engine is None or self._hand is None or engine.fault is not None:
            self.cancel(_FAULT)
        elif self._moving_since:
            self._move(self._hand, now)
        elif now - self._asked_at > PATIENCE:
            self.cancel(f"The {self._left[0]} did not begin to render. Nothing was compared.")
        elif engine.rendering == self._left[0] and now - self._asked_at > SETTLE_SECONDS:
            self._moving_since = now

    def _move(self, hand: Hand, now: float) -> None:
        passed = now - self._moving_since
        self._studio.move_hand(None if passed >= hand.release else float(hand.target(passed)))
        if passed < COMPARED_SECONDS:
            return
        self._parts.append(Part(self._left.pop(0), self._moving_since, now))
        if self._left:
            self._begin()
        else:
            self._end("")
            self.finished.emit(*self._parts)

    def _end(self, why: str) -> None:
        self._timer.stop()
        self._studio.move_hand(None)
        self._switch.set_busy("")
        self._studio.set_loop(where=self._home)
        self._switch.tell(why)

"""Both ways of rendering on top of each other: what was rendered before a switch stays in the plots, grey.

Over position it is shown at once; over time as soon as the handle moves as it did before, and there.
"""

import time
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import QObject

from hapkit_studio.gui import alignment
from hapkit_studio.gui.comparison import Comparison, Part
from hapkit_studio.gui.history import History
from hapkit_studio.gui.live import Live
from hapkit_studio.gui.plots.held import Held, held
from hapkit_studio.gui.studio import Studio
from hapkit_studio.gui.theme import number
from hapkit_studio.gui.where_facts import BOARD, WAYS
from hapkit_studio.gui.where_switch import WhereSwitch

if TYPE_CHECKING:
    from hapkit_studio.gui.centre import Centre

HELD_SECONDS = 5.0
PAST_SECONDS = 12.0
"""So far back from a switch a movement like the one after it is looked for."""
FADED_SECONDS = 0.2
"""After a switch the force has faded in."""
UNWATCHED = (
    "No energy alarm: the passivity observer is part of the computer's loop, and the board renders now."
)


class BothWays(QObject):
    """Follows who renders; keeps the other way's last seconds in the plots, and compares on demand."""

    def __init__(self, studio: Studio, live: Live, centre: "Centre", switch: WhereSwitch):
        super().__init__(centre)
        self._studio, self._live, self._centre, self._switch = studio, live, centre, switch
        self._rendered_by = WAYS[0]
        self._began = time.perf_counter()
        self._before: Part | None = None  # of what is to be laid over the present, once it moves alike
        self._aligned_at = 0.0
        self._compared = False
        self.comparison = Comparison(studio, live, switch, self)
        self.comparison.began.connect(self._clear)
        self.comparison.finished.connect(self._show_compared)
        live.health.connect(switch.note_health)
        live.health.connect(lambda _health: self._align())
        live.frame.connect(lambda _row, _clamped: self._look())
        live.paused_changed.connect(lambda _on: self._resume())
        studio.environment_changed.connect(self._forget)
        studio.engine_changed.connect(self._forget)

    def _look(self) -> None:
        """Notice that somebody else renders now."""
        engine = self._studio.engine
        if engine is None or engine.rendering == self._rendered_by:
            return
        before, now = self._rendered_by, time.perf_counter()
        self._rendered_by = engine.rendering
        self._centre.phase.set_note(UNWATCHED if engine.rendering == BOARD else "")
        if not (self.comparison.running or self._compared):
            self._clear()
            start = max(self._began, now - PAST_SECONDS)
            self._before, self._aligned_at = Part(before, start, now), 0.0
            past = self._held(Part(before, max(start, now - HELD_SECONDS), now), 0.0)
            self._centre.phase.set_held(past)
        self._began = now

    def _align(self) -> None:
        """Lay the past over the present where the handle moved alike; better while it goes on moving."""
        if self._before is None:
            return
        switch, now = self._before.stop, self._live.history.now
        begin = self._aligned_at or max(switch + FADED_SECONDS, now - alignment.MOST)
        found = alignment.earlier(self._live.history, self._before.start, switch, begin, now)
        if found is None:
            return
        first = Part(self._before.where, begin - found, min(begin - found + HELD_SECONDS, switch))
        self._centre.time.set_held(self._held(first, found))
        self._aligned_at = begin
        if now >= begin + alignment.MOST:
            self._before = None

    def _held(self, part: Part, shift: float) -> Held | None:
        return held(self._live.history, f"on the {part.where}", part.start, part.stop, shift)

    def _show_compared(self, one: Part, other: Part) -> None:
        """Hold the plots with both parts on top of each other, and say by how much the forces differ."""
        self._live.tick()
        past = self._held(one, other.start - one.start)
        self._centre.time.set_held(past)
        self._centre.phase.set_held(past)
        self._compared = True
        self._live.set_paused(True)
        self._switch.tell(difference_words(self._live.history, one, other))

    def _resume(self) -> None:
        self._compared = self._compared and self._live.paused

    def _clear(self) -> None:
        self._before = None
        self._centre.time.set_held(None)
        self._centre.phase.set_held(None)

    def _forget(self) -> None:
        self._began, self._compared = time.perf_counter(), False
        self._clear()


def difference_words(history: History, one: Part, other: Part) -> str:
    """Say by how much the applied forces of two parts with the same movement differ."""
    first, second = (history.between(part.start, part.stop) for part in (one, other))
    known = [np.isfinite(w.x) for w in (first, second)]
    if min(map(np.count_nonzero, known)) < 2:
        return ""
    there = np.interp(
        first.x[known[0]] - one.start, second.x[known[1]] - other.start, second.y["applied"][known[1]]
    )
    apart = np.abs(first.y["applied"][known[0]] - there)
    usual, most = (number(value, 2) for value in (float(np.sqrt(np.mean(apart**2))), float(apart.max())))
    lines = f"dotted: {one.where}, in colour: {other.where}"
    return f"Same movement of the hand, {lines}. The forces differ by {usual} N rms, {most} N at most."

"""Which stretch of the history the plots show: it follows the newest sample, or stands at a time."""

import math

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.live.history import History, LiveHistory

SPANS = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0)  # s
_SOME = 0.05  # of the span: of data that stay in sight; zoomed so near to their end, it goes on following
_KEPT_AHEAD = 1.0  # s before it would be forgotten, a standing stretch is kept


class TimeView(QObject):
    """The time axis that all plots share, from ``left`` to ``right`` in s, counted from ``zero``.

    ``history`` is what is seen: while paused, and where it would be forgotten, a copy of the live one.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.live: History = LiveHistory(seconds=1.0, rate=1.0)
        self.history: History = self.live
        self.left, self.right = -10.0, 0.0
        self.paused = self.locked = False
        self.happened = ""
        """What happened at zero, in words, where it stands at an event."""
        self.waiting = ""
        """What a trigger waits for, in words."""
        self.level: tuple[str, float] | None = None
        """The level it waits for: of which channel, SI."""
        self._zero: float | None = None
        self._paused_at: dict[str, float] = {}

    @property
    def follows(self) -> bool:
        """Say whether it goes on with the newest sample."""
        return self._zero is None

    @property
    def zero(self) -> float:
        """Return the time of the axis' zero in s, the newest sample's while it follows; NaN without one."""
        return self.history.now if self._zero is None else self._zero

    @property
    def span(self) -> float:
        """Return how many s are shown."""
        return self.right - self.left

    @property
    def stretch(self) -> tuple[float, float]:
        """Return from when to when samples are in sight, in s."""
        return self.zero + self.left, min(self.zero + self.right, self.history.now)

    @property
    def latest(self) -> dict[str, float]:
        """Return every channel's newest value, while paused the newest then; NaN without one."""
        return self._paused_at if self.paused else self.live.latest()

    @property
    def words(self) -> str:
        """Say what is seen and what is waited for, where that is not just what comes."""
        past = self.live.now - self.zero
        if self.paused:
            return "Paused"
        if self.follows or math.isnan(past):
            return self.waiting
        if self.happened:
            return f"{self.happened} {past:.0f} s ago" + (", waiting" if self.waiting else "")
        return f"{max(past - self.right, 0.0):.0f} s back"

    def set_history(self, history: History) -> None:
        """Show another history."""
        self.live = history
        self.history = history.copy() if self.paused else history
        self._zero = self.history.now if self.paused else None
        self._show(-self.span, 0.0)

    def set_paused(self, paused: bool) -> None:
        """Let the picture stand with what there is now, or follow again."""
        if paused == self.paused:
            return
        self.paused = paused
        if paused:
            self._zero, self._paused_at = self.zero, self.live.latest()
            self.history = self.live.copy() if self.history is self.live else self.history
            self.changed.emit()
        else:
            self.follow()

    def set_locked(self, locked: bool) -> None:
        """Let the value axes change only by hand, or by themselves as well."""
        self.locked = locked
        self.changed.emit()

    def set_waiting(self, words: str, level: tuple[str, float] | None) -> None:
        """Say what a trigger waits for, and show its level."""
        self.waiting, self.level = words, level
        self.changed.emit()

    def set_span(self, seconds: float) -> None:
        """Show so many s: zero, or the end next to it, keeps its place in the frame."""
        place = min(max(0.0, self.left), self.right)
        left = place - (place - self.left) / self.span * seconds
        self._show(left, left + seconds)

    def follow(self, span: float | None = None) -> None:
        """Go back to the newest sample; nothing while paused."""
        if not self.paused:
            self.history, self._zero, self.happened = self.live, None, ""
            self._show(-(span or self.span), 0.0)

    def stand(self, time: float, before: float, happened: str) -> None:
        """Stand at an event at a time in s, such a part of the span before it; what follows still comes."""
        self.history, self._zero, self.happened = self.live, time, happened
        self._show(-before * self.span, (1.0 - before) * self.span)

    def move(self, left: float, right: float) -> None:
        """Show what a person zoomed or panned to; at the newest sample it follows again.

        An event stays in sight: it stands for what is compared with it.
        """
        if (left, right) == (self.left, self.right):
            return
        oldest, newest = self.history.start - self.zero, self.history.now - self.zero
        span = right - left
        zoomed, some = not math.isclose(span, self.span, rel_tol=1e-6), _SOME * span
        behind = right < newest - zoomed * some
        if not (behind or self.happened or self.paused):
            self.follow(span)
            return
        self._zero, last = self.zero, max(newest, self.right)
        right = min(max(right, oldest + some), last)
        self._show(max(right - span, min(oldest, last - SPANS[-1])), right)

    def keep(self) -> None:
        """Keep what stands before the live history forgets it; call at least once a second."""
        live = self.live
        if self.follows or self.history is not live:
            return
        start, stop = self.zero + self.left, self.zero + self.right
        if not live.start <= stop:  # begun anew meanwhile: nothing of it is left
            self.follow()
        elif live.now - start > live.seconds - _KEPT_AHEAD:
            self.history = live.copy()

    def _show(self, left: float, right: float) -> None:
        self.left, self.right = left, right
        self.changed.emit()

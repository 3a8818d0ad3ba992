"""Determines which interval of the history the plots show: the newest samples, or a fixed interval."""

import math

from PySide6.QtCore import QObject, Signal

from hapkit_studio.gui.live.history import History, LiveHistory

SPANS = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0)  # s: time windows that the toolbar offers
# Fraction of the span. At least this much of the data stays visible when the user pans; if a zoomed view ends
# this close to the newest sample, the view keeps following the newest sample.
_SOME = 0.05
_COPY_MARGIN = 1.0  # s: a fixed interval is copied this long before the history drops its samples


class TimeView(QObject):
    """The common time axis of all plots, from ``left`` to ``right`` in s relative to ``zero``.

    ``history`` is the history that the plots show. It is a copy of the live history while the view is paused,
    and while it shows samples that the live history drops.
    """

    changed = Signal()

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.live: History = LiveHistory(seconds=1.0, rate=1.0)
        self.history: History = self.live
        self.left, self.right = -10.0, 0.0
        self.paused = self.locked = False
        self.happened = ""
        """Description of the event at zero; "" if there is no event."""
        self.waiting = ""
        """Description of what the trigger waits for."""
        self.level: tuple[str, float] | None = None
        """The trigger's level: channel and value in SI."""
        self._zero: float | None = None
        self._paused_at: dict[str, float] = {}

    @property
    def follows(self) -> bool:
        """Return whether the view follows the newest sample."""
        return self._zero is None

    @property
    def zero(self) -> float:
        """Return the time in s of the axis' zero; NaN without samples.

        While the view follows, zero is the newest sample.
        """
        return self.history.now if self._zero is None else self._zero

    @property
    def span(self) -> float:
        """Return the length of the time axis in s."""
        return self.right - self.left

    @property
    def stretch(self) -> tuple[float, float]:
        """Return start and stop in s of the visible samples."""
        return self.zero + self.left, min(self.zero + self.right, self.history.now)

    @property
    def latest(self) -> dict[str, float]:
        """Return the newest value of every channel (while paused, the value at the pause).

        Return NaN without samples.
        """
        return self._paused_at if self.paused else self.live.latest()

    @property
    def status(self) -> str:
        """Describe what the plots show and what the trigger waits for; "" while following live data."""
        past = self.live.now - self.zero
        if self.paused:
            return "Plots paused"
        if self.follows or math.isnan(past):
            return self.waiting
        if self.happened:
            return f"{self.happened} {past:.0f} s ago" + (", waiting" if self.waiting else "")
        return f"{max(past - self.right, 0.0):.0f} s ago"

    def set_history(self, history: History) -> None:
        """Show another history."""
        self.live = history
        self.history = history.copy() if self.paused else history
        self._zero = self.history.now if self.paused else None
        self._show(-self.span, 0.0)

    def set_paused(self, paused: bool) -> None:
        """Pause at the current samples, or follow again."""
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
        """Lock or unlock the value axes; locked axes do not adapt to the data. Only the user changes them."""
        self.locked = locked
        self.changed.emit()

    def set_waiting(self, text: str, level: tuple[str, float] | None) -> None:
        """Set the description of the event that a trigger waits for, and the trigger's level."""
        self.waiting, self.level = text, level
        self.changed.emit()

    def set_span(self, seconds: float) -> None:
        """Show this many seconds; time zero, or the edge nearest to it, keeps its position on the screen."""
        place = min(max(0.0, self.left), self.right)
        left = place - (place - self.left) / self.span * seconds
        self._show(left, left + seconds)

    def follow(self, span: float | None = None) -> None:
        """Return to the newest sample; this is a no-op while paused."""
        if not self.paused:
            self.history, self._zero, self.happened = self.live, None, ""
            self._show(-(span or self.span), 0.0)

    def stand(self, time: float, before: float, happened: str) -> None:
        """Stop the view at an event at a time in s; show the event at the fraction ``before`` of the span.

        The live history still receives samples.
        """
        self.history, self._zero, self.happened = self.live, time, happened
        self._show(-before * self.span, (1.0 - before) * self.span)

    def move(self, left: float, right: float) -> None:
        """Apply the user's zoom or pan; a view that reaches the newest sample follows it again.

        A view at an event never follows, so that the event stays visible.
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

    def keep_samples(self) -> None:
        """Copy the history before it drops the samples of a fixed view.

        Must be called at least once a second.
        """
        live = self.live
        if self.follows or self.history is not live:
            return
        start, stop = self.zero + self.left, self.zero + self.right
        if not live.start <= stop:  # the history was cleared meanwhile
            self.follow()
        elif live.now - start > live.seconds - _COPY_MARGIN:
            self.history = live.copy()

    def _show(self, left: float, right: float) -> None:
        self.left, self.right = left, right
        self.changed.emit()

"""The last minute of telemetry, kept so that any stretch is drawn in time proportional to its width.

Samples lie in order in one array twice as long as what is kept; when it is full the kept half moves to the
front. Beside it stands a pyramid: the least and greatest of every 16, 256, 4096 samples, grown as rows come.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows

CHANNELS = {
    "position": rows.POSITION,
    "velocity": rows.VELOCITY,
    "asked": rows.ASKED,
    "applied": rows.APPLIED,
}
_COLUMNS = np.array(list(CHANNELS.values()))
_BRANCH = 16
_LEVELS = 3
_TOP = _BRANCH**_LEVELS
_DIRECT = 64  # elements a column may hold before the next level up is cheaper than a reduction


@dataclass(frozen=True)
class Window:
    """A stretch ready to draw: x (m,) in s, y[channel] (m,); NaN in both where frames were lost.

    In a dense window each column gives two points, its least and its greatest value in the order that
    follows the trend, at a quarter and three quarters of its width; otherwise every point is a sample.
    """

    x: np.ndarray
    y: dict[str, np.ndarray]
    dense: bool


class History:
    """Ring of the channels the plots show; ``append`` takes telemetry rows as the reader gives them."""

    def __init__(self, seconds: float = 60.0, rate: float = 10000.0):
        """Make room for this many seconds at this rate in Hz."""
        self.seconds = seconds
        self.capacity = -int(-seconds * rate // _TOP) * _TOP
        room = 2 * self.capacity + _TOP
        self._time = np.empty(room)
        self._data = np.empty((len(CHANNELS), room))
        sizes = [room // _BRANCH**level for level in range(1, _LEVELS + 1)]
        self._least = [self._data, *(np.empty((len(CHANNELS), size)) for size in sizes)]
        self._greatest = [self._data, *(np.empty((len(CHANNELS), size)) for size in sizes)]
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._begin = self._end = 0
        self._dropped = 0
        self._tick = np.nan
        self._breaks: list[int] = []

    def __len__(self) -> int:
        return self._end - self._begin

    @property
    def total(self) -> int:
        """How many samples were ever taken since the last clear; grows with every append."""
        return self._dropped + self._end

    @property
    def start(self) -> float:
        """Time of the oldest sample in s; NaN when empty."""
        return float(self._time[self._begin]) if len(self) else np.nan

    @property
    def now(self) -> float:
        """Time of the newest sample in s; NaN when empty."""
        return float(self._time[self._end - 1]) if len(self) else np.nan

    def latest(self) -> dict[str, float]:
        """Return every channel's newest value; NaN when empty."""
        newest = self._data[:, self._end - 1].tolist() if len(self) else [np.nan] * len(CHANNELS)
        return dict(zip(CHANNELS, newest, strict=True))

    def last(self, channel: str) -> float:
        """Return a channel's newest value; NaN when empty."""
        return self.latest()[channel]

    def append(self, new: np.ndarray) -> None:
        """Take (n, ROW_WIDTH) telemetry rows, oldest first; a clock that goes back starts afresh."""
        if not len(new):
            return
        if len(self) and new[0, rows.HOST_TIME] < self.now:
            self.clear()
        for part in range(0, len(new), _TOP):
            self._take(new[part : part + _TOP])

    def _take(self, new: np.ndarray) -> None:
        if self._end + len(new) > len(self._time):
            self._make_room()
        first, self._end = self._end, self._end + len(new)
        self._time[first : self._end] = new[:, rows.HOST_TIME]
        self._data[:, first : self._end] = new[:, _COLUMNS].T
        self._note_breaks(new, first)
        self._grow(first)
        self._forget()

    def _note_breaks(self, new: np.ndarray, first: int) -> None:
        jumps = np.diff(new[:, rows.TICK], prepend=self._tick) > 1.5
        flagged = new[:, rows.FLAGS].astype(np.int64) & rows.GAP > 0
        lost = np.flatnonzero(jumps | flagged) + first
        self._breaks += [int(i) for i in lost if i > 0]
        self._tick = new[-1, rows.TICK]

    def _grow(self, first: int) -> None:
        """Complete the pyramid's blocks that the samples from first on have filled."""
        for level in range(1, _LEVELS + 1):
            size = _BRANCH**level
            a, b = first // size, self._end // size
            if b > a:
                span = slice(a * _BRANCH, b * _BRANCH)
                shape = (len(CHANNELS), b - a, _BRANCH)
                self._least[level][:, a:b] = self._least[level - 1][:, span].reshape(shape).min(axis=2)
                self._greatest[level][:, a:b] = self._greatest[level - 1][:, span].reshape(shape).max(axis=2)

    def _forget(self) -> None:
        oldest = max(self._end - self.capacity, self._begin)
        oldest += int(np.searchsorted(self._time[oldest : self._end], self.now - self.seconds))
        self._begin = oldest
        while self._breaks and self._breaks[0] <= oldest:
            self._breaks.pop(0)

    def _make_room(self) -> None:
        """Move the kept samples to the front, by whole blocks so that the pyramid moves along."""
        shift = self._begin // _TOP * _TOP
        kept = self._end - shift
        self._time[:kept] = self._time[shift : self._end]
        self._data[:, :kept] = self._data[:, shift : self._end]
        for level in range(1, _LEVELS + 1):
            size = _BRANCH**level
            for table in (self._least[level], self._greatest[level]):
                table[:, : kept // size] = table[:, shift // size : (shift + kept) // size].copy()
        self._breaks = [i - shift for i in self._breaks if i > shift]
        self._begin, self._end, self._dropped = self._begin - shift, kept, self._dropped + shift

    def copy(self) -> "History":
        """Return what is kept now, to look at while this one goes on filling."""
        other = History.__new__(History)
        other.__dict__.update(self.__dict__)
        lead = self._begin // _TOP * _TOP
        other._time = self._time[lead : self._end].copy()
        other._data = self._data[:, lead : self._end].copy()
        for name in ("_least", "_greatest"):
            upper = [
                table[:, lead // _BRANCH**level : self._end // _BRANCH**level].copy()
                for level, table in enumerate(getattr(self, name)[1:], start=1)
            ]
            setattr(other, name, [other._data, *upper])
        other._breaks = [i - lead for i in self._breaks]
        other._begin, other._end, other._dropped = self._begin - lead, self._end - lead, self._dropped + lead
        return other

    def between(self, t0: float, t1: float) -> Window:
        """Return every sample with t0 <= time < t1."""
        a, b = self._indices(np.array([t0, t1]))
        return self._broken(self._time[a:b], self._data[:, a:b], self._breaks_in(a, b) - a, False)

    def since(self, total: int) -> Window:
        """Return every sample taken after ``self.total`` was total."""
        a, b = min(max(total - self._dropped, self._begin), self._end), self._end
        return self._broken(self._time[a:b], self._data[:, a:b], self._breaks_in(a, b) - a, False)

    def at(self, time: float) -> dict[str, float] | None:
        """Return every channel's value at the last sample up to a time in s; None before the first."""
        i = self._begin + int(np.searchsorted(self._time[self._begin : self._end], time, side="right")) - 1
        if i < self._begin:
            return None
        return {name: float(self._data[row, i]) for row, name in enumerate(CHANNELS)}

    def window(self, edges: np.ndarray, dense: bool | None = None) -> Window:
        """Return [edges[0], edges[-1]) with the samples between each two edges (s) reduced to a column.

        Each column keeps its least and greatest sample. Where columns hold two samples or fewer, the samples
        themselves are given, unless dense says otherwise.
        """
        places = self._indices(edges)
        if dense is None:
            dense = bool(places[-1] - places[0] > 2 * (len(edges) - 1))
        return self._columns(edges, places) if dense else self._samples(int(places[0]), int(places[-1]))

    def _columns(self, edges: np.ndarray, places: np.ndarray) -> Window:
        filled = np.flatnonzero(places[1:] > places[:-1])
        if not len(filled):
            return Window(np.empty(0), {name: np.empty(0) for name in CHANNELS}, True)
        first, stop = places[filled], places[filled + 1]
        y = np.empty((len(CHANNELS), 2 * len(filled)))
        least, greatest = self._extremes(first, stop)
        rising = self._data[:, stop - 1] >= self._data[:, first]
        y[:, 0::2] = np.where(rising, least, greatest)
        y[:, 1::2] = np.where(rising, greatest, least)
        left, width = edges[filled], edges[filled + 1] - edges[filled]
        x = np.stack([left + 0.25 * width, left + 0.75 * width], axis=1).ravel()
        lost = self._breaks_in(int(first[0]), int(stop[-1]))
        return self._broken(x, y, np.unique(2 * (np.searchsorted(first, lost, side="right") - 1)), True)

    def _indices(self, times: np.ndarray) -> np.ndarray:
        return self._begin + np.searchsorted(self._time[self._begin : self._end], times)

    def _breaks_in(self, first: int, stop: int) -> np.ndarray:
        breaks = np.array(self._breaks, dtype=np.int64)
        return breaks[(breaks >= first) & (breaks < stop)]

    def _samples(self, first: int, stop: int) -> Window:
        """Return single samples, with one more at each side so that lines reach the edge."""
        first, stop = max(first - 1, self._begin), min(stop + 1, self._end)
        cuts = self._breaks_in(first, stop) - first
        return self._broken(self._time[first:stop], self._data[:, first:stop], cuts, False)

    def _broken(self, x: np.ndarray, y: np.ndarray, cuts: np.ndarray, dense: bool) -> Window:
        if len(cuts):
            x, y = np.insert(x, cuts, np.nan), np.insert(y, cuts, np.nan, axis=1)
        return Window(x, {name: y[row] for row, name in enumerate(CHANNELS)}, dense)

    def _extremes(self, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return least and greatest (channels, m) of the non-empty ranges [first, stop)."""
        parts = list(self._parts(first, stop))
        least = np.fmin.reduce([p[0] for p in parts])
        return least, np.fmax.reduce([p[1] for p in parts])

    def _parts(self, first: np.ndarray, stop: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Split ranges over the pyramid: ragged ends from each level, the middle from the next one up."""
        level = 0
        while level < _LEVELS and (stop - first).mean() > _DIRECT:
            yield self._ends(level, first, stop)
            first, stop = -(-first // _BRANCH), stop // _BRANCH
            level += 1
        yield self._middle(level, first, stop)

    def _ends(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of each range's first and last 16 elements; NaN where it is empty."""
        steps = np.arange(_BRANCH)
        left = np.minimum(first[:, None] + steps, stop[:, None] - 1)
        right = np.maximum(stop[:, None] - 1 - steps, first[:, None])
        which = np.clip(np.concatenate([left, right], axis=1), 0, None)
        empty = stop <= first
        return tuple(  # type: ignore[return-value]
            np.where(empty, np.nan, pick(np.take(table[level], which, axis=1), axis=2))
            for table, pick in ((self._least, np.min), (self._greatest, np.max))
        )

    def _middle(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of ranges by one pass over them; NaN where a range is empty."""
        full = stop > first
        out = np.full((2, len(CHANNELS), len(first)), np.nan)
        if full.any():
            a, b = int(first[full][0]), int(stop[full][-1])
            cuts = np.stack([first[full], stop[full]], axis=1).ravel() - a
            cuts = cuts[:-1]
            for k, (table, ufunc) in enumerate(((self._least, np.minimum), (self._greatest, np.maximum))):
                out[k][:, full] = ufunc.reduceat(table[level][:, a:b], cuts, axis=1)[:, 0::2]
        return out[0], out[1]


class Reel:
    """A window that rolls on: columns that are complete are kept, only the newest are reduced again."""

    def __init__(self) -> None:
        self._kept = Window(np.empty(0), {}, False)
        self._width, self._count, self._until, self._total = 0.0, 0, 0, 0

    def window(self, history: History, first: int, count: int, width: float) -> Window:
        """Return history's window of so many columns, each width s wide; column n starts at n * width."""
        rolls = self._kept.dense and (width, count) == (self._width, self._count)
        rolls = rolls and history.total >= self._total and first < self._until <= first + count
        shown = self._roll(history, first, first + count, width) if rolls else None
        if shown is None:
            shown = history.window(np.arange(first, first + count + 1) * width)
        self._kept, self._width, self._count, self._total = shown, width, count, history.total
        done = int(np.floor(history.now / width)) - 1 if len(history) else first
        self._until = min(first + count, done)
        return shown

    def _roll(self, history: History, first: int, stop: int, width: float) -> Window | None:
        fresh = history.window(np.arange(self._until, max(stop, self._until + 1) + 1) * width, dense=True)
        x = self._kept.x
        a, b = np.argmax(x >= first * width), np.argmax(np.append(x, np.inf) >= self._until * width)
        b -= bool(b) and bool(np.isnan(x[b - 1]))  # the break before the newest columns comes with them
        if not len(fresh.x) or b <= a:
            return None
        y = {name: np.concatenate([old[a:b], fresh.y[name]]) for name, old in self._kept.y.items()}
        return Window(np.concatenate([x[a:b], fresh.x]), y, True)

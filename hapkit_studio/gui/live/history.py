"""The last minute of telemetry, kept so that any stretch is drawn in time proportional to its width.

Samples lie in order in one array twice as long as what is kept; when it is full the kept half moves to the
front. Beside it stands a min–max pyramid: the extremes of every 16, 256 and 4096 samples, completed as
they come. A RollingWindow reduces only the newest columns again.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows

BRANCH = 16
LEVELS = 3
BLOCK = BRANCH**LEVELS
_DIRECT = 64  # elements a range may hold before the next level up is cheaper than reading them
CHANNELS = {
    "position": rows.POSITION,
    "velocity": rows.VELOCITY,
    "asked": rows.ASKED,
    "applied": rows.APPLIED,
}
ENERGIES = ("energy", "energy_limit")  # not in the rows: the engine keeps them, nan where it has none
_COLUMNS = np.array(list(CHANNELS.values()))
_NAMES = (*CHANNELS, *ENERGIES)


class Pyramid:
    """Extremes over samples (channels, room); whoever writes the samples says so with ``grow``."""

    def __init__(self, samples: np.ndarray, upper: list[tuple[np.ndarray, np.ndarray]] | None = None):
        channels, room = samples.shape
        if upper is None:
            sizes = [room // BRANCH**level for level in range(1, LEVELS + 1)]
            upper = [(np.empty((channels, size)), np.empty((channels, size))) for size in sizes]
        self.levels = [(samples, samples), *upper]

    def grow(self, first: int, end: int) -> None:
        """Complete the blocks that the samples [first, end) have filled."""
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            a, b = first // size, end // size
            if b == a:
                return
            for table, below, pick in zip(
                self.levels[level], self.levels[level - 1], (np.fmin, np.fmax), strict=True
            ):
                span = below[:, a * BRANCH : b * BRANCH]
                table[:, a:b] = pick.reduce(span.reshape(len(span), b - a, BRANCH), axis=2)

    def shift(self, by: int, end: int) -> None:
        """Move everything but the samples forward by a multiple of BLOCK; end is the samples' end before."""
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            for table in self.levels[level]:
                table[:, : (end - by) // size] = table[:, by // size : end // size].copy()

    def part(self, samples: np.ndarray, first: int, end: int) -> "Pyramid":
        """Return a copy over samples, which hold [first, end) of this one's; first is a multiple of BLOCK."""
        upper = []
        for level in range(1, LEVELS + 1):
            size = BRANCH**level
            least, greatest = (table[:, first // size : end // size].copy() for table in self.levels[level])
            upper.append((least, greatest))
        return Pyramid(samples, upper)

    def extremes(self, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return least and greatest (channels, m) of the m non-empty, rising ranges [first, stop)."""
        parts = list(self._parts(first, stop))
        return np.fmin.reduce([part[0] for part in parts]), np.fmax.reduce([part[1] for part in parts])

    def _parts(self, first: np.ndarray, stop: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Split ranges over the levels: ragged ends from each, the middle from the next one up."""
        level = 0
        while level < LEVELS and (stop - first).mean() > _DIRECT:
            yield self._ends(level, first, stop)
            first, stop = -(-first // BRANCH), stop // BRANCH
            level += 1
        yield self._middle(level, first, stop)

    def _ends(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of each range's first and last 16 elements; NaN where it is empty."""
        steps = np.arange(BRANCH)
        left = np.minimum(first[:, None] + steps, stop[:, None] - 1)
        right = np.maximum(stop[:, None] - 1 - steps, first[:, None])
        which = np.clip(np.concatenate([left, right], axis=1), 0, None)
        least, greatest = self.levels[level]
        empty = stop <= first
        return (
            np.where(empty, np.nan, np.fmin.reduce(np.take(least, which, axis=1, mode="clip"), axis=2)),
            np.where(empty, np.nan, np.fmax.reduce(np.take(greatest, which, axis=1, mode="clip"), axis=2)),
        )

    def _middle(self, level: int, first: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the extremes of ranges by one pass over them; NaN where a range is empty."""
        full = stop > first
        least, greatest = self.levels[level]
        out = np.full((2, len(least), len(first)), np.nan)
        if full.any():
            span = slice(int(first[full][0]), int(stop[full][-1]))
            cuts = np.stack([first[full], stop[full]], axis=1).ravel()[:-1] - span.start
            out[0][:, full] = np.fmin.reduceat(least[:, span], cuts, axis=1)[:, 0::2]
            out[1][:, full] = np.fmax.reduceat(greatest[:, span], cuts, axis=1)[:, 0::2]
        return out[0], out[1]


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
        self.capacity = -int(-seconds * rate // BLOCK) * BLOCK
        room = 2 * self.capacity + BLOCK
        self._time = np.empty(room)
        self._data = np.empty((len(_NAMES), room))
        self._pyramid = Pyramid(self._data)
        self.epoch = 0
        self.clear()

    def clear(self) -> None:
        """Forget everything; ``epoch`` counts how often."""
        self.epoch += 1
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
        newest = self._data[:, self._end - 1].tolist() if len(self) else [np.nan] * len(_NAMES)
        return dict(zip(_NAMES, newest, strict=True))

    def last(self, channel: str) -> float:
        """Return a channel's newest value; NaN when empty."""
        return self.latest()[channel]

    def append(self, new: np.ndarray, energies: np.ndarray | None = None) -> None:
        """Take (n, ROW_WIDTH) telemetry rows, oldest first, and their (n, 2) energies and limits in J.

        A clock that goes back starts afresh.
        """
        if not len(new):
            return
        if len(self) and new[0, rows.HOST_TIME] < self.now:
            self.clear()
        for part in range(0, len(new), BLOCK):
            beside = 0.0 if energies is None else energies[part : part + BLOCK].T
            self._take(new[part : part + BLOCK], beside)

    def _take(self, new: np.ndarray, energies: np.ndarray | float) -> None:
        if self._end + len(new) > len(self._time):
            self._make_room()
        first, self._end = self._end, self._end + len(new)
        self._time[first : self._end] = new[:, rows.HOST_TIME]
        self._data[: len(CHANNELS), first : self._end] = new[:, _COLUMNS].T
        self._data[len(CHANNELS) :, first : self._end] = energies
        self._note_breaks(new, first)
        self._pyramid.grow(first, self._end)
        self._forget()

    def _note_breaks(self, new: np.ndarray, first: int) -> None:
        tick, flags = new[:, rows.TICK], new[:, rows.FLAGS]
        lost = np.flatnonzero(np.abs(tick[1:] - tick[:-1] - 1.0) > 0.5) + first + 1
        if abs(tick[0] - self._tick - 1.0) > 0.5:
            lost = np.append(lost, first)
        if flags.any():
            flagged = np.flatnonzero(flags.astype(np.int64) & rows.GAP)
            lost = np.union1d(lost, flagged + first)
        self._breaks += sorted(int(i) for i in lost if i > 0)
        self._tick = new[-1, rows.TICK]

    def _forget(self) -> None:
        oldest = max(self._end - self.capacity, self._begin)
        oldest += int(np.searchsorted(self._time[oldest : self._end], self.now - self.seconds))
        self._begin = oldest
        while self._breaks and self._breaks[0] <= oldest:
            self._breaks.pop(0)

    def _make_room(self) -> None:
        """Move the kept samples to the front, by whole blocks so that the pyramid moves along."""
        shift = self._begin // BLOCK * BLOCK
        kept = self._end - shift
        self._time[:kept] = self._time[shift : self._end]
        self._data[:, :kept] = self._data[:, shift : self._end]
        self._pyramid.shift(shift, self._end)
        self._breaks = [i - shift for i in self._breaks if i > shift]
        self._begin, self._end, self._dropped = self._begin - shift, kept, self._dropped + shift

    def copy(self) -> "History":
        """Return what is kept now, to look at while this one goes on filling."""
        other = History.__new__(History)
        other.__dict__.update(self.__dict__)
        lead = self._begin // BLOCK * BLOCK
        other._time = self._time[lead : self._end].copy()
        other._data = self._data[:, lead : self._end].copy()
        other._pyramid = self._pyramid.part(other._data, lead, self._end)
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
        return {name: float(self._data[row, i]) for row, name in enumerate(_NAMES)}

    def before(self, time: float) -> float:
        """Return the time of the last sample before a time, both in s; NaN before the first."""
        i = int(np.searchsorted(self._time[self._begin : self._end], time)) - 1
        return float(self._time[self._begin + i]) if i >= 0 else np.nan

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
            return Window(np.empty(0), {name: np.empty(0) for name in _NAMES}, True)
        first, stop = places[filled], places[filled + 1]
        y = np.empty((len(_NAMES), 2 * len(filled)))
        least, greatest = self._pyramid.extremes(first, stop)
        rising = self._data[:, stop - 1] >= self._data[:, first]
        y[:, 0::2] = np.where(rising, least, greatest)
        y[:, 1::2] = np.where(rising, greatest, least)
        left, width = edges[filled], edges[filled + 1] - edges[filled]
        x = np.stack([left + 0.25 * width, left + 0.75 * width], axis=1).ravel()
        begun = np.flatnonzero(np.isnan(self._data[-1, first[0] : stop[-1]])) + first[0]
        anew = 2 * (np.searchsorted(first, begun, side="right") - 1)
        y[len(CHANNELS) :, anew] = y[len(CHANNELS) :, anew + 1] = np.nan
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
        return Window(x, {name: y[row] for row, name in enumerate(_NAMES)}, dense)


class RollingWindow:
    """A window that rolls on: columns that are complete are kept, only the newest are reduced again."""

    def __init__(self) -> None:
        self._kept = Window(np.empty(0), {}, False)
        self._key: tuple[float, int, int] = (0.0, 0, 0)
        self._until = 0

    def window(self, history: History, first: int, count: int, width: float) -> Window:
        """Return history's window of so many columns, each width s wide; column n starts at n * width."""
        key = (width, count, history.epoch)
        rolls = self._kept.dense and key == self._key and first < self._until <= first + count
        shown = self._roll(history, first, first + count, width) if rolls else None
        if shown is None:
            shown = history.window(np.arange(first, first + count + 1) * width)
        self._kept, self._key = shown, key
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

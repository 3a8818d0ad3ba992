"""The last minute of telemetry, and any stretch of it reduced to the extremes of each pixel's column.

Samples lie in order in one array twice as long as what is kept; when it is full the kept half moves to the
front. Every frame reduces its stretch anew: 0.2 ms for 10 s at 1 kHz, 1.2 ms for 60 s at 4 kHz.
"""

import math
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows

_AT_ONCE = 4096  # samples that are taken at a time
CHANNELS = {
    "position": rows.POSITION,
    "velocity": rows.VELOCITY,
    "force": rows.FORCE,
    "applied_force": rows.APPLIED_FORCE,
}
OBJECT = "object"  # the place of what moves besides the handle, nan where nothing does
ENERGIES = ("energy", "energy_limit")  # not in the rows: the engine keeps them, nan where it has none
_COLUMNS = np.array(list(CHANNELS.values()))
_NAMES = (*CHANNELS, OBJECT, *ENERGIES)
_ENERGY = len(CHANNELS) + 1


@dataclass(frozen=True)
class Window:
    """A stretch ready to draw: x (m,) in s, y[channel] (m,); NaN in both where frames were lost.

    In a dense window each column gives two points, its least and its greatest value in the order that
    follows the trend, at a quarter and three quarters of its width; otherwise every point is a sample.
    """

    x: np.ndarray
    y: dict[str, np.ndarray]
    dense: bool

    def known(self) -> "Window":
        """Return a copy without the breaks."""
        known = np.isfinite(self.x)
        return Window(self.x[known], {name: values[known] for name, values in self.y.items()}, self.dense)


class History:
    """Ring of the channels the plots show; ``append`` takes telemetry rows as the reader gives them."""

    complete = True
    """Whether all that is kept is given to those who ask."""

    def __init__(self, seconds: float = 60.0, rate: float = 10000.0):
        """Make room for this many seconds at this rate in Hz."""
        self.seconds = seconds
        self.capacity = math.ceil(seconds * rate) + 1
        size = 2 * self.capacity + _AT_ONCE
        self._time = np.empty(size)
        self._data = np.empty((len(_NAMES), size))
        self.clear()

    @classmethod
    def of(cls, time: np.ndarray, channels: np.ndarray, breaks: list[int]) -> "History":
        """Return one that holds samples: times (n,) in s, CHANNELS (4, n), and where lines break."""
        made = cls(0.0, 0.0)
        made._time, made._breaks, made._end = time, breaks, len(time)
        made._data = np.full((len(_NAMES), len(time)), np.nan)
        made._data[: len(CHANNELS)] = channels
        return made

    def clear(self) -> None:
        """Forget everything."""
        self._drop_samples()
        self.dividers: list[tuple[float, str]] = []
        """What was changed while these samples came: when, in s, and in words, the oldest first."""
        self.changes: list[float] = [-math.inf]
        """When settings changed, in s, the oldest first; what is older than the samples is one."""
        self.begin = -math.inf
        """Time in s from which on all samples are of the environment in force."""

    def _drop_samples(self) -> None:
        self._begin = self._end = 0
        self._tick = np.nan
        self._breaks: list[int] = []

    def __len__(self) -> int:
        return self._end - self._begin

    @property
    def start(self) -> float:
        """Time of the oldest sample in s; NaN when empty."""
        return float(self._time[self._begin]) if len(self) else np.nan

    @property
    def now(self) -> float:
        """Time of the newest sample in s; NaN when empty."""
        return float(self._time[self._end - 1]) if len(self) else np.nan

    def divide(self, words: str, time: float | None = None, instead: float | None = None) -> None:
        """Note what happened at a time in s, now if none is given, in place of what was noted for it.

        instead: in place of what was noted for this time, too. Without words nothing new is noted.
        """
        at = self.now if time is None else time
        if len(self):
            others = [(when, was) for when, was in self.dividers if when not in (at, instead)]
            self.dividers = sorted([*others, (at, words)] if words else others)

    def begin_anew(self) -> None:
        """Count what came up to now as another environment's."""
        self.begin = math.nextafter(self.now, math.inf) if len(self) else -math.inf

    def latest(self) -> dict[str, float]:
        """Return every channel's newest value; NaN when empty."""
        newest = self._data[:, self._end - 1].tolist() if len(self) else [np.nan] * len(_NAMES)
        return dict(zip(_NAMES, newest, strict=True))

    def append(
        self, new: np.ndarray, energies: np.ndarray | None = None, places: np.ndarray | None = None
    ) -> None:
        """Take (n, ROW_WIDTH) telemetry rows, oldest first, and their (n, 2) energies and limits in J.

        places (n,) in m: of the object that moves besides the handle, None where there is none. A clock that
        goes back starts afresh.
        """
        if not len(new):
            return
        if len(self) and new[0, rows.HOST_TIME] < self._time[self._end - 1]:
            self.clear()
        for part in range(0, len(new), _AT_ONCE):
            some = slice(part, part + _AT_ONCE)
            beside = 0.0 if energies is None else energies[some].T
            self._take(new[some], beside, np.nan if places is None else places[some])

    def _take(self, new: np.ndarray, energies: np.ndarray | float, places: np.ndarray | float) -> None:
        if self._end + len(new) > len(self._time):
            self._move_to_front()
        first, self._end = self._end, self._end + len(new)
        self._time[first : self._end] = new[:, rows.HOST_TIME]
        self._data[: len(CHANNELS), first : self._end] = new[:, _COLUMNS].T
        self._data[len(CHANNELS), first : self._end] = places
        self._data[_ENERGY:, first : self._end] = energies
        self._note_breaks(new, first)
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
        earliest = self._time[self._end - 1] - self.seconds
        oldest += int(np.searchsorted(self._time[oldest : self._end], earliest))
        self._begin = oldest
        while self._breaks and self._breaks[0] <= oldest:
            self._breaks.pop(0)
        while self.dividers and self.dividers[0][0] < self.start:
            self.dividers.pop(0)
        while len(self.changes) > 1 and self.changes[1] < self.start:
            self.changes.pop(0)

    def _move_to_front(self) -> None:
        """Move the kept samples to the front."""
        shift, kept = self._begin, len(self)
        # channel by channel: numpy copies a table first, and the heap keeps the room that took
        for values in (self._time, *self._data):
            values[:kept] = values[shift : self._end]
        self._breaks = [i - shift for i in self._breaks if i > shift]
        self._begin, self._end = 0, kept

    def copy(self) -> "History":
        """Return what is kept now, to look at while this one goes on filling."""
        other = History.__new__(History)
        other.__dict__.update(self.__dict__)
        lead = self._begin
        other._time = self._time[lead : self._end].copy()
        other._data = self._data[:, lead : self._end].copy()
        other._breaks = [i - lead for i in self._breaks]
        other.dividers, other.changes = [*self.dividers], [*self.changes]
        other._begin, other._end = 0, len(self)
        return other

    def between(self, t0: float, t1: float) -> Window:
        """Return every sample with t0 <= time < t1."""
        return self._samples(*self._indices(np.array([t0, t1])))

    def drawn(self, t0: float, t1: float) -> Window:
        """Return what is to be drawn of t0 <= time < t1 point by point: every sample."""
        return self.between(t0, t1)

    def at(self, time: float) -> dict[str, float] | None:
        """Return every channel's value at the last sample up to a time in s; None before the first."""
        i = self._begin + int(np.searchsorted(self._time[self._begin : self._end], time, side="right")) - 1
        return dict(zip(_NAMES, self._data[:, i].tolist(), strict=True)) if i >= self._begin else None

    def before(self, time: float) -> float:
        """Return the time of the last sample before a time, both in s; NaN before the first."""
        i = int(np.searchsorted(self._time[self._begin : self._end], time)) - 1
        return float(self._time[self._begin + i]) if i >= 0 else np.nan

    def window(self, edges: np.ndarray) -> Window:
        """Return [edges[0], edges[-1]) with the samples between each two edges (s) reduced to a column.

        Each column keeps its least and greatest sample. Where columns hold two samples or fewer, the samples
        themselves are given, with one more at each side so that lines reach the edge.
        """
        places = self._indices(edges)
        if places[-1] - places[0] > 2 * (len(edges) - 1):
            return self._columns(edges, places)
        return self._samples(max(places[0] - 1, self._begin), min(places[-1] + 1, self._end))

    def _columns(self, edges: np.ndarray, places: np.ndarray) -> Window:
        filled = np.flatnonzero(places[1:] > places[:-1])
        if not len(filled):
            return Window(np.empty(0), {name: np.empty(0) for name in _NAMES}, True)
        first, stop = places[filled], places[filled + 1]
        y = np.empty((len(_NAMES), 2 * len(filled)))
        samples = self._data[:, first[0] : stop[-1]]
        least, greatest = (pick.reduceat(samples, first - first[0], axis=1) for pick in (np.fmin, np.fmax))
        rising = self._data[:, stop - 1] >= self._data[:, first]
        y[:, 0::2] = np.where(rising, least, greatest)
        y[:, 1::2] = np.where(rising, greatest, least)
        left, width = edges[filled], edges[filled + 1] - edges[filled]
        x = np.stack([left + 0.25 * width, left + 0.75 * width], axis=1).ravel()
        begun = np.logical_or.reduceat(np.isnan(samples[-1]), first - first[0])
        y[_ENERGY:, np.repeat(begun, 2)] = np.nan
        lost = self._breaks_in(int(first[0]), int(stop[-1]))
        return self._broken(x, y, np.unique(2 * (np.searchsorted(first, lost, side="right") - 1)), True)

    def _indices(self, times: np.ndarray) -> np.ndarray:
        return self._begin + np.searchsorted(self._time[self._begin : self._end], times)

    def _breaks_in(self, first: int, stop: int) -> np.ndarray:
        breaks = np.array(self._breaks, dtype=np.int64)
        return breaks[(breaks >= first) & (breaks < stop)]

    def _samples(self, first: int, stop: int) -> Window:
        cuts = self._breaks_in(first, stop) - first
        return self._broken(self._time[first:stop], self._data[:, first:stop], cuts, False)

    def _broken(self, x: np.ndarray, y: np.ndarray, cuts: np.ndarray, dense: bool) -> Window:
        if len(cuts):
            x, y = np.insert(x, cuts, np.nan), np.insert(y, cuts, np.nan, axis=1)
        return Window(x, {name: y[row] for row, name in enumerate(_NAMES)}, dense)

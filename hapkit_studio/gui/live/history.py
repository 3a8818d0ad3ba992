"""Histories: the samples that plots, cursors and trigger read, reduced to extremes per pixel on request.

``History`` is the interface of three classes: the live samples of the last minute (``LiveHistory``), samples
in memory (``Samples``), and a recorded session up to the replay position (recorded.py). The channels are the
signals that the plots show, so a new plot needs no entry here.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from hapkit_studio.gui.live.plots.declared import OBJECT, phase_plots, time_plots
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import BY_NAME, COLUMN

_ALWAYS = (
    "position",
    "velocity",
    "force",
    "applied_force",
    "energy",
)  # cursors, trigger and export need these signals even if no plot shows them
_AT_ONCE = 4096  # number of samples that are appended at a time
LATELY_SECONDS = 5.0  # s: the handle's highest speed is computed over this newest interval


@cache
def channels() -> tuple[str, ...]:
    """Return the names of the signals that a history stores; OBJECT is the last one."""
    traces = [trace for plot in (*time_plots(), *time_plots(beside=True)) for trace in plot.traces]
    shown = [*(trace.channel for trace in traces), *(plot.channel for plot in phase_plots())]
    return (*dict.fromkeys([*_ALWAYS, *(name for name in shown if name != OBJECT)]), OBJECT)


@dataclass(frozen=True)
class Window:
    """Samples that are ready to draw: x (m,) in s, y[channel] (m,); both are NaN at gaps.

    In a dense window each pixel column has two points, its minimum and maximum in the order of the trend, at
    a quarter and three quarters of its width. In other windows every point is a sample.
    """

    x: np.ndarray
    y: dict[str, np.ndarray]
    dense: bool

    def known(self) -> "Window":
        """Return a copy without gaps."""
        known = np.isfinite(self.x)
        return Window(self.x[known], {name: values[known] for name, values in self.y.items()}, self.dense)


class History(ABC):
    """Samples of ``channels()`` over time in s, and the changes of settings during this time."""

    seconds = math.inf
    """Age in s at which samples are dropped."""
    complete = True
    """False while the user drags the replay position and only block extremes are available."""

    def __init__(self) -> None:
        self.dividers: list[tuple[float, str]] = []
        """Labelled changes as (time in s, text); the oldest is first."""
        self.changes: list[float] = [-math.inf]
        """Times in s at which settings changed, oldest first; the first entry is older than all samples."""
        self.begin = -math.inf
        """From this time in s on, all samples belong to the current environment."""
        self.evaluated: tuple[float, float] | None = None
        """Start and stop in s of the interval that the open lesson evaluated last."""

    @property
    @abstractmethod
    def start(self) -> float:
        """The time of the oldest sample in s; NaN without samples."""

    @property
    @abstractmethod
    def now(self) -> float:
        """The time of the newest sample in s; NaN without samples."""

    @abstractmethod
    def copy(self) -> "History":
        """Return a snapshot of the samples that stays unchanged while this history is filled."""

    @abstractmethod
    def between(self, t0: float, t1: float) -> Window:
        """Return every sample with t0 <= time < t1."""

    @abstractmethod
    def window(self, edges: np.ndarray) -> Window:
        """Return the samples from edges[0] to edges[-1] (s), with one column between consecutive edges.

        Each column keeps its minimum and maximum. With at most two samples per column the samples themselves
        are returned, and one more sample on each side so that lines reach the edge.
        """

    @abstractmethod
    def at(self, time: float) -> dict[str, float] | None:
        """Return the value of every channel at the last sample up to a time in s.

        Return None before the first sample.
        """

    @abstractmethod
    def before(self, time: float) -> float:
        """Return the time of the last sample before a time, both in s; NaN before the first sample."""

    @property
    def empty(self) -> bool:
        """Return whether there are no samples."""
        return math.isnan(self.now)

    def latest(self) -> dict[str, float]:
        """Return the newest value of every channel; NaN without samples."""
        return self.at(self.now) or dict.fromkeys(channels(), math.nan)

    def drawn(self, t0: float, t1: float) -> Window:
        """Return the samples with t0 <= time < t1 for drawing point by point."""
        return self.between(t0, t1)

    def exceeds(self, t0: float, t1: float) -> bool:
        """Return whether ``between`` returns nothing because the range has too many samples."""
        return False


class Samples(History):
    """Samples in memory, sorted by time. A full array is compacted or enlarged."""

    def __init__(self, room: int = 0):
        """Reserve memory for ``room`` samples."""
        super().__init__()
        self._time, self._data = np.empty(room), np.empty((len(channels()), room))
        self._begin = self._end = 0
        self._known: frozenset[int] = frozenset()
        """Indices of the channels that have ever had a value other than NaN, even if it was dropped since."""
        self._tick = math.nan
        self._breaks: list[int] = []

    @classmethod
    def of(
        cls, time: np.ndarray, signals: Iterable[tuple[str, np.ndarray]], breaks: Iterable[int] = ()
    ) -> "Samples":
        """Return the named signals' samples at times (n,) in s, in 32 bits; other channels are NaN.

        Lines are interrupted before the samples with the indices ``breaks``.
        """
        made = cls()
        made._time, made._data = time, np.empty((len(channels()), len(time)), np.float32)
        for name, values in signals:
            row = channels().index(name)
            made._data[row] = values
            made._known |= {row}
        for row in {*range(len(channels()))} - made._known:
            made._data[row] = math.nan
        made._breaks, made._end = list(breaks), len(time)
        return made

    def __len__(self) -> int:
        return self._end - self._begin

    @property
    def start(self) -> float:
        return float(self._time[self._begin]) if len(self) else math.nan

    @property
    def now(self) -> float:
        return float(self._time[self._end - 1]) if len(self) else math.nan

    def extend(
        self, time: np.ndarray, tick: np.ndarray, flags: np.ndarray, signals: Mapping[str, np.ndarray | float]
    ) -> None:
        """Append samples (n,), n > 0, newer than all others; lines are interrupted at missing ticks."""
        if self._end + len(time) > len(self._time):
            self._make_room(len(time))
        first, self._end = self._end, self._end + len(time)
        self._time[first : self._end] = time
        for row, name in enumerate(channels()):
            values = signals.get(name, math.nan)
            self._data[row, first : self._end] = values
            if row not in self._known and not np.isnan(values).all():
                self._known |= {row}
        lost = np.flatnonzero(np.abs(tick[1:] - tick[:-1] - 1.0) > 0.5) + first + 1
        if abs(tick[0] - self._tick - 1.0) > 0.5:
            lost = np.append(lost, first)
        if flags.any():
            flagged = np.flatnonzero(flags.astype(np.int64) & rows.GAP)
            lost = np.union1d(lost, flagged + first)
        self._breaks += sorted(int(i) for i in lost if i > 0)
        self._tick = float(tick[-1])

    def _make_room(self, more: int) -> None:
        """Move the samples to the front, or into larger arrays if more than half of the arrays is used."""
        shift, kept = self._begin, len(self)
        time, data = self._time, self._data
        if kept + more > len(time) or 2 * kept > len(time):
            room = 2 * (kept + more)
            self._time, self._data = np.empty(room), np.empty((len(data), room))
        # Copy channel by channel: for the whole table numpy would allocate a temporary array and keep its
        # memory.
        for to, values in zip((self._time, *self._data), (time, *data), strict=True):
            to[:kept] = values[shift : self._end]
        self._breaks = [i - shift for i in self._breaks if i > shift]
        self._begin, self._end = 0, kept

    def copy(self) -> "Samples":
        other = Samples.__new__(Samples)
        other.__dict__.update(self.__dict__)
        lead = self._begin
        other._time = self._time[lead : self._end].copy()
        other._data = self._data[:, lead : self._end].copy()
        other._breaks = [i - lead for i in self._breaks]
        other.dividers, other.changes = [*self.dividers], [*self.changes]
        other._begin, other._end = 0, len(self)
        return other

    def between(self, t0: float, t1: float) -> Window:
        return self._samples(*self._indices(np.array([t0, t1])))

    def at(self, time: float) -> dict[str, float] | None:
        i = self._begin + int(np.searchsorted(self._time[self._begin : self._end], time, side="right")) - 1
        return dict(zip(channels(), self._data[:, i].tolist(), strict=True)) if i >= self._begin else None

    def before(self, time: float) -> float:
        i = int(np.searchsorted(self._time[self._begin : self._end], time)) - 1
        return float(self._time[self._begin + i]) if i >= 0 else math.nan

    def window(self, edges: np.ndarray) -> Window:
        indices = self._indices(edges)
        if indices[-1] - indices[0] > 2 * (len(edges) - 1):
            return self._columns(edges, indices)
        return self._samples(max(indices[0] - 1, self._begin), min(indices[-1] + 1, self._end))

    def _columns(self, edges: np.ndarray, indices: np.ndarray) -> Window:
        filled = np.flatnonzero(indices[1:] > indices[:-1])
        if not len(filled):
            return Window(np.empty(0), {name: np.empty(0) for name in channels()}, True)
        first, stop = indices[filled], indices[filled + 1]
        y = np.full((len(channels()), 2 * len(filled)), math.nan)
        for row in self._known:
            samples = self._data[row, : stop[-1]]
            keep_nan = row in _with_gaps()
            low, high = (np.minimum, np.maximum) if keep_nan else (np.fmin, np.fmax)
            least, greatest = low.reduceat(samples, first), high.reduceat(samples, first)
            rising = samples[stop - 1] >= samples[first]
            y[row, 0::2] = np.where(rising, least, greatest)
            y[row, 1::2] = np.where(rising, greatest, least)
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
        cuts = self._breaks_in(first, stop) - first
        return self._broken(self._time[first:stop], self._data[:, first:stop], cuts, False)

    def _broken(self, x: np.ndarray, y: np.ndarray, cuts: np.ndarray, dense: bool) -> Window:
        if len(cuts):
            x, y = np.insert(x, cuts, np.nan), np.insert(y, cuts, np.nan, axis=1)
        return Window(x, {name: y[row] for row, name in enumerate(channels())}, dense)


@cache
def _with_gaps() -> tuple[int, ...]:
    names = channels()
    return tuple(row for row, name in enumerate(names) if name != OBJECT and BY_NAME[name].gaps)


class LiveHistory(Samples):
    """The last minute of telemetry rows.

    Reducing 10 s at 1 kHz to extremes per pixel takes 0.2 ms, and reducing 60 s at 4 kHz takes 1.2 ms.
    """

    def __init__(self, seconds: float = 60.0, rate: float = 10000.0):
        """Reserve memory for ``seconds`` at ``rate`` Hz."""
        self.seconds = seconds
        self.capacity = math.ceil(seconds * rate) + 1
        super().__init__(2 * self.capacity + _AT_ONCE)

    def clear(self) -> None:
        """Remove all samples and changes."""
        self._begin = self._end = 0
        self._tick, self._breaks, self._known = math.nan, [], frozenset()
        self.dividers, self.changes, self.begin = [], [-math.inf], -math.inf

    def divide(self, text: str, time: float | None = None, instead: float | None = None) -> None:
        """Add a labelled divider at a time in s, by default now; it replaces a divider at the same time.

        ``instead`` is the time of another divider that is removed. With an empty label, no divider is added.
        """
        at = self.now if time is None else time
        if len(self):
            others = [(when, was) for when, was in self.dividers if when not in (at, instead)]
            self.dividers = sorted([*others, (at, text)] if text else others)

    def end_environment(self) -> None:
        """Mark all samples up to now as belonging to the previous environment."""
        self.begin = math.nextafter(self.now, math.inf) if len(self) else -math.inf

    def append(self, new: np.ndarray, object_position: np.ndarray | None = None) -> None:
        """Append (n, ROW_WIDTH) telemetry rows, oldest first; clear the history if the clock went back.

        ``object_position`` (n,) in m is the position of the second body; None if there is no second body.
        """
        if not len(new):
            return
        if len(self) and new[0, rows.HOST_TIME] < self.now:
            self.clear()
        for part in range(0, len(new), _AT_ONCE):
            some = new[part : part + _AT_ONCE]
            signals = {name: some[:, COLUMN[name]] for name in channels()[:-1]}
            if object_position is not None:
                signals[OBJECT] = object_position[part : part + _AT_ONCE]
            self.extend(some[:, rows.HOST_TIME], some[:, rows.TICK], some[:, rows.FLAGS], signals)
            self._forget()

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


def highest_speed(history: History, seconds: float = LATELY_SECONDS) -> float:
    """Return the handle's highest speed in m/s in a history's newest ``seconds``; 0 without samples."""
    velocity = history.between(history.now - seconds, np.inf).y["velocity"]
    return float(np.nanmax(np.abs(velocity), initial=0.0))

"""A recorded session as the history that the plots show: up to the time at which a replay stands.

A stretch of up to PICTURED samples is drawn from the samples themselves, which are read as they are asked
for; a longer one from the extremes that the file keeps of every block.
"""

import math
from bisect import bisect_right
from collections.abc import Collection, Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.environment_library import usable
from hapkit_studio.gui.live.history import CHANNELS, ENERGIES, OBJECT, History, Window
from hapkit_studio.haptics import rows
from hapkit_studio.sessions.chunk import BLOCK
from hapkit_studio.sessions.columns import DamagedError
from hapkit_studio.sessions.file import SETTINGS
from hapkit_studio.sessions.layout import STATE
from hapkit_studio.sessions.session import Session
from hapkit_studio.sessions.settings import log as settings_log
from hapkit_studio.sessions.settings import timed_changes
from hapkit_studio.settings_log import Log

PICTURED = 5 << 17
"""A minute at 10 kHz: the plots show no longer one, and the file keeps no extremes of the object's place."""
READ_AT_ONCE = 1 << 20
"""The most samples that are given one by one: four minutes at 4 kHz."""
_HASTY = 1.0  # s
_GAP = 0.25  # s without a sample: lines break, as the recorder begins another chunk
_PLOTTED = ("tick", "time", "flags", *CHANNELS, STATE)
_UNKNOWN = History(0.0, 0.0).latest()
_NONE = np.empty((0, rows.ROW_WIDTH))
_CHUNKS = 32  # that are kept unpacked to read single samples from


class Recorded(History):
    """A session's samples by the recording computer's clock; ``now`` is where a replay stands.

    What came after now is not hidden: a cursor may stay there. While it is not ``complete``, as where it is
    dragged along, it is drawn from the extremes of blocks alone.
    """

    def __init__(self, session: Session, environments: Mapping[str, Environment] | None = None):
        """Prepare what an hour is drawn from; takes a while, and can be done in a thread.

        environments: by key those that know where their object is.
        """
        super().__init__(READ_AT_ONCE, 1.0)
        self.session, self._environments = session, environments or {}
        self._now = self.start
        self._held = 0, 0  # the chunks whose samples are read: first, and the one after the last
        self._blocks = _blocks(session)
        self._table = lru_cache(_CHUNKS)(self._read)
        self._settings = [event for event in session.events if event.kind == SETTINGS]
        self._times = [event.time for event in self._settings]
        self.changes += [time for time in self._times if time >= self.start]
        begun = [(event.time, str(event.what.get("environment", ""))) for event in self._settings]
        self.begun = [new for old, new in zip([(0.0, ""), *begun], begun, strict=False) if old[1] != new[1]]
        """When which environment came into force: s, and its key."""
        self.markers = list(session.markers)
        changes = timed_changes(session.events, self.start, self.stop)
        self.changed = [(self.start + after, words) for after, words in changes]
        """When something else was set while it was recorded: s, and in words what."""

    @property
    def start(self) -> float:
        """Time of the first sample in s."""
        return float(self.session.starts[0])

    @property
    def stop(self) -> float:
        """Time of the last sample in s."""
        return float(self.session.stops[-1])

    @property
    def now(self) -> float:
        """Where the replay stands, in s."""
        return self._now

    def move_to(self, time: float) -> None:
        """Stand at a time in s."""
        self._now = time
        self.begin = next((when for when, _ in reversed(self.begun) if when <= time), -math.inf)

    def settings(self) -> dict[str, Any]:
        """Return what was set at the time at which it stands, {} before anything is known."""
        return self._set_at(self._now)

    def log(self, begin: float, end: float) -> Log:
        """Return device and settings at begin and each change until end, with its time in s after begin."""
        return settings_log(self.session.events, begin, end)

    def _set_at(self, time: float) -> dict[str, Any]:
        place = bisect_right(self._times, time) - 1
        return self._settings[place].what if place >= 0 else {}

    def row(self) -> np.ndarray | None:
        """Return the last telemetry row (ROW_WIDTH,) that had come by now, None where it is damaged."""
        return self._row(self._now, "right")

    def clamped_since(self, time: float) -> bool:
        """Say whether a force was clamped after a time in s, or is so now; the newest chunk is looked at."""
        table = self._table(self._chunk(self._now, "right"))
        first, stop = np.searchsorted(table[:, rows.HOST_TIME], [time, self._now], side="right")
        flags = table[min(first, stop - 1) : stop, rows.FLAGS].astype(np.int64)
        return bool(np.any(flags & rows.CLAMPED))

    # what the plots ask for

    def copy(self) -> History:
        """Return itself: what is recorded does not go on filling."""
        return self

    def latest(self) -> dict[str, float]:
        """Return every channel's value where the replay stands."""
        return self.at(self._now) or _UNKNOWN

    def between(self, t0: float, t1: float) -> Window:
        """Return every sample with t0 <= time < t1, up to now where t1 is endless; none of too many."""
        end = math.nextafter(self._now, math.inf) if math.isinf(t1) else t1
        return super().between(t0, end) if self._hold(t0, end, READ_AT_ONCE) else super().between(0.0, 0.0)

    def exceeds(self, t0: float, t1: float, most: int = READ_AT_ONCE) -> bool:
        """Say whether there are too many samples from t0 to t1 in s to be given one by one."""
        first, last = self._chunks(t0, t1)
        return bool(self.session.counts[first:last].sum() > most)

    def drawn(self, t0: float, t1: float) -> Window:
        """Return what ``between`` does, while it is not complete the newest second by extremes of blocks."""
        ours = self._reads(t0, t1)
        return self.between(t0, t1) if ours else self._blocks.between(max(t0, t1 - _HASTY), t1)

    def window(self, edges: np.ndarray) -> Window:
        """Return what ``History`` does, of a long stretch by the extremes of blocks."""
        ends = edges[0], edges[-1]
        ours = self._reads(*ends) and self._hold(*ends, PICTURED)
        return super().window(edges) if ours else self._blocks.window(edges)

    def at(self, time: float) -> dict[str, float] | None:
        """Return every channel's value at the last sample up to a time in s; None before the first."""
        row = self._row(time, "right")
        if row is None:
            return None
        known = {name: float(row[place]) for name, place in CHANNELS.items()}
        return {**_UNKNOWN, **known, OBJECT: float(self._places(row[None])[0])}

    def before(self, time: float) -> float:
        """Return the time of the last sample before a time, both in s; NaN before the first."""
        row = self._row(time, "left")
        return math.nan if row is None else float(row[rows.HOST_TIME])

    def after(self, time: float) -> float:
        """Return the time of the first sample after a time, both in s; NaN after the last."""
        number = max(self._chunk(time, "right"), 0)
        for at in range(number, min(number + 2, len(self.session.counts))):
            times = self._table(at)[:, rows.HOST_TIME]
            if len(later := times[times > time]):
                return float(later[0])
        return math.nan

    # reading

    def _places(self, samples: np.ndarray) -> np.ndarray:
        """Return where the object was (n,) in m in rows with their state, NaN where there was none."""
        times = samples[:, rows.HOST_TIME]
        places = np.full(len(times), math.nan)
        cuts = np.unique([0, *np.searchsorted(times, self._times), len(times)])
        for first, last in pairwise(cuts):
            what, some = self._set_at(times[first]), samples[first:last]
            environment = self._environments.get(str(what.get("environment", "")))
            names = what.get("state_names")
            if environment is None or (names is not None and tuple(names) != environment.state_names):
                continue  # its law is not there, or keeps something else by now
            values = usable(environment, dict(what.get("parameters", {})))
            found = environment.place(values, some[:, rows.POSITION], some[:, rows.STATE :])
            places[first:last] = math.nan if found is None else found
        return places

    def _chunk(self, time: float, side: Any) -> int:
        """Return the last chunk that began up to a time ("right") or before it ("left"), -1 if none."""
        return int(np.searchsorted(self.session.starts, time, side)) - 1

    def _row(self, time: float, side: Any) -> np.ndarray | None:
        number = self._chunk(time, side)
        table = self._table(number) if number >= 0 else _NONE
        place = int(np.searchsorted(table[:, rows.HOST_TIME], time, side)) - 1
        return table[place] if place >= 0 else None

    def _read(self, number: int, names: Collection[str] | None = None) -> np.ndarray:
        try:
            table = self.session.rows(number, names)
        except DamagedError:
            return _NONE
        return np.where(np.isfinite(table), table, math.nan)

    def _chunks(self, t0: float, t1: float) -> tuple[int, int]:
        """Return the first and the one after the last chunk of a stretch, with one more at each side."""
        starts, stops = self.session.starts, self.session.stops
        first = max(int(np.searchsorted(stops, t0)) - 1, 0)
        return first, min(int(np.searchsorted(starts, t1)) + 1, len(starts))

    def _reads(self, t0: float, t1: float) -> bool:
        """Say whether samples may be drawn: all, while it is not complete those that are there."""
        return self.complete or self._holds(*self._chunks(t0, t1))

    def _holds(self, first: int, last: int) -> bool:
        begun, ended = self._held
        return begun <= first and last <= ended

    def _hold(self, t0: float, t1: float, most: int) -> bool:
        """Have all samples from t0 to t1, and one more at each side; return False where they are too many."""
        first, last = self._chunks(t0, t1)
        if self.exceeds(t0, t1, most):
            return False
        begun, ended = self._held
        if not self._holds(first, last):
            follows = begun <= first <= ended
            if not follows or self.session.counts[begun:last].sum() > READ_AT_ONCE:
                self._drop_samples()
                begun = ended = first
            for number in range(ended, last):
                new = self._read(number, _PLOTTED)
                self.append(new, np.full((len(new), len(ENERGIES)), math.nan), self._places(new))
            self._held = begun, last
        return True


def _blocks(session: Session) -> History:
    """Return a history of two values a block, its least and its greatest, in the order of the trend."""
    counts = -(-session.counts // BLOCK)
    firsts = np.cumsum(counts) - counts
    starts, stops = (np.repeat(ends, counts) for ends in (session.starts, session.stops))
    lengths = BLOCK * (stops - starts) / np.maximum(np.repeat(session.counts, counts) - 1, 1)
    left = starts + (np.arange(counts.sum()) - np.repeat(firsts, counts)) * lengths
    time = np.minimum(np.stack([left + 0.25 * lengths, left + 0.75 * lengths], axis=1), stops[:, None])
    names = session.layout.with_extremes
    found = np.concatenate(session.blocks, axis=2)[[names.index(name) for name in CHANNELS]]
    middle = found.sum(axis=1)
    rising = np.diff(middle, append=middle[:, -1:]) >= 0.0
    pairs = np.where(rising[..., None], found.transpose(0, 2, 1), found[:, ::-1].transpose(0, 2, 1))
    broken = np.flatnonzero(session.starts[1:] - session.stops[:-1] > _GAP) + 1
    return History.of(time.ravel(), pairs.reshape(len(CHANNELS), -1), (2 * firsts[broken]).tolist())

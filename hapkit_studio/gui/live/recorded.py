"""The history of a recorded session up to the replay position.

An interval of up to PICTURED samples is drawn from the samples themselves, which are read on demand. A longer
interval is drawn from the block extremes that the file stores.
"""

import math
from bisect import bisect_right
from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.live.history import History, Samples, Window, channels
from hapkit_studio.gui.live.plots.declared import OBJECT
from hapkit_studio.gui.state.environment_library import usable
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN
from hapkit_studio.sessions.chunk import BLOCK
from hapkit_studio.sessions.columns import DamagedError
from hapkit_studio.sessions.file import SETTINGS
from hapkit_studio.sessions.layout import STATE
from hapkit_studio.sessions.session import Session
from hapkit_studio.sessions.settings_events import log as settings_log
from hapkit_studio.sessions.settings_events import timed_changes
from hapkit_studio.settings_log import Log

PICTURED = 5 << 17
"""Number of samples in a minute at 10 kHz, the longest time window.

The file stores no extremes of the object's position, so this window must be drawn from samples.
"""
READ_AT_ONCE = 1 << 20
"""Maximum number of samples that are read one by one: four minutes at 4 kHz."""
_HASTY = 1.0  # s: interval that is shown while the user drags the replay position
_GAP = 0.25  # s: a line is interrupted if there is no sample for this time
_CACHED_CHUNKS = 32  # number of decoded chunks that are cached to read single samples
Signals = Mapping[str, np.ndarray]
"""Signals of a chunk by name; STATE has one column per state variable."""


class Recorded(History):
    """A session's samples; ``now`` is the replay position. All times are of the recording computer's clock.

    Samples after ``now`` can also be read, because a cursor may be there. While ``complete`` is False, only
    block extremes are drawn.
    """

    def __init__(self, session: Session, environments: Mapping[str, Environment] | None = None):
        """Read the extremes of all blocks; this takes a while and may run in a thread.

        ``environments`` are all known environments by key; they compute the position of the second body.
        """
        super().__init__()
        self.session, self._environments = session, environments or {}
        self._now = self.start
        self._samples = Samples()
        self._read_chunks = 0, 0  # chunks whose samples are in _samples: the first, and the last plus one
        self._blocks = _blocks(session)
        self._cached = lru_cache(_CACHED_CHUNKS)(self._chunk_signals)
        self._settings = [event for event in session.events if event.kind == SETTINGS]
        self._times = [event.time for event in self._settings]
        self.changes += [time for time in self._times if time >= self.start]
        begun = [(event.time, str(event.what.get("environment", ""))) for event in self._settings]
        self.begun = [new for old, new in zip([(0.0, ""), *begun], begun, strict=False) if old[1] != new[1]]
        """When each environment started: (time in s, key)."""
        self.markers = list(session.markers)
        changes = timed_changes(session.events, self.start, self.stop)
        self.changed = [(self.start + after, text) for after, text in changes]
        """Other changes of settings during the recording: (time in s, description)."""

    @property
    def start(self) -> float:
        """The time of the first sample in s."""
        return float(self.session.starts[0])

    @property
    def stop(self) -> float:
        """The time of the last sample in s."""
        return float(self.session.stops[-1])

    @property
    def now(self) -> float:
        """The replay position in s."""
        return self._now

    def move_to(self, time: float) -> None:
        """Set the replay position in s."""
        self._now = time
        self.begin = next((when for when, _ in reversed(self.begun) if when <= time), -math.inf)

    def settings(self) -> dict[str, Any]:
        """Return the settings at the replay position; {} if no settings are known yet."""
        return self._set_at(self._now)

    def log(self, begin: float, end: float) -> Log:
        """Return device and settings at ``begin`` and each change until ``end``, both in s.

        The times in the result are in s after ``begin``.
        """
        return settings_log(self.session.events, begin, end)

    def _set_at(self, time: float) -> dict[str, Any]:
        place = bisect_right(self._times, time) - 1
        return self._settings[place].what if place >= 0 else {}

    def row(self) -> np.ndarray | None:
        """Return the telemetry row (ROW_WIDTH,) of the last sample up to now.

        Return None if its data are damaged.
        """
        found = self._sample(self._now, "right")
        if found is None:
            return None
        signals, index = found
        row = np.full(rows.ROW_WIDTH, math.nan)
        for name in COLUMN.keys() & signals.keys():
            row[COLUMN[name]] = signals[name][index]
        state = signals[STATE][index][: rows.ROW_WIDTH - rows.STATE]
        row[rows.STATE : rows.STATE + len(state)] = state
        return row

    def clamped_since(self, time: float) -> bool:
        """Return whether a force was clamped after a time in s or is clamped now.

        Only the newest chunk is searched.
        """
        signals = self._cached(self._chunk(self._now, "right"))
        if signals is None:
            return False
        first, stop = np.searchsorted(signals["time"], [time, self._now], side="right")
        flags = signals["flags"][min(first, stop - 1) : stop].astype(np.int64)
        return bool(np.any(flags & rows.CLAMPED))

    # interface of History

    def copy(self) -> History:
        """Return this history itself, because a recorded session does not change."""
        return self

    def between(self, t0: float, t1: float) -> Window:
        """Return the samples with t0 <= time < t1, at most up to now.

        Return no samples if there are too many.
        """
        end = math.nextafter(self._now, math.inf) if math.isinf(t1) else t1
        read = self._read(t0, end, READ_AT_ONCE)
        return self._samples.between(t0, end) if read else Samples().between(0.0, 0.0)

    def exceeds(self, t0: float, t1: float, most: int = READ_AT_ONCE) -> bool:
        first, last = self._chunks(t0, t1)
        return bool(self.session.counts[first:last].sum() > most)

    def drawn(self, t0: float, t1: float) -> Window:
        """Return the interval's samples; while ``complete`` is False, block extremes of its last second."""
        ours = self._draws_samples(t0, t1)
        return self.between(t0, t1) if ours else self._blocks.between(max(t0, t1 - _HASTY), t1)

    def window(self, edges: np.ndarray) -> Window:
        ends = edges[0], edges[-1]
        ours = self._draws_samples(*ends) and self._read(*ends, PICTURED)
        return self._samples.window(edges) if ours else self._blocks.window(edges)

    def at(self, time: float) -> dict[str, float] | None:
        found = self._sample(time, "right")
        if found is None:
            return None
        signals, index = found
        sample = {name: values[index : index + 1] for name, values in signals.items()}
        sample[OBJECT] = self._object_position(sample)
        return {name: float(sample[name][0]) if name in sample else math.nan for name in channels()}

    def before(self, time: float) -> float:
        found = self._sample(time, "left")
        return math.nan if found is None else float(found[0]["time"][found[1]])

    def after(self, time: float) -> float:
        """Return the time of the first sample after a time, both in s; NaN after the last sample."""
        number = max(self._chunk(time, "right"), 0)
        for at in range(number, min(number + 2, len(self.session.counts))):
            signals = self._cached(at)
            if signals is not None and len(later := signals["time"][signals["time"] > time]):
                return float(later[0])
        return math.nan

    # reading

    def _object_position(self, signals: Signals) -> np.ndarray:
        """Return the positions (n,) in m of the second body; NaN if there is no second body."""
        times = signals["time"]
        found = np.full(len(times), math.nan)
        cuts = np.unique([0, *np.searchsorted(times, self._times), len(times)])
        for first, last in pairwise(cuts):
            what = self._set_at(times[first])
            environment = self._environments.get(str(what.get("environment", "")))
            names = what.get("state_names")
            if environment is None or (names is not None and tuple(names) != environment.state_names):
                continue  # the law is missing, or its state variables have changed since the recording
            values = usable(environment, dict(what.get("parameters", {})))
            state = np.full((last - first, rows.ROW_WIDTH - rows.STATE), math.nan)
            known = signals[STATE][first:last, : state.shape[1]]
            state[:, : known.shape[1]] = known
            place = environment.place(values, signals["position"][first:last], state)
            found[first:last] = math.nan if place is None else place
        return found

    def _chunk(self, time: float, side: Any) -> int:
        """Return the last chunk whose start is < time (side "left") or <= time (side "right").

        Return -1 for a time before the first chunk.
        """
        return int(np.searchsorted(self.session.starts, time, side)) - 1

    def _sample(self, time: float, side: Any) -> tuple[Signals, int] | None:
        """Return chunk and index of the last sample at < time (side "left") or <= time (side "right")."""
        number = self._chunk(time, side)
        signals = self._cached(number) if number >= 0 else None
        if signals is None:
            return None
        index = int(np.searchsorted(signals["time"], time, side)) - 1
        return (signals, index) if index >= 0 else None

    def _chunk_signals(self, number: int) -> Signals | None:
        """Return the signals of a chunk with NaN for infinite values; None for a damaged chunk."""
        try:
            return self._finite(self.session.signals(number))
        except DamagedError:
            return None

    @staticmethod
    def _finite(signals: Signals) -> Signals:
        found = {name: np.where(np.isfinite(values), values, math.nan) for name, values in signals.items()}
        for name in ("tick", "flags"):
            found[name] = np.nan_to_num(found[name])
        return found

    def _chunks(self, t0: float, t1: float) -> tuple[int, int]:
        """Return the chunks [first, stop) that cover an interval, with one more chunk on each side."""
        starts, stops = self.session.starts, self.session.stops
        first = max(int(np.searchsorted(stops, t0)) - 1, 0)
        return first, min(int(np.searchsorted(starts, t1)) + 1, len(starts))

    def _draws_samples(self, t0: float, t1: float) -> bool:
        """Return whether samples may be drawn.

        While ``complete`` is False, only samples that have already been read may be drawn.
        """
        return self.complete or self._has_read(*self._chunks(t0, t1))

    def _has_read(self, first: int, last: int) -> bool:
        begun, ended = self._read_chunks
        return begun <= first and last <= ended

    def _read(self, t0: float, t1: float, most: int) -> bool:
        """Read all samples from t0 to t1 and one more on each side; return False if there are too many."""
        first, last = self._chunks(t0, t1)
        if self.exceeds(t0, t1, most):
            return False
        begun, ended = self._read_chunks
        if not self._has_read(first, last):
            follows = begun <= first <= ended
            if not follows or self.session.counts[begun:last].sum() > READ_AT_ONCE:
                self._samples = Samples()
                begun = ended = first
            names = {"tick", "time", "flags", "position", STATE, *channels()} - {OBJECT}
            for number in range(ended, last):
                try:
                    new = dict(self._finite(self.session.signals(number, names)))
                except DamagedError:
                    continue
                new[OBJECT] = self._object_position(new)
                self._samples.extend(new["time"], new["tick"], new["flags"], new)
            self._read_chunks = begun, last
        return True


def _blocks(session: Session) -> Samples:
    """Return two samples per block: first its minimum, then its maximum; reversed if the signal falls."""
    counts = -(-session.counts // BLOCK)
    firsts = np.cumsum(counts) - counts
    starts, stops = (np.repeat(ends, counts) for ends in (session.starts, session.stops))
    lengths = BLOCK * (stops - starts) / np.maximum(np.repeat(session.counts, counts) - 1, 1)
    left = starts + (np.arange(counts.sum()) - np.repeat(firsts, counts)) * lengths
    time = np.minimum(np.stack([left + 0.25 * lengths, left + 0.75 * lengths], axis=1), stops[:, None])

    def in_order(row: int) -> np.ndarray:
        least, greatest = session.blocks[row].astype(float)
        middle = least + greatest
        rising = np.diff(middle, append=middle[-1:]) >= 0.0
        return np.where(rising, [least, greatest], [greatest, least]).T.ravel()

    names = session.layout.with_extremes
    found = ((name, in_order(row)) for row, name in enumerate(names) if name in channels())
    broken = np.flatnonzero(session.starts[1:] - session.stops[:-1] > _GAP) + 1
    return Samples.of(time.ravel(), found, (2 * firsts[broken]).tolist())

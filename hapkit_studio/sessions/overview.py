"""A summary of a session for lists: its file, its events, and a trace of the position."""

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np

from hapkit_studio.columns import Column
from hapkit_studio.formatting import clock, megabytes
from hapkit_studio.sessions.chunk import BLOCK
from hapkit_studio.sessions.event_values import one_line
from hapkit_studio.sessions.file import ABOUT, LOG, SETTINGS, SessionError
from hapkit_studio.sessions.session import Session
from hapkit_studio.sessions.settings_events import timed_changes

_MOST = 1000  # maximum number of points in a trace
_FEW = 60_000  # a session with fewer samples is read directly, because its blocks would be too coarse


@dataclass(frozen=True, eq=False)
class Overview:
    """A session's file and a summary of its content.

    ``size`` is in bytes. ``saved`` is the time of the last write in s, as returned by ``time.time``.
    ``environments`` contains keys in order of use. ``markers`` and ``changes`` contain the time in s after
    the start, and a text; ``notes`` concern the whole session. ``trace`` (3, n) contains the time in s after
    the start, and the minimum and maximum position in m until the next time; the positions are NaN without
    samples. ``unfinished`` is advice for an incomplete recording, "" for a complete one. ``error`` is the
    reason why no data can be read.
    """

    path: Path
    size: int
    saved: float
    error: str = ""
    seconds: float = 0.0
    samples: int = 0
    device: str = ""
    environments: tuple[str, ...] = ()
    markers: tuple[tuple[float, str], ...] = ()
    changes: tuple[tuple[float, str], ...] = ()
    notes: tuple[str, ...] = ()
    unfinished: str = ""
    damage: tuple[str, ...] = ()
    trace: np.ndarray = field(default_factory=lambda: np.empty((3, 0)))

    @property
    def name(self) -> str:
        """Return the file's name without its suffix, as one line."""
        return one_line(self.path.stem)

    @property
    def noted(self) -> list[str]:
        """Return all notes on the whole session, then the texts of the markers."""
        return [*self.notes, *(text for _, text in self.markers)]


def columns(title: Callable[[str], str]) -> tuple[Column, ...]:
    """Return the list's columns; ``title`` returns an environment's title for its key."""

    def quiet(row: Overview) -> str:
        return "warn" if row.error or row.damage or row.unfinished else "ink2"

    return (
        Column("Name", lambda row: row.name, right=False),
        Column("Environment", lambda row: _some([title(key) for key in row.environments]), right=False),
        Column("Device", lambda row: row.device, right=False, token=quiet),
        Column("Notes", _notes, right=False, token=quiet),
        Column("Saved", lambda row: date_text(row.saved), lambda row: row.saved, quiet),
        Column("Length", lambda row: "" if row.error else clock(row.seconds), lambda row: row.seconds),
        Column("Size", lambda row: megabytes(row.size), lambda row: row.size, quiet),
    )


def date_text(seconds: float) -> str:
    """Format the time of saving in local time; return a dash for a year that is out of range."""
    try:
        return f"{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M}"
    except (ValueError, OverflowError, OSError):
        return "–"


def _some(titles: list[str]) -> str:
    """Return the first title and the number of further titles."""
    return f"{titles[0]} + {len(titles) - 1}" if len(titles) > 1 else "".join(titles)


def _notes(row: Overview) -> str:
    if row.error or row.damage or row.unfinished:
        return "File cannot be read" if row.error else "File damaged" if row.damage else "Recording not ended"
    return ", ".join(row.noted)


def overview(path: Path) -> Overview:
    """Return a session's summary; raise OSError if the file is missing."""
    found, log = path.stat(), path.with_name(f"{path.name}{LOG}")
    size = found.st_size + (log.stat().st_size if log.exists() else 0)
    try:
        with closing(Session(path)) as session:
            return _of(session, size, found.st_mtime)
    except SessionError as error:
        return Overview(path, size, found.st_mtime, str(error))


def _of(session: Session, size: int, saved: float) -> Overview:
    start, stop = float(session.starts[0]), float(session.stops[-1])
    trace = _trace(session)  # must precede ``damage`` below: damage is found while samples are read
    keys = [str(event.what.get("environment", "")) for event in session.events if event.kind == SETTINGS]
    return Overview(
        session.path,
        size,
        saved,
        seconds=session.seconds,
        samples=int(session.counts.sum()),
        device=str(session.latest(ABOUT).get("device", "")),
        environments=tuple(dict.fromkeys(key for key in keys if key)),
        markers=tuple((when - start, text) for when, text in session.markers),
        changes=tuple(timed_changes(session.events, start, stop)),
        notes=session.notes,
        unfinished=session.unfinished,
        damage=session.damage,
        trace=trace,
    )


def _trace(session: Session) -> np.ndarray:
    """Return times after the start, and minimum and maximum positions (3, n); NaN without samples."""
    times, least, greatest = _samples(session) if session.counts.sum() <= _FEW else _blocks(session)
    # Each point covers at least two samples on average, so a point without samples is a gap.
    count = max(min(_MOST, len(times) // 2), 1)
    edges = session.starts[0] + session.seconds * np.arange(count) / count
    first = np.searchsorted(times, edges)
    filled = np.append(first[1:], len(times)) > first
    trace = np.vstack([edges - session.starts[0], np.full((2, count), math.nan)])
    trace[1, filled] = np.fmin.reduceat(least, first[filled])
    trace[2, filled] = np.fmax.reduceat(greatest, first[filled])
    return trace


def _samples(session: Session) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    found = session.read(("time", "position"))
    position = np.where(np.isfinite(found["position"]), found["position"], math.nan)
    return found["time"], position, position


def _blocks(session: Session) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each block's start time, minimum and maximum position."""
    parts = zip(session.starts, session.stops, -(-session.counts // BLOCK), strict=True)
    times = [np.linspace(start, stop, count, endpoint=False) for start, stop, count in parts]
    least, greatest = session.blocks[session.layout.with_extremes.index("position")].astype(float)
    return np.concatenate(times), least, greatest

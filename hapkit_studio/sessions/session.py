"""A session read back: its samples between two times, what was set, and extremes to draw an hour from.

Nothing in a file is trusted: one with other tables is refused; rows whose checksum, types or order are wrong
are left out and counted. The file is never written into; a note makes a new one that takes its place.
"""

import json
import math
import os
import shutil
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.files import replacing
from hapkit_studio.sessions.chunk import Chunk
from hapkit_studio.sessions.columns import DamagedError
from hapkit_studio.sessions.file import (
    MARK,
    NOTE,
    TABLES,
    VERSION,
    Event,
    SessionError,
    SessionWriter,
    checksum,
    schema,
)

_TYPES: dict[str, type | tuple[type, ...]] = {
    "INTEGER": int, "REAL": float, "TEXT": str, "BLOB": (bytes, type(None)),
}  # fmt: skip
_HEAD = ("count", "start", "stop", "states", "extremes")
SQLITE = b"SQLite format 3\0"
"""The first bytes of a session's file."""
_LONGEST = 1 << 24  # bytes of one value
_MOST_ROWS = 1 << 32
_MOST_SAMPLES, _MOST_STATES = 1 << 16, 64  # of a chunk


class Session:
    """A session opened for reading; chunks are read when they are asked for, in one thread at a time.

    At hand: events; of every chunk its count of samples, when the first and the last came, starts and stops
    (chunks,) in s of the recording computer's clock, and the extremes of its blocks.
    """

    def __init__(self, path: str | Path):
        """Open a session; raise SessionError where it is none, or one of a newer studio."""
        self.path = Path(path)
        self._database = _open(self.path)
        self._damaged: set[tuple[str, int]] = set()
        self.events = tuple(self._events())
        index = list(self._index())
        if not index:
            self.close()
            raise SessionError(f"{self.path.name} holds no samples that can be read.")
        ids, counts, starts, stops, self.blocks = zip(*index, strict=True)
        self._ids: tuple[int, ...] = ids
        self.counts, self.starts, self.stops = np.array(counts), np.array(starts), np.array(stops)

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    @property
    def seconds(self) -> float:
        """Return how long the session is in s."""
        return float(self.stops[-1] - self.starts[0])

    @property
    def complete(self) -> bool:
        """Say whether its recording was ended: not while it is written, nor where the program was killed."""
        return self._database.execute("PRAGMA journal_mode").fetchone()[0] != "wal"

    @property
    def notes(self) -> tuple[str, ...]:
        """Return what was noted on all of it."""
        return tuple(str(event.what.get("text", "")) for event in self.events if event.kind == NOTE)

    @property
    def damage(self) -> tuple[str, ...]:
        """Return in words what of all that was read so far is damaged and left out."""
        words = f"{self.path.name} is damaged: {len(self._damaged)} of its rows are left out."
        return (words,) if self._damaged else ()

    def check(self) -> tuple[str, ...]:
        """Read all of it, and return ``damage``."""
        for number in range(len(self.counts)):
            with suppress(DamagedError):
                chunk = self.chunk(number)
                for name in chunk.columns:
                    chunk.values(name)
        return self.damage

    def latest(self, kind: str, time: float = math.inf) -> dict[str, Any]:
        """Return what the last event of a kind says up to a time in s; {} where there is none."""
        said = (event.what for event in reversed(self.events) if event.kind == kind and event.time <= time)
        return next(said, {})

    def chunk(self, number: int) -> Chunk:
        """Return a chunk, 0 the first; raise DamagedError."""
        row, columns = self._ids[number], TABLES["chunk"]
        try:
            query = f"SELECT {', '.join(columns)}, crc FROM chunk WHERE id = ?"
            *values, crc = self._database.execute(query, (row,)).fetchone()
            _check(values, columns)
            if crc != checksum(values):
                raise DamagedError("Its checksum is wrong.")
        except (sqlite3.DatabaseError, TypeError, DamagedError) as error:
            self._damaged.add(("chunk", row))
            raise DamagedError(f"Chunk {number} of {self.path.name} is damaged: {error}") from None
        named = dict(zip(columns, values, strict=True))
        count, start, stop, states, extremes = (named.pop(name) for name in _HEAD)
        return Chunk(count, start, stop, states, extremes, named)

    def repair(self, path: str | Path) -> tuple[str, ...]:
        """Write all that can be read into a new session; return ``damage``; raise SessionError."""
        writer = SessionWriter(path)
        for event in self.events:
            writer.note(event)
        for number in range(len(self.counts)):
            with suppress(DamagedError):
                writer.add(self.chunk(number))
        writer.close()
        return self.damage

    def read(
        self, names: Sequence[str], start: float = -math.inf, stop: float = math.inf
    ) -> dict[str, np.ndarray]:
        """Return columns (n,) in SI of all samples with start <= time < stop, "state" (n, values).

        What is damaged is left out; of a column that was not kept there is NaN.
        """
        pieces = []
        for number in np.flatnonzero((self.stops >= start) & (self.starts < stop)):
            try:
                chunk = self.chunk(int(number))
                inside = slice(*np.searchsorted(chunk.values("time"), [start, stop]))
                pieces.append({name: chunk.values(name)[inside] for name in names})
            except DamagedError:
                continue
        return {name: _joined([piece[name] for piece in pieces]) for name in names}

    def _events(self) -> Iterator[Event]:
        for row, *values, crc in self._rows("event", (*TABLES["event"], "crc")):
            try:
                _check(values, TABLES["event"])
                if crc != checksum(values):
                    raise DamagedError("Its checksum is wrong.")
                yield Event(values[0], values[1], dict(json.loads(values[2])))
            except (DamagedError, ValueError, TypeError, RecursionError):
                self._damaged.add(("event", row))

    def _index(self) -> Iterator[tuple[int, int, float, float, np.ndarray]]:
        """Yield each chunk's row, count, times and extremes."""
        before = -math.inf
        for row, *values in self._rows("chunk", _HEAD):
            try:
                _check(values, {name: TABLES["chunk"][name] for name in _HEAD})
                count, start, stop, states, extremes = values
                chunk = Chunk(count, start, stop, states, extremes, {})
                if not (before < chunk.start <= chunk.stop < math.inf):
                    raise DamagedError("Its times are out of order.")
                yield row, chunk.count, chunk.start, chunk.stop, chunk.blocks()
                before = chunk.stop
            except DamagedError:
                self._damaged.add(("chunk", row))

    def _rows(self, table: str, names: Sequence[str]) -> Iterator[tuple]:
        """Yield a table's rows, each with its number first; beyond those that cannot be read go on."""
        row, leap = 0, 1
        query = f"SELECT id, {', '.join(names)} FROM {table} WHERE id > ? ORDER BY id"
        while row < _MOST_ROWS:
            try:
                for found in self._database.execute(query, (row,)):
                    row, leap = found[0], 1
                    yield found
                return
            except sqlite3.DatabaseError:
                self._damaged.add((table, row))
                row, leap = row + leap, 2 * leap


def add_note(path: Path, text: str) -> None:
    """Note something on a session that is complete and whole; its file keeps its date. Raise SessionError."""
    with closing(Session(path)) as session:
        if not session.complete:
            raise SessionError(f"{path.name} is being written, or broke off: nothing was noted.")
        if damage := session.check():
            raise SessionError(f"{' '.join(damage)} Nothing was noted.")
        note = Event(float(session.stops[-1]), NOTE, {"text": text})
    date = path.stat()
    try:
        with replacing(path) as part:
            shutil.copyfile(path, part)
            with closing(SessionWriter.reopen(part)) as writer:
                writer.note(note)
            os.utime(part, ns=(date.st_atime_ns, date.st_mtime_ns))
    except OSError as error:
        raise SessionError(f"{path.name} cannot be written: {error.strerror}.") from None


def _check(values: Sequence, columns: dict[str, str]) -> None:
    """Raise DamagedError where a value has not its column's type, or a number makes no sense."""
    for value, (name, kind) in zip(values, columns.items(), strict=True):
        if not isinstance(value, _TYPES[kind]):
            raise DamagedError(f"Its {name} is no {kind}.")
    named = dict(zip(columns, values, strict=True))
    if not (0 < named.get("count", 1) <= _MOST_SAMPLES and 0 <= named.get("states", 0) <= _MOST_STATES):
        raise DamagedError("It claims too much.")


def _joined(pieces: list[np.ndarray]) -> np.ndarray:
    """Return pieces one after the other; of states as many values as the widest has, the others NaN."""
    if not pieces or pieces[0].ndim == 1:
        return np.concatenate([np.empty(0), *pieces])
    width = max(piece.shape[1] for piece in pieces)
    return np.concatenate(
        [np.pad(p, ((0, 0), (0, width - p.shape[1])), constant_values=math.nan) for p in pieces]
    )


def _open(path: Path) -> sqlite3.Connection:
    """Return a connection to a session that can only read; raise SessionError."""
    try:
        with path.open("rb") as file:
            header = file.read(100)
    except OSError as error:
        raise SessionError(f"{path} cannot be read: {error.strerror}.") from None
    none = SessionError(f"{path.name} is no session of the studio.")
    if not header.startswith(SQLITE) or int.from_bytes(header[68:72], "big") != MARK:
        raise none
    version = int.from_bytes(header[60:64], "big")
    if version > VERSION:
        newer = f"{path.name} was made by a newer studio (version {version}, this one reads {VERSION})"
        raise SessionError(f"{newer}: update the studio.")
    database = sqlite3.connect(
        f"{path.resolve().as_uri()}?mode=ro", uri=True, isolation_level=None, check_same_thread=False
    )
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST)
    try:
        for setting in ("trusted_schema=OFF", "cell_size_check=ON"):
            database.execute(f"PRAGMA {setting}")
        found = database.execute("SELECT name, sql FROM sqlite_master").fetchall()
    except sqlite3.DatabaseError as error:
        database.close()
        raise SessionError(f"{path.name} cannot be read: {error}.") from None
    if dict(found) != {table: schema(table) for table in TABLES}:
        database.close()
        raise none
    return database

"""Reads a session: samples between two times, settings, and extremes for plots of long recordings.

The file's content is not trusted. A file with other tables is rejected; rows with a wrong checksum, type,
value or order are skipped and reported. The file is never modified; adding a note writes a new file that
replaces it.
"""

import math
import os
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import closing, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_integer, checked_number, checked_text, replacing
from hapkit_studio.sessions.chunk import MOST_SAMPLES, MOST_STATES, MOST_TIME, Chunk
from hapkit_studio.sessions.columns import DamagedError
from hapkit_studio.sessions.database import ERRORS, Database
from hapkit_studio.sessions.event_values import checked_event, one_line
from hapkit_studio.sessions.file import (
    LOG,
    MARKER,
    NOTE,
    Event,
    SessionError,
    SessionWriter,
    checksum,
)
from hapkit_studio.sessions.layout import EVENT, HEAD, STATE, Layout

_TYPES = {"INTEGER": int, "REAL": float, "TEXT": str, "BLOB": bytes}
_NAMES = {kind: name for name, kind in _TYPES.items()} | {type(None): "NULL"}
# Maximum number of characters in the reason for which a row was skipped; the reason may be a message of
# SQLite that quotes the file's content.
_LONGEST_REASON = 300
SQLITE = b"SQLite format 3\0"
"""The first bytes of a session's file."""
_MOST_ROWS = 1 << 32
# Limits of reading. Rows beyond these limits are skipped.
_MOST_EVENTS = 50_000  # enough for settings that change continuously for 40 minutes
_MOST_TEXT = 1 << 26  # maximum number of characters in all events
_MOST_DAMAGED = 100_000  # maximum number of damaged rows
_MOST_SECONDS = 31 * 86_400.0
_MOST_IN_ALL = 1 << 28  # maximum number of samples: 75 hours at 1 kHz, whose extremes take 470 MB
MOST_MARKERS = 1_000  # maximum number of markers that are listed and drawn
MOST_READ = 1 << 31  # maximum number of bytes that one call of ``read`` returns: an hour at 4 kHz


class Session:
    """A session that is open for reading. Chunks are read on demand, by one thread at a time.

    Everything else is read when the file is opened: ``events``; for each chunk the number of samples, and the
    start and stop time in s of the recording computer's clock (chunks,); and ``blocks``, the extremes of all
    blocks (signals with extremes, 2, blocks) in SI, with NaN for non-finite values.
    """

    def __init__(self, path: str | Path):
        """Open a session.

        Raise SessionError if the file is not a session, or if a newer version of the studio has written it.
        """
        self.path = Path(path)
        self.name = one_line(self.path.name)
        self._file = Database(self.path)
        self._database, self.layout = self._file.connection, self._file.layout
        self._chunk_columns = self._file.tables["chunk"]
        self._damaged: dict[tuple[str, int], str] = {}
        self._whole = 0  # the row number of the last chunk whose checksum was verified
        self.events = tuple(self._events())
        index = self._index()
        if not index:
            self.close()
            reason = next(iter(self._damaged.values()), "")
            raise SessionError(f"{self.name} has no readable samples. {reason}".rstrip())
        self._ids = tuple(row for row, _, _ in index)
        chunks = [chunk for _, chunk, _ in index]
        self.blocks = np.concatenate([blocks for _, _, blocks in index], axis=2)
        self.blocks[~np.isfinite(self.blocks)] = math.nan
        self.counts, self.starts, self.stops, self._states = (
            np.array([getattr(chunk, name) for chunk in chunks])
            for name in ("count", "start", "stop", "states")
        )

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def date(self) -> str:
        """Return the start of the recording from the file's date, as "2026-11-26 14:05".

        Return "" if the file is missing.
        """
        try:
            end = self.path.stat().st_mtime
        except OSError:
            return ""
        return datetime.fromtimestamp(end - self.seconds).isoformat(" ", "minutes")

    @property
    def seconds(self) -> float:
        """Return the session's duration in s."""
        return float(self.stops[-1] - self.starts[0])

    @property
    def complete(self) -> bool:
        """Return True if the recording has ended; False while it runs, or if the program was killed."""
        return self._file.complete

    @property
    def unfinished(self) -> str:
        """Return the advice for an incomplete session; "" for a complete one."""
        name = self.name
        if self.complete:
            return ""
        if self._file.log_lost:
            return (
                f"The recording is incomplete: its newest samples are lost, because {name}{LOG} is missing."
            )
        one = "To make one complete file, save a copy (in a terminal: hapkit-studio sessions repair)."
        return f"The recording is incomplete: its newest samples are in {name}{LOG}. {one}"

    @property
    def notes(self) -> tuple[str, ...]:
        """Return the notes on the whole session."""
        return tuple(event.what["text"] for event in self.events if event.kind == NOTE)[:MOST_MARKERS]

    @property
    def markers(self) -> tuple[tuple[float, str], ...]:
        """Return each marker's time in s of the recording computer's clock, and its text."""
        first, last = float(self.starts[0]), float(self.stops[-1])
        marked = (event for event in self.events if event.kind == MARKER and first <= event.time <= last)
        return tuple((event.time, event.what["text"]) for event in marked)[:MOST_MARKERS]

    @property
    def damage(self) -> tuple[str, ...]:
        """Return messages about the damaged rows that were skipped so far."""
        if not self._damaged:
            return ()
        reason, more = next(iter(self._damaged.values())), len(self._damaged) - 1
        rows = f" And {more:,} more {'row' if more == 1 else 'rows'}." if more else ""
        return (f"{self.name} is damaged. Skipped: {reason}{rows}",)

    def check(self) -> tuple[str, ...]:
        """Read all data, and return ``damage``."""
        for number in range(len(self.counts)):
            with suppress(DamagedError):
                self.signals(number)
        return self.damage

    def latest(self, kind: str, time: float = math.inf) -> dict[str, Any]:
        """Return the last event of a kind up to a time in s; {} without such an event."""
        values = (event.what for event in reversed(self.events) if event.kind == kind and event.time <= time)
        return next(values, {})

    def chunk(self, number: int) -> Chunk:
        """Return a chunk by its index (from 0); raise DamagedError if the chunk is damaged."""
        return self._chunk(self._ids[number])

    def signals(self, number: int, names: Collection[str] | None = None) -> dict[str, np.ndarray]:
        """Return a chunk's signals and STATE (count, states), or only some of these.

        Raise DamagedError if the chunk is damaged.
        """
        return self._decoded(number, self.chunk(number), names)

    def repair(self, path: str | Path) -> tuple[str, ...]:
        """Write all readable data into a new session and return ``damage``.

        Raise SessionError if the new session cannot be written.
        """
        added = 0
        with SessionWriter.whole(path, self.layout) as writer:
            for event in self.events:
                writer.note(event)
            for number in range(len(self.counts)):
                with suppress(DamagedError):
                    chunk = self.chunk(number)
                    self._decoded(number, chunk)
                    writer.add(chunk)
                    added += 1
            if not added:
                raise SessionError(f"{' '.join(self.damage)} There are no readable samples to write.")
        return self.damage

    def read(
        self, names: Sequence[str], start: float = -math.inf, stop: float = math.inf
    ) -> dict[str, np.ndarray]:
        """Return signals (n,) in SI of all samples with start <= time < stop; "state" is (n, values).

        Damaged chunks are skipped; a signal that was not recorded is NaN. Raise SessionError if the result
        takes more than MOST_READ.
        """
        numbers = np.flatnonzero((self.stops >= start) & (self.starts < stop))
        width = len(names) + (STATE in names) * (self._states[numbers] - 1)
        size = 8 * int((self.counts[numbers] * width).sum())
        if size > MOST_READ:
            samples = f"{self.name}: {self.counts[numbers].sum():,} samples take {1e-9 * size:.1f} GB, but"
            limit = f"at most {1e-9 * MOST_READ:.1f} GB can be read at once"
            raise SessionError(f"{samples} {limit}. Choose a shorter part: sessions export --from --to.")
        pieces = []
        for number in numbers:
            try:
                chunk = self.chunk(int(number))
                inside = slice(*np.searchsorted(chunk.values("time"), [start, stop]))
                pieces.append({name: chunk.values(name)[inside] for name in names})
            except DamagedError as error:
                self._left_out("chunk", self._ids[number], error)
        return {name: _joined([piece[name] for piece in pieces]) for name in names}

    def _decoded(
        self, number: int, chunk: Chunk, names: Collection[str] | None = None
    ) -> dict[str, np.ndarray]:
        try:
            return {name: chunk.values(name) for name in (self.layout.names if names is None else names)}
        except DamagedError as error:
            raise self._left_out("chunk", self._ids[number], error) from None

    def _left_out(self, table: str, row: int, error: Exception | str) -> DamagedError:
        """Store the reason why a row is skipped, unless a reason is already stored; return it as an error."""
        place, reason = f"{table} {row}", f"{one_line(str(error)):.{_LONGEST_REASON}}"
        text = reason if reason.startswith(place) else f"{place}: {reason}"
        return DamagedError(self._damaged.setdefault((table, row), text))

    def _chunk(self, row: int) -> Chunk:
        columns = self._chunk_columns
        try:
            query = f"SELECT {', '.join(columns)}, crc FROM chunk WHERE id = ?"
            found = self._database.execute(query, (row,)).fetchone()
            if found is None:
                raise DamagedError("it no longer exists.")
            *values, crc = found
            _check_types(values, columns, f"chunk {row}", self.layout.optional)
            if crc != checksum(values):
                raise DamagedError("its checksum is wrong.")
            head, blobs = values[: len(HEAD)], values[len(HEAD) :]
            named = dict(zip(self.layout.names, blobs, strict=True))
            return _checked_chunk(head, named, self.layout, f"chunk {row}")
        except FileError as error:
            raise self._left_out("chunk", row, error) from None
        except ERRORS as error:
            raise self._left_out("chunk", row, f"{error}.") from None

    def _events(self) -> Iterator[Event]:
        count = size = 0
        accepted: dict[tuple[str, str], tuple[bytes, Any]] = {}
        for row, *values, crc in self._rows("event", (*EVENT, "crc")):
            place = f"event {row}"
            try:
                _check_types(values, EVENT, place)
                time, kind, text = values
                count, size = count + 1, size + len(text)
                if count > _MOST_EVENTS or size > _MOST_TEXT:
                    limits = f"{_MOST_EVENTS:,} events and {_MOST_TEXT:,} characters can be read"
                    self._left_out("event", row, f"{place} and later rows, because at most {limits}.")
                    return
                if crc != checksum(values):
                    raise DamagedError("its checksum is wrong.")
                checked_number(time, f"{place}: time", -MOST_TIME, MOST_TIME, "s")
                checked_text(kind, f"{place}: kind", 40)
                yield Event(time, kind, checked_event(text, kind, place, accepted))
            except FileError as error:
                self._left_out("event", row, error)

    def _index(self) -> list[tuple[int, Chunk, np.ndarray]]:
        """Return each chunk's row number, its header without columns, and its extremes, in order of time."""
        found: list[tuple[int, Chunk, np.ndarray]] = []
        samples, types = 0, {name: self._chunk_columns[name] for name in HEAD}
        for row, *values in self._rows("chunk", HEAD):
            place = f"chunk {row}"
            try:
                _check_types(values, types, place)
                chunk = _checked_chunk(values, {}, self.layout, place)
                blocks = chunk.blocks()
                while found and chunk.start <= found[-1][1].stop:
                    if self._is_whole(found[-1][0]):
                        raise DamagedError(f"it begins before chunk {found[-1][0]} ends.")
                    samples -= found.pop()[1].count
                first = found[0][1].start if found else chunk.start
                checked_number(chunk.stop, f"{place}: stop", first, first + _MOST_SECONDS, "s")
                samples += chunk.count
                if samples > _MOST_IN_ALL:
                    limit = f"at most {_MOST_IN_ALL:,} samples can be read"
                    self._left_out("chunk", row, f"{place} and later rows, because {limit}.")
                    break
                head = Chunk(chunk.count, chunk.start, chunk.stop, chunk.states, b"", {}, self.layout)
                found.append((row, head, blocks))
            except FileError as error:
                self._left_out("chunk", row, error)
        return found

    def _is_whole(self, row: int) -> bool:
        """Return True if a chunk's checksum is correct, so that its times can be trusted.

        The result is cached for the last correct chunk.
        """
        if row != self._whole:
            try:
                self._chunk(row)
            except DamagedError:
                return False
        self._whole = row
        return True

    def _rows(self, table: str, names: Sequence[str]) -> Iterator[tuple]:
        """Yield a table's rows, each with its number first; continue after rows that cannot be read."""
        row, leap = 0, 1
        query = f"SELECT id, {', '.join(names)} FROM {table} WHERE id > ? ORDER BY id"
        while row < _MOST_ROWS:
            try:
                for found in self._database.execute(query, (row,)):
                    if found[0] <= row:  # corrupt pages may refer to each other in a circle
                        self._left_out(
                            table,
                            row + 1,
                            f"{table} {row + 1} and later rows, because they are not in order.",
                        )
                        return
                    row, leap = found[0], 1
                    yield found
                    # the number of messages is limited, because they take memory
                    if len(self._damaged) >= _MOST_DAMAGED:
                        return
                return
            except ERRORS as error:
                self._left_out(table, row + 1, f"{error}.")
                row, leap = row + leap, 2 * leap


def add_note(path: Path, text: str) -> None:
    """Add a note to a complete, undamaged session; the file keeps its date.

    Raise SessionError for any other session, or if the file cannot be written.
    """
    add_events(path, lambda session: [Event(float(session.stops[-1]), NOTE, {"text": text})])


def add_events(path: Path, make: Callable[[Session], Iterable[Event]]) -> None:
    """Add events that are computed from a complete, undamaged session; the file keeps its date.

    Raise SessionError for any other session, or if the file cannot be written.
    """
    with closing(Session(path)) as session:
        if not session.complete:
            raise SessionError(f"{session.unfinished} No note was saved.")
        if damage := session.check():
            raise SessionError(f"{' '.join(damage)} No note was saved.")
        events = list(make(session))
    date = path.stat()
    try:
        with replacing(path) as part:
            shutil.copyfile(path, part)
            with closing(SessionWriter.reopen(part)) as writer:
                for event in events:
                    writer.note(event)
            os.utime(part, ns=(date.st_atime_ns, date.st_mtime_ns))
    except OSError as error:
        raise SessionError(f"{path.name} cannot be written: {error.strerror}.") from None


def _check_types(
    values: Sequence, columns: dict[str, str], place: str, optional: Collection[str] = ()
) -> None:
    """Raise DamagedError if a value's type is not that of its column; an optional value may be NULL."""
    for value, (name, kind) in zip(values, columns.items(), strict=True):
        if not (isinstance(value, _TYPES[kind]) or (value is None and name in optional)):
            raise DamagedError(f"{place}: {name} is {_NAMES[type(value)]}; it must be {kind}.")


def _checked_chunk(
    head: Sequence[Any], columns: dict[str, bytes | None], layout: Layout, place: str
) -> Chunk:
    """Check the limits of the values of HEAD and return a chunk; raise FileError for an invalid value."""
    count, start, stop, states, extremes = head
    checked_integer(count, f"{place}: count", 1, MOST_SAMPLES)
    checked_integer(states, f"{place}: states", 0, MOST_STATES)
    checked_number(start, f"{place}: start", -MOST_TIME, MOST_TIME, "s")
    checked_number(stop, f"{place}: stop", start, MOST_TIME, "s")
    return Chunk(count, start, stop, states, extremes, columns, layout)


def _joined(pieces: list[np.ndarray]) -> np.ndarray:
    """Concatenate arrays; states with fewer values are padded with NaN."""
    if not pieces or pieces[0].ndim == 1:
        return np.concatenate([np.empty(0), *pieces])
    width = max(piece.shape[1] for piece in pieces)
    return np.concatenate(
        [np.pad(p, ((0, 0), (0, width - p.shape[1])), constant_values=math.nan) for p in pieces]
    )

"""The file of a session: an SQLite database of chunks of samples, and of what was set and noted when."""

import json
import sqlite3
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hapkit_studio.errors import StudioError
from hapkit_studio.sessions.chunk import STATE, Chunk
from hapkit_studio.sessions.columns import COLUMNS

VERSION = 1
SUFFIX = ".hapkit"
ABOUT, SETTINGS, STOP, FAULT = "about", "settings", "stop", "fault"
"""Events of which each holds until the next of its kind."""
MARKER = "marker"
"""An event that a person noted, with a text."""
NOTE = "note"
"""What a person noted on all of it afterwards, with a text."""
MARK = 0x4861706B  # "Hapk": SQLite keeps a place in its header for an application's own
_BLOBS = ("extremes", *(column.name for column in COLUMNS), STATE)
_COUNTED = {"count": "INTEGER", "start": "REAL", "stop": "REAL", "states": "INTEGER"}
TABLES = {
    "event": {"time": "REAL", "kind": "TEXT", "what": "TEXT"},
    "chunk": {**_COUNTED, **dict.fromkeys(_BLOBS, "BLOB")},
}
"""Every table's columns and their types; beside them a row has its number and its checksum."""


class SessionError(StudioError):
    """A session cannot be written or read; the text says why and what to do."""


@dataclass(frozen=True)
class Event:
    """What happened at a time in s of the computer's clock: what the session is about, settings, markers."""

    time: float
    kind: str
    what: dict[str, Any]


def schema(table: str) -> str:
    """Return the statement that creates a table, as the file itself has it."""
    columns = ", ".join(f"{name} {kind}" for name, kind in TABLES[table].items())
    return f"CREATE TABLE {table} (id INTEGER PRIMARY KEY, {columns}, crc INTEGER)"


def checksum(values: Iterable) -> int:
    """Return the CRC-32 of a row's values: bytes as they are, anything else as Python writes it."""
    total = 0
    for value in values:
        total = zlib.crc32(value if isinstance(value, bytes) else repr(value).encode(), total)
    return total


class SessionWriter:
    """Writes a new session; what was added stays, even where the program is killed afterwards."""

    def __init__(self, path: str | Path):
        """Begin a file that does not exist yet; raise SessionError."""
        self.path = Path(path)
        try:
            self.path.open("xb").close()
        except FileExistsError:
            raise SessionError(f"{self.path.name} exists already: choose another name.") from None
        except OSError as error:
            raise SessionError(f"{self.path} cannot be written: {error.strerror}.") from None
        self._connect()
        with self._in_words():
            for setting in (f"application_id={MARK}", f"user_version={VERSION}", "journal_mode=WAL"):
                self._database.execute(f"PRAGMA {setting}")
            self._database.execute("PRAGMA synchronous=NORMAL")
            for table in TABLES:
                self._database.execute(schema(table))

    @classmethod
    def reopen(cls, path: Path) -> "SessionWriter":
        """Write more into a session that is complete."""
        writer = cls.__new__(cls)
        writer.path = path
        writer._connect()
        return writer

    def _connect(self) -> None:
        self._database = sqlite3.connect(self.path, isolation_level=None, check_same_thread=False)

    def add(self, chunk: Chunk) -> None:
        """Write a chunk; raise SessionError."""
        blobs = (chunk.extremes, *map(chunk.columns.get, _BLOBS[1:]))
        self._insert("chunk", (chunk.count, chunk.start, chunk.stop, chunk.states, *blobs))

    def note(self, event: Event) -> None:
        """Write what happened; raise SessionError."""
        self._insert("event", (float(event.time), event.kind, json.dumps(event.what, ensure_ascii=False)))

    def _insert(self, table: str, values: tuple) -> None:
        places = ", ".join("?" * (len(values) + 2))
        with self._in_words():
            self._database.execute(
                f"INSERT INTO {table} VALUES ({places})", (None, *values, checksum(values))
            )

    @property
    def size(self) -> int:
        """Return how many bytes the file will have if it is closed now; raise SessionError."""
        with self._in_words():
            pages, of = (self._database.execute(f"PRAGMA {what}") for what in ("page_count", "page_size"))
            return int(pages.fetchone()[0] * of.fetchone()[0])

    def close(self) -> None:
        """Leave one file that is complete; raise SessionError."""
        try:
            with self._in_words():
                self._database.execute("PRAGMA journal_mode=DELETE")
        finally:
            self._database.close()

    @contextmanager
    def _in_words(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            full = error.sqlite_errorname == "SQLITE_FULL"
            why = "The disk is full" if full else f"{self.path.name} cannot be written: {error}"
            raise SessionError(f"{why}. Everything up to there is saved.") from None

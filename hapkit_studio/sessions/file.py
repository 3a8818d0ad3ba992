"""A session's file is an SQLite database with chunks of samples, and events such as settings and markers."""

import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hapkit_studio.errors import StudioError
from hapkit_studio.sessions.chunk import Chunk
from hapkit_studio.sessions.layout import LAYOUT, Layout, tables

VERSION = 2
SUFFIX = ".hapkit"
LOG = "-wal"
"""Suffix of the file that contains the newest samples until a recording has ended."""
ABOUT, SETTINGS, STOP, FAULT = "about", "settings", "stop", "fault"
"""Kinds of events that are valid until the next event of the same kind."""
MARKER = "marker"
"""Kind of an event that the user adds, with a text."""
NOTE = "note"
"""Kind of a note on the whole session, with a text; it is added after the recording."""
MARK = 0x4861706B  # "Hapk": the application id in SQLite's header
TABLES = tables(LAYOUT, VERSION)
"""Columns of every table with their types; each row also has a number and a checksum."""


class SessionError(StudioError):
    """A session cannot be written or read; the message contains the reason and the remedy."""


@dataclass(frozen=True)
class Event:
    """An event at a time in s of the computer's clock, such as a description, settings, or a marker."""

    time: float
    kind: str
    what: dict[str, Any]


def schema(table: str, columns: Mapping[str, str]) -> str:
    """Return the statement that creates a table, exactly as it is stored in the file."""
    named = ", ".join(f"{name} {kind}" for name, kind in columns.items())
    return f"CREATE TABLE {table} (id INTEGER PRIMARY KEY, {named}, crc INTEGER)"


def checksum(values: Iterable) -> int:
    """Return the CRC-32 of a row's values; bytes are used directly, other values as the text of ``repr``."""
    total = 0
    for value in values:
        total = zlib.crc32(value if isinstance(value, bytes) else repr(value).encode(), total)
    return total


class SessionWriter:
    """Writes a new session.

    If the program is killed or the disk is full, two files contain the data; ``remains`` names them. Methods
    raise SessionError if the disk is full or the file was deleted.
    """

    def __init__(self, path: str | Path, layout: Layout = LAYOUT):
        """Create a file, which must not exist yet; ``layout`` is the layout of its chunks."""
        self.path = Path(path)
        self._layout = layout
        try:
            with self.path.open("xb") as file:
                self._identity = _identity(os.fstat(file.fileno()))
        except FileExistsError:
            raise SessionError(f"{self.path.name} exists already: choose another name.") from None
        except OSError as error:
            raise SessionError(f"{self.path} cannot be written: {error.strerror}.") from None
        self._connect()
        with self._reason():
            for setting in (f"application_id={MARK}", f"user_version={VERSION}", "journal_mode=WAL"):
                self._database.execute(f"PRAGMA {setting}")
            self._database.execute("PRAGMA synchronous=NORMAL")
            for table, columns in tables(layout, VERSION).items():
                self._database.execute(schema(table, columns))
        for signal in layout.signals:
            self._insert("signal", tuple(signal))

    @classmethod
    def reopen(cls, path: Path) -> "SessionWriter":
        """Open a complete session for adding events."""
        writer = cls.__new__(cls)
        writer.path = path
        writer._identity = _identity(path.stat())
        writer._connect()
        return writer

    @classmethod
    @contextmanager
    def whole(cls, path: str | Path, layout: Layout = LAYOUT) -> Iterator["SessionWriter"]:
        """Write a complete session; after an error, leave no file."""
        writer = cls(path, layout)
        try:
            yield writer
            writer.close()
        except BaseException:
            writer._database.close()
            for file in (writer.path, writer._log):
                with suppress(OSError):
                    file.unlink()
            raise

    def _connect(self) -> None:
        with self._reason():
            self._database = sqlite3.connect(self.path, isolation_level=None, check_same_thread=False)

    def add(self, chunk: Chunk) -> None:
        blobs = (chunk.extremes, *map(chunk.columns.get, self._layout.names))
        self._insert("chunk", (chunk.count, chunk.start, chunk.stop, chunk.states, *blobs))

    def note(self, event: Event) -> None:
        self._insert("event", (float(event.time), event.kind, json.dumps(event.what, ensure_ascii=False)))

    def _insert(self, table: str, values: tuple) -> None:
        places = ", ".join("?" * (len(values) + 2))
        with self._reason():
            self._check_in_place()
            self._database.execute(
                f"INSERT INTO {table} VALUES ({places})", (None, *values, checksum(values))
            )

    @property
    def size(self) -> int:
        """Return the size in bytes that the file would have if it were closed now."""
        with self._reason():
            pages, of = (self._database.execute(f"PRAGMA {what}") for what in ("page_count", "page_size"))
            return int(pages.fetchone()[0] * of.fetchone()[0])

    def close(self) -> None:
        """Close the session as one complete file."""
        try:
            with self._reason():
                self._check_in_place()
                (mode,) = self._database.execute("PRAGMA journal_mode=DELETE").fetchone()
                if mode != "delete":
                    raise sqlite3.OperationalError("another program is reading it")
        finally:
            self._database.close()

    @property
    def remains(self) -> str:
        """Describe where the data are after an error while writing."""
        name, log = self.path.name, self._log
        if not self._in_place:
            return ""
        if not log.exists():
            return f"The earlier samples are in {name}."
        one = "To make one complete file of them, save a copy (in a terminal: hapkit-studio sessions repair)."
        return f"The earlier samples are in {name} and {log.name}: keep both. {one}"

    @property
    def _log(self) -> Path:
        return self.path.with_name(f"{self.path.name}{LOG}")

    @property
    def _in_place(self) -> bool:
        """Return True if the path still refers to this file; SQLite would also write to a deleted file."""
        try:
            return _identity(self.path.stat()) == self._identity
        except OSError:
            return False

    def _check_in_place(self) -> None:
        if not self._in_place:
            raise SessionError(f"{self.path.name} was deleted or moved while it was written.")

    @contextmanager
    def _reason(self) -> Iterator[None]:
        try:
            yield
        except sqlite3.Error as error:
            self._check_in_place()
            full = getattr(error, "sqlite_errorname", "") == "SQLITE_FULL"
            why = "The disk is full" if full else f"{self.path.name} cannot be written: {error}"
            raise SessionError(f"{why}.") from None


def _identity(found: os.stat_result) -> tuple[int, int]:
    return found.st_dev, found.st_ino

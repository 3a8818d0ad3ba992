"""Opens a session's SQLite file for reading; the content is not trusted, and no file is written beside it.

During a recording the newest samples are in ``NAME-wal``. SQLite keeps an index of that file in ``NAME-shm``
and creates the index if it is missing. If SQLite cannot or must not create it, a private copy is read.
``immutable=1`` would also open a file in a read-only folder, but would ignore ``NAME-wal``.
"""

import os
import shutil
import sqlite3
import stat
import tempfile
import time
from pathlib import Path

from hapkit_studio.errors import FileError
from hapkit_studio.files import open_regular
from hapkit_studio.sessions.columns import DamagedError
from hapkit_studio.sessions.event_values import one_line
from hapkit_studio.sessions.file import LOG, MARK, TABLES, VERSION, SessionError, checksum, schema
from hapkit_studio.sessions.layout import FIRST, MOST_SIGNALS, SIGNAL, Layout, checked_layout, tables

_INDEX, _JOURNAL = "-shm", "-journal"
# maximum time in s to wait for a journal to disappear, and time in s between checks
_JOURNAL_SECONDS, _JOURNAL_POLL = 0.3, 0.01
BESIDE = LOG, _INDEX
"""Suffixes of the files that exist next to a session until its recording has ended."""
SQLITE = b"SQLite format 3\0"
"""The first bytes of a session's file."""
_HEADER = 100  # length of SQLite's header in bytes
# format version in the header while a recording has a NAME-wal; it is 1 after the recording has ended
_WITH_LOG = 2
# maximum number of bytes in a value; a chunk of 65,536 samples with 16 state variables has 4 MB
_LONGEST_VALUE = 1 << 23
_LIMITS = {
    sqlite3.SQLITE_LIMIT_LENGTH: _LONGEST_VALUE,
    sqlite3.SQLITE_LIMIT_SQL_LENGTH: 10_000,
    sqlite3.SQLITE_LIMIT_COLUMN: 100,
    sqlite3.SQLITE_LIMIT_EXPR_DEPTH: 10,
    sqlite3.SQLITE_LIMIT_ATTACHED: 0,
    sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH: 1,
}
# Maximum number of instructions of SQLite's virtual machine until the schema is checked; a session needs 100.
_STEPS = 100_000
_MOST_COPIED = 1 << 32  # maximum number of bytes that are copied
ERRORS = sqlite3.DatabaseError, UnicodeDecodeError
"""Exceptions while reading a foreign file; SQLite's messages may quote text that is not UTF-8."""


def _has_journal(path: Path) -> bool:
    """Return True if a session has a permanent journal.

    A journal also exists for a short time when a recording starts or ends.
    """
    end = time.monotonic() + _JOURNAL_SECONDS
    while there := _size(path.with_name(path.name + _JOURNAL)):
        if time.monotonic() > end:
            break
        time.sleep(_JOURNAL_POLL)
    return bool(there)


class Database:
    """A read-only connection to a session's file.

    ``layout`` is the layout of the file's chunks. ``complete`` is True if the recording has ended.
    ``log_lost`` is True if the recording has not ended and ``NAME-wal`` with its newest samples is missing.
    """

    def __init__(self, path: Path):
        """Open a session.

        Raise SessionError if the file is not a session, or if a newer version of the studio has written it.
        """
        header, name = _header(path), one_line(path.name)
        self.complete = header[18] != _WITH_LOG
        log, index = (_size(path.with_name(path.name + ending)) for ending in (LOG, _INDEX))
        if _has_journal(path):
            raise SessionError(
                f"{name} is incomplete: the file {name}{_JOURNAL} next to it shows that another program was "
                "changing it."
            )
        self.log_lost = not self.complete and not log
        self.version = _version(header)
        self._copy: tempfile.TemporaryDirectory | None = None
        try:
            self.connection, self.layout = self._connection(path, needs_copy=bool(log) and not index)
        except (*ERRORS, OSError, DamagedError, SessionError) as error:
            self._remove_copy()
            if self.log_lost and not isinstance(error, OSError):
                raise SessionError(f"{name} has lost its samples, which were in {name}{LOG}.") from None
            if isinstance(error, SessionError):
                raise
            why = getattr(error, "strerror", "") or one_line(str(error))
            raise SessionError(f"{name} cannot be read: {why}.") from None

    @property
    def tables(self) -> dict[str, dict[str, str]]:
        """Return the columns of each table with their types."""
        return tables(self.layout, self.version)

    def _connection(self, path: Path, needs_copy: bool) -> tuple[sqlite3.Connection, Layout]:
        if not needs_copy:
            try:
                return _connect(path, "mode=ro&immutable=1" if self.log_lost else "mode=ro", self.version)
            except sqlite3.OperationalError as error:
                # only errors that SQLite has reported have this attribute
                name = getattr(error, "sqlite_errorname", "")
                if not name.startswith(("SQLITE_CANTOPEN", "SQLITE_READONLY")):
                    raise
        return _connect(self._copied(path), "mode=rw", self.version)

    def close(self) -> None:
        """Close the file, and delete the private copy."""
        self.connection.close()
        self._remove_copy()

    def _copied(self, path: Path) -> Path:
        """Return a copy of a file and its log in a temporary folder.

        Raise SessionError if the file is too large, and OSError if the copy cannot be written.
        """
        log = path.with_name(path.name + LOG)
        size = _size(path) + _size(log)
        if size > _MOST_COPIED:
            name = one_line(path.name)
            step = f"copy it and {name}{LOG} into a folder in which you may write"
            raise SessionError(f"{name} cannot be read from its folder: {step}.")
        self._copy = tempfile.TemporaryDirectory(prefix="hapkit-session-")
        copy = Path(self._copy.name) / path.name
        shutil.copyfile(path, copy)
        if log.exists():
            shutil.copyfile(log, copy.with_name(log.name))
        return copy

    def _remove_copy(self) -> None:
        if self._copy is not None:
            self._copy.cleanup()


def _header(path: Path) -> bytes:
    """Return the file's header; raise SessionError if the file is not a readable session."""
    try:
        with open_regular(path) as file:
            header = file.read(_HEADER)
    except FileError as error:
        raise SessionError(one_line(str(error))) from None
    except OSError as error:
        raise SessionError(f"Cannot read {one_line(str(path))}: {error.strerror}.") from None
    if not header.startswith(SQLITE) or int.from_bytes(header[68:72], "big") != MARK:
        raise _foreign(path)
    version = _version(header)
    if version > VERSION:
        newer = (
            f"{one_line(path.name)} was made by a newer version of this program (file version {version}, "
            f"not {VERSION})"
        )
        raise SessionError(f"{newer}. Update the program.")
    return header


def _version(header: bytes) -> int:
    return int.from_bytes(header[60:64], "big")


def _foreign(path: Path) -> SessionError:
    return SessionError(f"{one_line(path.name)} is not a session of Hapkit Studio.")


def _size(path: Path) -> int:
    """Return a file's size in bytes, 0 if it is missing; raise SessionError if it is not a regular file."""
    try:
        found = os.stat(path)
    except OSError:
        return 0
    if not stat.S_ISREG(found.st_mode):
        raise SessionError(
            f"{one_line(path.name)} is a folder or a device, not a file, so it cannot be read."
        )
    return found.st_size


def _connect(path: Path, how: str, version: int) -> tuple[sqlite3.Connection, Layout]:
    """Open a session's file; return the connection and the file's layout.

    Raise SessionError if the file has other tables than a session, DamagedError if its layout is invalid, and
    DatabaseError for errors of SQLite.
    """
    uri = f"{path.resolve().as_uri()}?{how}"
    database = sqlite3.connect(uri, uri=True, isolation_level=None, check_same_thread=False)
    try:
        for limit, value in _LIMITS.items():
            database.setlimit(limit, value)
        for setting in ("trusted_schema=OFF", "cell_size_check=ON"):
            database.execute(f"PRAGMA {setting}")
        database.set_progress_handler(lambda: 1, _STEPS)  # this interrupts a statement that exceeds the limit
        found = database.execute(f"SELECT name, sql FROM sqlite_master LIMIT {len(TABLES) + 1}").fetchall()
        made = dict(found)
        # The tables are read below, so they must not be replaced by a view or trigger.
        if version > 1 and made.get("signal") != schema("signal", SIGNAL):
            raise _foreign(path)
        layout = FIRST if version <= 1 else _layout(database)
        database.set_progress_handler(None, 0)
        if made != {name: schema(name, columns) for name, columns in tables(layout, version).items()}:
            raise _foreign(path)
    except (*ERRORS, DamagedError, SessionError):
        database.close()
        raise
    return database, layout


def _layout(database: sqlite3.Connection) -> Layout:
    """Return the file's layout.

    Raise DamagedError for an invalid layout, and DatabaseError for errors of SQLite.
    """
    query = f"SELECT {', '.join(SIGNAL)}, crc FROM signal ORDER BY id LIMIT {MOST_SIGNALS + 1}"
    found = database.execute(query).fetchall()
    for *values, crc in found:
        if crc != checksum(values):
            raise DamagedError("the list of its signals is damaged")
    return checked_layout([tuple(values) for *values, _ in found])

"""The newest samples of a running engine, on which the checks of an open step are evaluated."""

import time
from collections import deque
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.rows import RingReader
from hapkit_studio.sessions import settings_events
from hapkit_studio.settings_log import LoggedSettings

MOST_SECONDS = 60.0
MOST_ROWS = 120_000  # maximum number of rows: 32 MB, or 30 s at 4 kHz


@dataclass(frozen=True)
class Rows:
    """Telemetry rows (n, ROW_WIDTH), and device and settings with the time in s from which they are valid."""

    tables: tuple[np.ndarray, ...]
    log: tuple[tuple[float, LoggedSettings, LoggedSettings], ...]

    @property
    def table(self) -> np.ndarray:
        """Return all rows as one table."""
        return np.concatenate(self.tables) if self.tables else np.empty((0, rows.ROW_WIDTH))


class Recent:
    """Keeps an engine's rows of the last minute; ``read`` is called ten times per second."""

    def __init__(self) -> None:
        self._engine: Engine | None = None
        self._reader: RingReader | None = None
        self._tables: deque[np.ndarray] = deque()
        self._log: deque[tuple[float, LoggedSettings, LoggedSettings]] = deque()

    def follow(self, engine: Engine | None) -> None:
        """Read this engine's rows from now on (None: no engine); previous rows are discarded."""
        self._engine = engine
        self._reader = None if engine is None else engine.reader()
        self.clear()

    def clear(self) -> None:
        """Discard all rows up to now."""
        if self._reader is not None:
            self._reader.read()
        self._tables.clear()
        self._log.clear()

    def read(self) -> bool:
        """Read new rows and, if they have changed, the settings; return whether there are new rows."""
        if self._engine is None or self._reader is None:
            return False
        about, settings = settings_events.about_device(self._engine), settings_events.in_force(self._engine)
        if not self._log or self._log[-1][1:] != (about, settings):
            self._log.append((time.perf_counter(), about, settings))
        new = self._reader.read()
        if len(new):
            self._tables.append(new)
            self._forget(float(new[-1, rows.HOST_TIME]))
        return bool(len(new))

    def rows(self) -> Rows:
        """Return a copy of the stored rows, which does not change any more."""
        return Rows(tuple(self._tables), tuple(self._log))

    def _forget(self, now: float) -> None:
        tables = self._tables
        count = sum(map(len, tables))
        while tables and (count > MOST_ROWS or tables[0][-1, rows.HOST_TIME] < now - MOST_SECONDS):
            count -= len(tables.popleft())
        begin = tables[0][0, rows.HOST_TIME] if tables else now
        while len(self._log) > 1 and self._log[1][0] <= begin:
            self._log.popleft()

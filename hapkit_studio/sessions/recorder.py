"""The recorder keeps an engine's last ten minutes in memory, and records sessions on request.

It runs in its own thread. Loop and window wait for it only when a file is completed.
"""

import queue
import time
import traceback
from collections import deque
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hapkit_studio.errors import DeviceError
from hapkit_studio.haptics import rows
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.rows import RingReader
from hapkit_studio.sessions import settings_events
from hapkit_studio.sessions.chunk import Chunk, pack
from hapkit_studio.sessions.file import (
    ABOUT,
    FAULT,
    MARKER,
    SETTINGS,
    STOP,
    Event,
    SessionError,
    SessionWriter,
)
from hapkit_studio.worker import Worker

BUFFER_SECONDS = 600.0
CHUNK_SECONDS = 0.3
# maximum number of rows per read; it limits the size of chunks, and the memory if the thread was delayed
_AT_ONCE = 512
# kinds of events that are valid until the next event of the same kind
_STANDING = (ABOUT, SETTINGS, STOP, FAULT)
_POLL_SECONDS = 0.05
# If no sample arrives for this time in s, the chunk ends, so that time is uniform within a chunk.
_GAP_SECONDS = 0.25

CLOCK_JUMPED = "The board's clock jumped: its time was corrected."

_T = TypeVar("_T")


@dataclass(frozen=True)
class Progress:
    """The state of a recording: its file, number of samples, size in bytes, and duration in s.

    If the recording ended by itself, ``error`` is the reason.
    """

    path: Path
    samples: int = 0
    size: int = 0
    seconds: float = 0.0
    error: str = ""


class Recorder:
    """Keeps an engine's newest samples and events in memory.

    ``record`` writes new samples to a file, and ``save`` writes the samples in memory. Settings, E-stop and
    faults are polled 20 times per second and recorded as events if they have changed.
    """

    def __init__(self, seconds: float = BUFFER_SECONDS, truth: bool = False):
        """Start the recorder, which keeps the last ``seconds`` of samples in memory.

        If ``truth``, the true motion, and the hand's force and target of a simulation are also recorded.
        """
        self._seconds, self._truth = seconds, truth
        self.progress: Progress | None = None
        """The progress of the present recording, or of the last one if it ended by itself.

        It is None before the first recording.
        """
        self.buffered = 0.0
        """Age in s of the oldest sample that ``save`` would write."""
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._open = True
        self._engine: Engine | None = None
        self._reader: RingReader | None = None
        self._pending: list[np.ndarray] = []
        self._seen: dict[str, dict[str, Any]] = {}
        self._states = self._clock_jumps = 0
        self._chunks: deque[Chunk] = deque()
        self._events: deque[Event] = deque()
        self._base: dict[str, Event] = {}  # the settings that were valid before the oldest chunk
        self._writer: SessionWriter | None = None
        self._worker = Worker("hapkit-recorder")
        self._ended = self._worker.submit(self._run)

    # --- called from other threads

    def follow(self, engine: Engine | None) -> None:
        """Record this engine's rows from now on; None records no rows."""
        self._jobs.put(lambda: self._change_to(engine))

    def note(self, kind: str, what: dict[str, Any], when: float | None = None) -> None:
        """Add an event, such as a marker, now or at a time in s of the computer's clock."""
        event = Event(time.perf_counter() if when is None else when, kind, what)
        self._jobs.put(lambda: self._add(event))

    def record(self, path: str | Path) -> None:
        """Record all samples from now on into a new session.

        Raise SessionError if the file cannot be created.
        """
        self.request(lambda: Path(path))()

    def request(self, path: Callable[[], Path]) -> Callable[[], None]:
        """Request a recording into the file ``path()`` and return a function that waits for its start.

        Events noted after this call are recorded. The function raises SessionError if the file cannot be
        created.
        """
        return self._queue(lambda: self._begin(path()))

    def stop(self) -> Path | None:
        """End the recording and return its file; None without a recording.

        Raise SessionError if the file cannot be completed.
        """
        return self._wait(self._end)

    def save(self, path: str | Path) -> int:
        """Write the samples in memory into a new session and return their number.

        This takes about 1 s. Raise SessionError if there are no samples or the file cannot be written.
        """
        return self._wait(lambda: self._save(path))

    def close(self) -> None:
        """End the recording and the thread; raise SessionError if the file cannot be completed."""
        try:
            self.stop()
        finally:
            self._open = False
            self._worker.shutdown()

    def _wait(self, job: Callable[[], _T]) -> _T:
        """Run a job in the thread; return its result or raise its exception."""
        return self._queue(job)()

    def _queue(self, job: Callable[[], _T]) -> Callable[[], _T]:
        """Queue a job for the thread; return a function that waits for its result or exception."""
        done: Future[_T] = Future()
        waited: list[Future[Any]] = [done, self._ended]

        def run() -> None:
            try:
                done.set_result(job())
            except BaseException as error:
                done.set_exception(error)

        def result() -> _T:
            wait(waited, return_when=FIRST_COMPLETED)
            if not done.done():  # a defect has ended the recorder, so waiting would never end
                raise SessionError("The recorder has failed: recording has ended.")
            return done.result()

        self._jobs.put(run)
        return result

    # --- in the recorder's thread

    def _run(self) -> None:
        try:
            while self._open:
                with suppress(queue.Empty):
                    self._jobs.get(timeout=_POLL_SECONDS)()
                self._take()
        except Exception:
            traceback.print_exc()
            raise

    def _change_to(self, engine: Engine | None) -> None:
        # first write the previous engine's rows, so that times increase even while both loops run
        self._flush()
        self._reader = None if engine is None else engine.reader()
        self._engine, self._seen = engine, {}
        self._clock_jumps = 0 if engine is None else engine.clock_jumps

    def _begin(self, path: Path) -> None:
        self._end()
        writer = SessionWriter(path)
        # the latest event of each kind that is valid until the next one
        valid = self._base | {event.kind: event for event in self._events if event.kind in _STANDING}
        for event in valid.values():
            writer.note(event)
        self._writer, self.progress = writer, Progress(writer.path)

    def _end(self) -> Path | None:
        self._flush()
        writer, self._writer = self._writer, None
        if writer is None:
            return None
        self.progress = None
        _close(writer)
        return writer.path

    def _save(self, path: str | Path) -> int:
        self._flush()
        if not self._chunks:
            raise SessionError("There is nothing to save: no sample arrived.")
        with SessionWriter.whole(path) as writer:
            for event in (*self._base.values(), *self._events):
                writer.note(event)
            for chunk in self._chunks:
                writer.add(chunk)
        return sum(chunk.count for chunk in self._chunks)

    def _flush(self) -> None:
        self._take()
        self._pack(0.0)

    def _take(self) -> None:
        if self._engine is None or self._reader is None:
            return
        with suppress(DeviceError):  # the engine was closed meanwhile, but its last rows can still be read
            self._poll(self._engine)
        if not self._seen:
            return
        # The number of reads is limited, because the loop may write faster than this thread packs.
        for _ in range(0, rows.CAPACITY, _AT_ONCE):
            new = self._reader.read(_AT_ONCE)
            if len(new):
                self._pending.append(new)
            self._pack(CHUNK_SECONDS)
            if len(new) < _AT_ONCE:
                break
        if not self._pending:
            self._states = len(self._engine.environment.state_names)

    def _poll(self, engine: Engine) -> None:
        """Add events for changes since the last call."""
        fault = engine.fault
        now = {
            ABOUT: settings_events.about_device(engine),
            SETTINGS: settings_events.in_force(engine),
            STOP: {"stopped": engine.stopped},
            FAULT: {"text": "" if fault is None else fault.text},
        }
        for kind, what in now.items():
            if what != self._seen.get(kind):
                self._add(Event(time.perf_counter(), kind, what))
        self._seen = now
        if engine.clock_jumps != self._clock_jumps:
            self._clock_jumps = engine.clock_jumps
            self._add(Event(time.perf_counter(), MARKER, {"text": CLOCK_JUMPED}))
        self._states = max(self._states, len(engine.environment.state_names))

    def _pack(self, seconds: float) -> None:
        """Pack the pending rows into chunks once they cover at least ``seconds``."""
        if not self._pending or self._engine is None:
            return
        first, last = self._pending[0][0, rows.HOST_TIME], self._pending[-1][-1, rows.HOST_TIME]
        if last - first < seconds and time.perf_counter() - last < _GAP_SECONDS:
            return
        table, quantum = np.concatenate(self._pending), self._seen[ABOUT]["quantum_m"]
        gaps = np.flatnonzero(np.diff(table[:, rows.HOST_TIME]) > _GAP_SECONDS) + 1
        for part in np.split(table, gaps):
            self._add_chunk(pack(part, quantum, self._states, self._truth))
        self._pending = []

    def _add_chunk(self, chunk: Chunk) -> None:
        self._chunks.append(chunk)
        while self._chunks[0].stop < chunk.stop - self._seconds:
            self._chunks.popleft()
        while self._events and self._events[0].time < self._chunks[0].start:
            event = self._events.popleft()
            if event.kind in _STANDING:
                self._base[event.kind] = event
        self.buffered = chunk.stop - self._chunks[0].start
        self._write(lambda writer: self._add_to(writer, chunk))

    def _add_to(self, writer: SessionWriter, chunk: Chunk) -> None:
        writer.add(chunk)
        before = self.progress or Progress(writer.path)
        seconds = before.seconds + chunk.stop - chunk.start
        self.progress = Progress(writer.path, before.samples + chunk.count, writer.size, seconds)

    def _add(self, event: Event) -> None:
        self._events.append(event)
        self._write(lambda writer: writer.note(event))

    def _write(self, write: Callable[[SessionWriter], None]) -> None:
        """Write to the session; if this fails, end the recording and store the reason."""
        if self._writer is None or self.progress is None:
            return
        try:
            write(self._writer)
        except SessionError as error:
            writer, self._writer = self._writer, None
            with suppress(SessionError):
                writer.close()
            self.progress = replace(self.progress, error=f"{error} {writer.remains}".rstrip())


def _close(writer: SessionWriter) -> None:
    """Close a session; raise SessionError, which names the files with its samples."""
    try:
        writer.close()
    except SessionError as error:
        raise SessionError(f"{error} {writer.remains}".rstrip()) from None

"""The recording of the current device's data; the same recorder is used for every device."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import clock
from hapkit_studio.gui.state.background import Job
from hapkit_studio.gui.state.device_link import DeviceLink
from hapkit_studio.sessions.file import MARKER
from hapkit_studio.sessions.folder import new_path

if TYPE_CHECKING:
    from hapkit_studio.sessions.recorder import Progress, Recorder

POLL_MS = 250


class Recording(QObject):
    """Buffers the data of the current device, and records them; all disk access happens in threads.

    ``changed`` is emitted when the progress or the files have changed. ``failed`` is emitted with two
    sentences: which action failed, and why. ``newest`` is the file that was written last, with its size in
    bytes.
    """

    changed = Signal()
    failed = Signal(str, str)

    def __init__(self, device: DeviceLink, environment: Callable[[], str], parent: QObject):
        """``environment()`` returns the current environment's key; the names of files begin with this key."""
        super().__init__(parent)
        self._device, self._environment = device, environment
        self._recorder: Recorder | None = None
        self._ended: Progress | None = None  # the recording whose unexpected end has been reported
        self.newest: tuple[Path, int] | None = None
        self._end_wanted = False
        self._turn = self._job("Recording failed.")
        self._save = self._job("Nothing was saved.")
        self._poll = QTimer(self, interval=POLL_MS)
        self._poll.timeout.connect(self._refresh)
        device.engine_changed.connect(self._follow)

    @property
    def progress(self) -> "Progress | None":
        """Return the recording's progress; None without a recording."""
        progress = self._recorder.progress if self._recorder is not None else None
        return None if progress is None or progress.error else progress

    @property
    def buffered(self) -> float:
        """Return the length in s of the buffered samples that ``save_buffer`` would write."""
        return self._recorder.buffered if self._recorder is not None else 0.0

    @property
    def possible(self) -> bool:
        """Return whether a recording can be started or stopped."""
        return self._device.engine is not None or self.progress is not None

    def toggle(self) -> None:
        """Start a recording in a new file, or end the current one."""
        recorder, key = self._recorder, self._environment()
        if recorder is None or self._turn.running:
            return
        if self.progress is None:
            wait = recorder.request(lambda: new_path(key))
            self._turn.start(lambda _progress: wait())
        else:
            self._turn.start(lambda _progress: _written(recorder.stop()))

    def end(self) -> None:
        """End the current recording, even if it is still being started."""
        if self._turn.running:
            self._end_wanted = True
        elif self.progress is not None:
            self.toggle()

    def save_buffer(self) -> None:
        """Write the buffered samples into a new file."""
        recorder, key = self._recorder, self._environment()
        if recorder is None or self._save.running:
            return

        def save(_progress: object) -> tuple[Path, int] | None:
            path = new_path(key)
            recorder.save(path)
            return _written(path)

        self._save.start(save)

    def mark(self, text: str, when: float) -> None:
        """Add a marker at a time in s of the rows' clock."""
        self.note(MARKER, {"text": text}, when)

    def note(self, kind: str, what: dict[str, Any], when: float | None = None) -> None:
        """Add an event at a time in s of the rows' clock, by default now."""
        if self._recorder is not None:
            self._recorder.note(kind, what, when)

    def close(self) -> None:
        """End the recording so that its file is complete, and close the recorder."""
        self._poll.stop()
        for job in (self._turn, self._save):
            job.wait()
        if self._recorder is not None:
            with suppress(StudioError):  # the window is closing; there is nowhere to show the error
                self._recorder.close()

    def _job(self, failure: str) -> Job:
        job = Job(self, needs="", must_finish=True)
        job.finished.connect(self._finish)
        job.failed.connect(lambda text: self.failed.emit(failure, text))
        return job

    def _follow(self) -> None:
        engine = self._device.engine
        if self._recorder is None and engine is not None:
            from hapkit_studio.sessions.recorder import Recorder  # imported late to keep start-up fast

            self._recorder = Recorder()
            self._poll.start()
        if self._recorder is not None:
            self._recorder.follow(engine)

    def _finish(self, written: tuple[Path, int] | None) -> None:
        self.newest = written
        if self._end_wanted:
            self._end_wanted = False
            self.end()
        self.changed.emit()

    def _refresh(self) -> None:
        """If a recording has ended with an error, report this once."""
        progress = self._recorder.progress if self._recorder is not None else None
        if progress is not None and progress.error and progress != self._ended:
            self._ended = progress
            self.newest = _written(progress.path)
            why = progress.error
            if self.newest is None:
                why = (
                    f"{why} The samples are still in memory: choose Save the last 10 minutes (Ctrl+Shift+S)."
                )
            self.failed.emit(f"Recording stopped at {clock(progress.seconds)}.", why)
        self.changed.emit()


def _written(path: Path | None) -> tuple[Path, int] | None:
    return None if path is None or not path.exists() else (path, path.stat().st_size)

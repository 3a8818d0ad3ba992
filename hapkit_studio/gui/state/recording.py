"""Recording in the window: one recorder follows the device in use."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

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
    """Keeps what comes from the device in use, and records it; all that touches the disk is done in threads.

    ``changed``: look at it anew. ``failed``: in two sentences what was not done, and why. ``newest`` is the
    file written last, with its bytes.
    """

    changed = Signal()
    failed = Signal(str, str)

    def __init__(self, device: DeviceLink, environment: Callable[[], str], parent: QObject):
        """environment: returns the key of the environment in force, with which names of files begin."""
        super().__init__(parent)
        self._device, self._environment = device, environment
        self._recorder: Recorder | None = None
        self._ended: Progress | None = None  # the recording whose end by itself was said
        self.newest: tuple[Path, int] | None = None
        self._turn = self._job("Recording failed.")
        self._save = self._job("Nothing was saved.")
        self._looks = QTimer(self, interval=POLL_MS)
        self._looks.timeout.connect(self._refresh)
        device.engine_changed.connect(self._follow)

    @property
    def progress(self) -> "Progress | None":
        """Return how far the recording is, None while there is none."""
        progress = self._recorder.progress if self._recorder is not None else None
        return None if progress is None or progress.error else progress

    @property
    def kept(self) -> float:
        """Return how many s ``save_kept`` would write."""
        return self._recorder.kept if self._recorder is not None else 0.0

    @property
    def possible(self) -> bool:
        """Say whether there is anything to record, or a recording to end."""
        return self._device.engine is not None or self.progress is not None

    def toggle(self) -> None:
        """Begin to record into a new file, or end the file."""
        recorder, key = self._recorder, self._environment()
        if recorder is None or self._turn.running:
            return
        if self.progress is None:
            self._turn.start(lambda _progress: recorder.record(new_path(key)))
        else:
            self._turn.start(lambda _progress: _written(recorder.stop()))

    def save_kept(self) -> None:
        """Write what already happened into a new file."""
        recorder, key = self._recorder, self._environment()
        if recorder is None or self._save.running:
            return

        def save(_progress: object) -> tuple[Path, int] | None:
            path = new_path(key)
            recorder.save(path)
            return _written(path)

        self._save.start(save)

    def mark(self, text: str, when: float) -> None:
        """Note a marker at a time in s of the rows' clock."""
        if self._recorder is not None:
            self._recorder.note(MARKER, {"text": text}, when)

    def close(self) -> None:
        """End the recording, its file whole, and the recorder."""
        self._looks.stop()
        for job in (self._turn, self._save):
            job.wait()
        if self._recorder is not None:
            with suppress(StudioError):  # nobody is left to be told
                self._recorder.close()

    def _job(self, failure: str) -> Job:
        job = Job(self, needs="", must_finish=True)
        job.finished.connect(self._finish)
        job.failed.connect(lambda text: self.failed.emit(failure, text))
        return job

    def _follow(self) -> None:
        engine = self._device.engine
        if self._recorder is None and engine is not None:
            from hapkit_studio.sessions.recorder import Recorder  # late: keeps start-up fast

            self._recorder = Recorder()
            self._looks.start()
        if self._recorder is not None:
            self._recorder.follow(engine)

    def _finish(self, written: tuple[Path, int] | None) -> None:
        self.newest = written
        self.changed.emit()

    def _refresh(self) -> None:
        """Say it once where a recording has ended by itself."""
        progress = self._recorder.progress if self._recorder is not None else None
        if progress is not None and progress.error and progress != self._ended:
            self._ended = progress
            self.newest = _written(progress.path)
            why = progress.error
            if self.newest is None:
                why = f"{why} Save the last 10 minutes (Ctrl+Shift+S) writes what is still kept."
            self.failed.emit(f"Recording stopped at {clock(progress.seconds)}.", why)
        self.changed.emit()


def _written(path: Path | None) -> tuple[Path, int] | None:
    return None if path is None or not path.exists() else (path, path.stat().st_size)

"""Has a file tried out in a program of its own; a thread that only waits for it tells the window."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from hapkit_studio.workshop import trial
from hapkit_studio.workshop.verdict import Verdict, failed

LOOK_SECONDS = 0.02


class TrialRunner(QObject):
    """Emits ``finished(path, verdict)``; beginning again gives up what has not ended yet."""

    finished = Signal(object, object)
    _ended = Signal(object, object, object)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.path: Path | None = None
        self._unwanted = threading.Event()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="trial")
        self._ended.connect(self._deliver)

    def begin(self, path: Path) -> None:
        """Start a file's trial."""
        self.give_up()
        self.path = path
        self._worker.submit(self._work, path, self._unwanted)

    def give_up(self) -> None:
        """Want no verdict any more; the program ends soon."""
        self._unwanted.set()
        self._unwanted = threading.Event()
        self.path = None

    def close(self) -> None:
        """Give up and wait until no program is left."""
        self.give_up()
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _work(self, path: Path, unwanted: threading.Event) -> None:
        try:
            verdict = _tried(path, unwanted)
        except OSError as error:
            verdict = failed(f"the file cannot be tried out: {error.strerror}")
        self._ended.emit(path, verdict, unwanted)

    def _deliver(self, path: Path, verdict: Verdict, unwanted: threading.Event) -> None:
        if not unwanted.is_set():
            self.path = None
            self.finished.emit(path, verdict)


def _tried(path: Path, unwanted: threading.Event) -> Verdict:
    """Return a file's verdict; end its program where it takes too long or nobody wants to know."""
    process = trial.begin(path)
    end = time.monotonic() + trial.TIMEOUT
    while process.poll() is None:
        if unwanted.wait(LOOK_SECONDS) or time.monotonic() > end:
            return trial.stop(process)
    return trial.result(process)

"""Has a file tried out in a program of its own; a thread that only waits for it tells the window."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from hapkit_studio.workshop import trial
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.verdict import Verdict, failed

LOOK_SECONDS = 0.02


class TrialRunner(QObject):
    """Emits ``finished(source, verdict)``; beginning again gives up what has not ended yet."""

    finished = Signal(object, object)
    _ended = Signal(object, object, object)

    def __init__(self, parent: QObject | None = None):
        super().__init__(parent)
        self.path: Path | None = None
        self._unwanted = threading.Event()
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="trial")
        self._ended.connect(self._deliver)

    def begin(self, source: Source) -> None:
        """Start the trial of a text."""
        self.give_up()
        self.path = source.path
        self._worker.submit(self._work, source, self._unwanted)

    def give_up(self) -> None:
        """Want no verdict any more; the program ends soon."""
        self._unwanted.set()
        self._unwanted = threading.Event()
        self.path = None

    def close(self) -> None:
        """Give up and wait until no program is left."""
        self.give_up()
        self._worker.shutdown(wait=True, cancel_futures=True)

    def _work(self, source: Source, unwanted: threading.Event) -> None:
        try:
            verdict = _tried(source, unwanted)
        except OSError as error:
            verdict = failed(f"the file cannot be tried out: {error.strerror}")
        self._ended.emit(source, verdict, unwanted)

    def _deliver(self, source: Source, verdict: Verdict, unwanted: threading.Event) -> None:
        if not unwanted.is_set():
            self.path = None
            self.finished.emit(source, verdict)


def _tried(source: Source, unwanted: threading.Event) -> Verdict:
    """Return the verdict on a text; end its program where it takes too long or nobody wants to know."""
    process = trial.begin(source)
    end = time.monotonic() + trial.TIMEOUT
    while process.poll() is None:
        if unwanted.wait(LOOK_SECONDS) or time.monotonic() > end:
            return trial.stop(process)
    return trial.result(process)

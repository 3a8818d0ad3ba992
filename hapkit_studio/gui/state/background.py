"""Background work: long jobs that report progress and can be cancelled, and quick requests.

If several requests wait, only the newest is answered.
"""

import time
import traceback
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import Cancelled, StudioError
from hapkit_studio.gui.state import prepare
from hapkit_studio.worker import Worker

Progress = Callable[[int, int], None]
Work = Callable[[Progress], Any]

_PROGRESS_SECONDS = 0.05
_POLL_SECONDS = 0.05
LATE_MS = 100
"""ms: after this time without an answer, ``late`` is emitted, and the previous answer is shown as stale."""


class Job(QObject):
    """Runs one job at a time in a thread; a new job cancels the running one, and begins after its end.

    ``work(progress)`` returns the result. It must call ``progress(done, of)`` often; this call raises once
    the job is cancelled. ``needs`` is the part of the program (see ``prepare``) that must be compiled before
    the job, or "". ``preparing`` is emitted while this part is being compiled. If ``must_finish`` is True,
    ``end`` waits for the job and does not cancel it, because an incomplete file is useless.
    """

    preparing = Signal()
    progressed = Signal(int, int)
    finished = Signal(object)
    failed = Signal(str)
    running_changed = Signal(bool)
    _done = Signal(object, object, str)

    def __init__(self, parent: QObject | None = None, needs: str = "analysis", must_finish: bool = False):
        super().__init__(parent)
        self._needs, self._must_finish = needs, must_finish
        self._wanted: object = None
        self._worker = Worker("measuring")
        self._done.connect(self._deliver)

    @property
    def running(self) -> bool:
        """Return whether a job is running and not cancelled."""
        return self._wanted is not None

    def start(self, work: Work) -> None:
        """Start a job; a running job is cancelled."""
        token = self._wanted = object()
        self._worker.submit_newest(self._work, work, token)
        self.running_changed.emit(True)

    def cancel(self) -> None:
        """Cancel the job at its next call of progress."""
        if self._wanted is not None:
            self._wanted = None
            self.running_changed.emit(False)

    def wait(self) -> None:
        """Wait until the job has ended; tests and the closing window call this."""
        self._worker.wait()

    def end(self) -> None:
        """Cancel the job unless it must finish, and wait for the thread."""
        if not self._must_finish:
            self.cancel()
        self._worker.shutdown()
        self._worker = Worker("measuring")  # for the next job, because a closed page may be opened again

    def _check(self, token: object) -> None:
        """Raise Cancelled unless the job with this token is wanted."""
        if token is not self._wanted:
            raise Cancelled("cancelled")

    def _work(self, work: Work, token: object) -> None:
        reported = 0.0

        def progress(done: int, of: int) -> None:
            nonlocal reported
            self._check(token)
            now = time.monotonic()
            if done >= of or now - reported > _PROGRESS_SECONDS:
                reported = now
                self.progressed.emit(done, of)

        try:
            self._check(token)
            self._prepare(token)
            self._done.emit(token, work(progress), "")
        except Cancelled:
            pass
        except StudioError as error:
            self._done.emit(token, None, str(error))
        except Exception as error:  # this is a defect: report it and keep the window running
            traceback.print_exc()
            self._done.emit(token, None, f"An error occurred: {error}")

    def _prepare(self, token: object) -> None:
        """Wait until another program has compiled the needed part; compiling here would freeze the window."""
        program = prepare.begin(self._needs) if self._needs else None
        if program is None:
            return
        self.preparing.emit()
        while program.poll() is None:
            if self._wanted is not token:
                program.kill()
                program.wait()
                raise Cancelled("cancelled")
            time.sleep(_POLL_SECONDS)

    def _deliver(self, token: object, result: object, text: str) -> None:
        if token is not self._wanted:
            return
        self._wanted = None
        self.running_changed.emit(False)
        if text:
            self.failed.emit(text)
        else:
            self.finished.emit(result)


class LatestResult(QObject):
    """Answers the newest request in a thread and emits ``answered``; a new request replaces a waiting one.

    ``late`` is emitted if no answer is found within LATE_MS; the shown result is then out of date.
    """

    answered = Signal(object)
    late = Signal()
    _done = Signal(object)

    def __init__(self, solve: Callable[[Any], Any], parent: QObject | None = None):
        super().__init__(parent)
        self._solve = solve
        self._newest: Any = None
        self._job: Future[Any] | None = None
        self._worker = Worker("answers")
        self._waiting = QTimer(self, interval=LATE_MS, singleShot=True)
        self._waiting.timeout.connect(self.late)
        self._done.connect(self._deliver)

    def ask(self, request: Any) -> None:
        """Add a request, unless it equals the last one."""
        if request == self._newest:
            return
        self._drop()
        self._newest = request
        if not self._waiting.isActive():
            self._waiting.start()
        self._job = self._worker.submit_newest(self._solve, request)
        self._job.add_done_callback(self._done.emit)

    def forget(self) -> None:
        """Discard the waiting request."""
        self._waiting.stop()
        self._drop()

    def _drop(self) -> None:
        job, self._newest, self._job = self._job, None, None
        if job is not None:
            job.cancel()

    def wait(self) -> None:
        """Wait until every request is answered."""
        self._worker.wait()

    def end(self) -> None:
        """Discard the waiting request and end the thread."""
        self.forget()
        self._worker.shutdown()

    def _deliver(self, job: Future[Any]) -> None:
        if job is self._job:
            self._waiting.stop()
            if not isinstance(job.exception(), StudioError):  # no answer if the law is too slow
                self.answered.emit(job.result())


def end_all(owner: QObject) -> None:
    """End the background work of an owner and of its children, so that no thread outlives them."""
    for job in owner.findChildren(Job):
        job.end()
    for answer in owner.findChildren(LatestResult):
        answer.end()

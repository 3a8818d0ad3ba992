"""Work off the window's thread: a long job with progress and cancel, and the newest question's answer."""

import threading
import time
import traceback
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.errors import StudioError
from hapkit_studio.gui.state import prepare

Progress = Callable[[int, int], None]
Work = Callable[[Progress], Any]

_SAY_SECONDS = 0.05
_LOOK_SECONDS = 0.05
LATE_MS = 100
"""An answer that takes longer is late: so long the one before may stand without anybody minding."""


class _Over(StudioError):
    """Ends work that was cancelled."""


class Job(QObject):
    """Does one piece of work at a time in a thread of its own; a new one replaces the old.

    work(progress) returns the result; progress(done, of) is to be called often, and ends the work once it is
    cancelled. needs is the part that must be compiled before, "" for none; ``preparing``: a program is still
    at it. must_finish: ``end`` waits without cancelling, as half a written file is useless.
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
        self._threads: list[threading.Thread] = []
        self._done.connect(self._deliver)

    @property
    def running(self) -> bool:
        """Return whether work is running and not cancelled."""
        return self._wanted is not None

    def start(self, work: Work) -> None:
        """Start work; cancel what is running."""
        token = self._wanted = object()
        thread = threading.Thread(target=self._work, args=(work, token), name="measuring", daemon=True)
        self._threads = [*(one for one in self._threads if one.is_alive()), thread]
        thread.start()
        self.running_changed.emit(True)

    def cancel(self) -> None:
        """Cancel: the work ends at its next call of progress."""
        if self._wanted is not None:
            self._wanted = None
            self.running_changed.emit(False)

    def wait(self) -> None:
        """Wait until the thread has ended, for tests and for closing."""
        while self._threads:
            self._threads.pop().join()

    def end(self) -> None:
        """Cancel, unless the work must finish, and wait for the thread."""
        if not self._must_finish:
            self.cancel()
        self.wait()

    def _work(self, work: Work, token: object) -> None:
        said = 0.0

        def progress(done: int, of: int) -> None:
            nonlocal said
            if self._wanted is not token:
                raise _Over("cancelled")
            now = time.monotonic()
            if done >= of or now - said > _SAY_SECONDS:
                said = now
                self.progressed.emit(done, of)

        try:
            self._prepare(token)
            self._done.emit(token, work(progress), "")
        except _Over:
            pass
        except StudioError as error:
            self._done.emit(token, None, str(error))
        except Exception as error:  # a defect: it is said, and the window goes on
            traceback.print_exc()
            self._done.emit(token, None, f"This went wrong: {error}")

    def _prepare(self, token: object) -> None:
        """Wait until what measuring needs is compiled: a compile in a thread would freeze the window."""
        program = prepare.begin(self._needs) if self._needs else None
        if program is None:
            return
        self.preparing.emit()
        while program.poll() is None:
            if self._wanted is not token:
                program.kill()
                program.wait()
                raise _Over("cancelled")
            time.sleep(_LOOK_SECONDS)

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
    """Answers the newest question in a thread and emits ``answered``; asking again replaces the question.

    ``late``: what was asked first since the last answer waits for too long, and what is shown holds no more.
    """

    answered = Signal(object)
    late = Signal()
    _done = Signal(object)

    def __init__(self, solve: Callable[[Any], Any], parent: QObject | None = None):
        super().__init__(parent)
        self._solve = solve
        self._newest: Any = None
        self._job: Future[Any] | None = None
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="answers")
        self._waiting = QTimer(self, interval=LATE_MS, singleShot=True)
        self._waiting.timeout.connect(self.late)
        self._done.connect(self._deliver)

    def ask(self, question: Any) -> None:
        """Ask, unless this very question was the last one."""
        if question == self._newest:
            return
        self._drop()
        self._newest = question
        if not self._waiting.isActive():
            self._waiting.start()
        self._job = self._worker.submit(self._solve, question)
        self._job.add_done_callback(self._done.emit)

    def forget(self) -> None:
        """Drop the question that is not answered yet."""
        self._waiting.stop()
        self._drop()

    def _drop(self) -> None:
        job, self._newest, self._job = self._job, None, None
        if job is not None:
            job.cancel()

    def wait(self) -> None:
        """Wait until everything asked is answered."""
        self._worker.submit(int).result()

    def end(self) -> None:
        """Drop the question that is not answered yet and end the thread."""
        self.forget()
        self._worker.shutdown(wait=True)

    def _deliver(self, job: Future[Any]) -> None:
        if job is self._job:
            self._waiting.stop()
            if not isinstance(job.exception(), StudioError):  # a law that is too slow has no answer
                self.answered.emit(job.result())


def end_all(owner: QObject) -> None:
    """End the background work of an owner and its children, so that no thread outlives them."""
    for job in owner.findChildren(Job):
        job.end()
    for answer in owner.findChildren(LatestResult):
        answer.end()

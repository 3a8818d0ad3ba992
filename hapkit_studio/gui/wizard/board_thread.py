"""The thread that owns the board for a dialog. It runs one job at a time and reads samples in between."""

import queue
import threading
import time
import traceback
from collections.abc import Callable
from concurrent.futures import Future, wait
from typing import Any

from PySide6.QtCore import QObject, QTimer, Signal

from hapkit_studio.devices.board_runner import BoardRunner
from hapkit_studio.errors import DeviceError, PortBusyError, StudioError
from hapkit_studio.worker import Worker

BUSY_SECONDS = 5.0
"""s: time-out for the application's own loop to release the port."""
JOIN_SECONDS = 5.0
_RETRY_SECONDS = 0.05
POLL_MS = 15
"""ms: interval at which the window checks for reports."""

Job = Callable[[Any], object]


class BoardThread(QObject):
    """Opens a board in a separate thread. ``run_job`` passes the result of ``prepare`` to a job.

    Signals are emitted in the window's thread. ``refused`` is emitted when a job ended without a result and
    the board is still connected, ``failed`` when the board is lost; then no job runs until ``start`` is
    called. ``progressed`` is emitted with the argument of ``report_progress`` in a job.
    """

    opened = Signal(object)
    done = Signal(object)
    refused = Signal(str)
    failed = Signal(str)
    progressed = Signal(object)

    def __init__(
        self, make_board: Callable[[], Any], prepare: Callable[[BoardRunner], Any], parent: QObject
    ) -> None:
        super().__init__(parent)
        self._make_board, self._prepare = make_board, prepare
        self.runner: BoardRunner | None = None
        self.subject: Any = None
        self.busy = True
        self._stopped = False
        self._job: Job | None = None
        self._after: Callable[[Any], object] | None = None
        self._quit = threading.Event()
        self._reports: queue.SimpleQueue[tuple[str, Any]] = queue.SimpleQueue()
        self._timer = QTimer(self, interval=POLL_MS)
        self._timer.timeout.connect(self._read_reports)
        self.destroyed.connect(self._quit.set)  # end the thread when its owner is destroyed
        self._worker = Worker("wizard")
        self._running: Future[None] | None = None  # the task of the thread while the board is open

    def start(self) -> None:
        """Open the board; after a failure, open it again without earlier state."""
        if self._running is not None:
            wait([self._running], JOIN_SECONDS)
        if self._quit.is_set():
            return
        if self._running is not None and not self._running.done():
            self._reports.put(
                ("failed", "The connection to the board is still being closed. Try again in a few seconds.")
            )
            return
        self.runner = self.subject = self._job = self._after = None
        self.busy = True
        self._running = self._worker.submit(self._run)
        self._timer.start()

    def run_job(self, job: Job, after: Callable[[Any], object]) -> bool:
        """Run a job, then call ``after(result)`` in the window's thread.

        Return False if another job runs or the board is not open.
        """
        if self.busy or self.runner is None:
            return False
        self.runner.begin_job()
        self.busy = True
        self._after = after
        self._job = job
        return True

    @property
    def job_running(self) -> bool:
        """Return True while a job runs."""
        return self._after is not None

    def cancel(self) -> None:
        """End the job at the next sample, and switch the motor off."""
        if self.runner is not None and self.job_running:
            self.runner.cancel()

    def stop(self) -> None:
        """Latch the E-stop at the next sample; this is also possible before the board is open."""
        self._stopped = True
        if self.runner is not None:
            self.runner.stop()

    def release(self) -> None:
        """Release the E-stop."""
        self._stopped = False
        if self.runner is not None:
            self.runner.release()

    @property
    def has_hand(self) -> bool:
        """Return True if the board has a simulated hand that the window can move (virtual board only)."""
        return self.runner is not None and bool(self.runner.board.simulated_hand)

    def move_hand(self, place: float | None) -> None:
        """Hold the virtual board's hand at a position in m; None releases the handle."""
        if self.runner is not None and self.has_hand:
            self.runner.board.move_hand(place)

    def end(self) -> None:
        """Switch the motor off, release the board, and wait for the thread; a second call does nothing."""
        self._quit.set()
        self._timer.stop()
        if self.runner is not None:
            self.runner.stop()
            self.runner.cancel()
        self._worker.shutdown(timeout=JOIN_SECONDS)

    # methods that run in the thread; they do not use Qt, because the window may be destroyed at any moment

    def _run(self) -> None:
        runner = None
        try:
            runner = self._open()
            self.subject = self._prepare(runner)
            self.runner = runner
            if self._stopped:
                runner.stop()
            self._reports.put(("opened", self.subject))
            while not self._quit.is_set():
                self._next_job(runner)
        except DeviceError as error:
            self._reports.put(("failed", str(error)))
        except Exception:
            traceback.print_exc()
            self._reports.put(("failed", "An error in the program ended this step. The force is zero."))
        finally:
            if runner is not None:
                runner.close()

    def _open(self) -> BoardRunner:
        """Wait until the loop has released the port, and return an open board.

        Raise DeviceError if the board cannot be opened.
        """
        deadline = time.monotonic() + BUSY_SECONDS
        while True:
            runner = BoardRunner(self._make_board())
            try:
                runner.open()
                return runner
            except PortBusyError:
                if time.monotonic() > deadline or self._quit.is_set():
                    raise
                time.sleep(_RETRY_SECONDS)

    def _next_job(self, runner: BoardRunner) -> None:
        """Keep the motor off until a job is requested, then run the job."""
        runner.idle(until=lambda: self._job is not None or self._quit.is_set())
        job, self._job = self._job, None
        if job is None:
            return
        try:
            self._reports.put(("done", job(self.subject)))
        except StudioError as error:
            self._reports.put(("refused", str(error)))
        except OSError as error:  # an error of a file; errors of the port are of type DeviceError
            self._reports.put(("refused", f"{error.strerror}: {error.filename}."))

    def report_progress(self, what: object) -> None:
        """Emit ``progressed`` in the window's thread; jobs call this."""
        self._reports.put(("progressed", what))

    # methods that run in the window's thread

    def _read_reports(self) -> None:
        while not self._reports.empty():
            kind, what = self._reports.get()
            if kind != "progressed":
                self.busy = kind == "failed"
                after, self._after = self._after, None
                if kind == "done" and after is not None:
                    after(what)
            getattr(self, kind).emit(what)

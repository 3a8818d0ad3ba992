"""A thread that runs jobs one after another. The loop and sweeps have other threads."""

import queue
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import Executor, Future
from contextlib import suppress
from functools import partial
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")
_Jobs = queue.SimpleQueue[tuple[Future, Callable[[], Any]] | None]


class Worker(Executor):
    """Runs jobs one after another in its own thread, from the first job until ``shutdown``.

    In contrast to ``ThreadPoolExecutor(1)``, a running job does not delay the end of the program.
    """

    def __init__(self, name: str):
        self._name = name
        self._lock = threading.Lock()
        self._jobs: _Jobs = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._newest: Future = Future()
        self._ended = False
        weakref.finalize(self, self._jobs.put, None)  # None ends the thread after its worker was freed

    def submit(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
        """Add a job, and return the future of its result."""
        job: Future[_T] = Future()
        with self._lock:
            if self._ended:
                raise RuntimeError(f"The worker {self._name} has been shut down.")
            if self._thread is None:
                self._thread = threading.Thread(target=_run, args=(self._jobs,), name=self._name, daemon=True)
                self._thread.start()
            self._jobs.put((job, partial(fn, *args, **kwargs)))
        return job

    def submit_newest(self, fn: Callable[_P, _T], /, *args: _P.args, **kwargs: _P.kwargs) -> Future[_T]:
        """Add a job, and cancel the one added by the previous call if it has not begun."""
        self._newest.cancel()
        self._newest = self.submit(fn, *args, **kwargs)
        return self._newest

    def wait(self) -> None:
        """Wait until the submitted jobs have ended."""
        if self._thread is not None:
            self.submit(int).result()

    def shutdown(
        self, wait: bool = True, *, cancel_futures: bool = False, timeout: float | None = None
    ) -> None:
        """End the thread after the submitted jobs.

        ``cancel_futures`` cancels the jobs that have not begun. ``wait`` waits until the thread has ended,
        for at most ``timeout`` s.
        """
        with self._lock:
            self._ended = True
            if cancel_futures:
                with suppress(queue.Empty):
                    while True:
                        item = self._jobs.get_nowait()
                        if item is not None:
                            item[0].cancel()
            self._jobs.put(None)
        if wait and self._thread is not None:
            self._thread.join(timeout)


def _run(jobs: _Jobs) -> None:
    """Run jobs until None arrives, without a reference to the worker, so that the worker can be freed."""
    while (item := jobs.get()) is not None:
        job, work = item
        if job.set_running_or_notify_cancel():
            try:
                result = work()
            except BaseException as error:
                job.set_exception(error)
            else:
                job.set_result(result)
                del result
        del item, job, work  # an idle thread must not keep results in memory

"""Sweeps: compute many independent cells on any ``concurrent.futures.Executor``, with progress.

Cells are submitted in chunks of about 0.1 s, so that progress and cancelling are prompt. Only a few chunks
are pending at a time, so the memory use of the executor does not depend on the length of the sweep.
"""

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait

from hapkit_studio.analysis.checks import whole_number
from hapkit_studio.errors import StudioError
from hapkit_studio.worker import Worker

Progress = Callable[[int, int], None]
Task = Callable[[list], list]
Keep = Callable[[Sequence, list], None]

# s: duration of a chunk; progress is reported at least every POLL_SECONDS
CHUNK_SECONDS = 0.1
POLL_SECONDS = 0.15
_GROWTH = 8
# Number of pending chunks per worker, so that no worker idles; number of workers that is assumed if the
# executor does not report it.
_AHEAD = 2
_UNKNOWN_WORKERS = 16
# how often a chunk is submitted again after one of the executor's ``lost`` exceptions
_MOST_LOSSES = 3


class LostWorkers(StudioError):
    """An executor gave up a part of the work."""

    def __init__(self) -> None:
        super().__init__("A part of the work was lost: a worker was killed, or its executor was shut down.")


def no_progress(done: int, of: int) -> None:
    """Do nothing."""


def workers(executor: Executor | None = None) -> int:
    """Return the number of chunks computed in parallel; without an executor, the number of cores."""
    if executor is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(int(getattr(executor, "_max_workers", _UNKNOWN_WORKERS)), 1)


def sweep(
    task: Task,
    cells: Sequence,
    *,
    executor: Executor | None = None,
    progress: Progress = no_progress,
    chunk: int | None = None,
    store: Keep | None = None,
) -> list:
    """Return the task's result of every cell, in the order of the cells.

    ``task`` is a module-level function from a list of cells to the list of their independent results. Cells
    and results must be picklable, because they may be sent to another machine. If ``executor`` is None,
    low-priority threads on all cores are used, which suits compiled tasks. ``progress`` is called in the
    calling thread. Its exceptions, and those of a task, are raised after pending chunks are cancelled.
    ``chunk`` is the number of cells per chunk, None for about 0.1 s. ``store`` receives each chunk's cells
    and results in the calling thread as they arrive; the returned list is then empty. Raise ParameterError
    for an invalid ``chunk``.
    """
    if chunk is not None:
        chunk = whole_number(chunk, "A chunk", 1)
    if executor is not None:
        return _swept(task, cells, executor, progress, chunk, store)
    count = min(workers(), max(len(cells), 1))
    with ThreadPoolExecutor(count, "hapkit-sweep", initializer=low_priority) as threads:
        return _swept(task, cells, threads, progress, chunk, store)


def timed(task: Task, cells: list) -> tuple[list, float]:
    """Return a chunk's results and its computing time in s."""
    begin = time.perf_counter()
    results = task(cells)
    return results, time.perf_counter() - begin


def _swept(
    task: Task, cells: Sequence, executor: Executor, progress: Progress, chunk: int | None, store: Keep | None
) -> list:
    """Submit a few chunks at a time, and collect results in order; submit lost chunks again."""
    results: list = [] if store else [None] * len(cells)
    under_way: dict[Future, tuple[int, int]] = {}
    losses: Counter[int] = Counter()
    size, sent, done = 1, 0, 0

    def submit(first: int, last: int) -> Future:
        future = executor.submit(timed, task, list(cells[first:last]))
        under_way[future] = first, last
        return future

    progress(0, len(cells))
    try:
        while done < len(cells):
            many = _AHEAD * workers(executor)
            while sent < len(cells) and len(under_way) < many:
                first = sent
                sent = min(first + (chunk or min(size, -(-(len(cells) - first) // many))), len(cells))
                if submit(first, sent).done():  # a synchronous executor is done already: collect at once
                    break
            for future in wait(under_way, POLL_SECONDS, FIRST_COMPLETED).done:
                first, last = under_way.pop(future)
                if future.cancelled():
                    raise LostWorkers
                if isinstance(future.exception(), getattr(executor, "lost", ())):
                    losses[first] += 1
                    if losses[first] <= _MOST_LOSSES:
                        submit(first, last)
                        continue
                found, seconds = future.result()
                if len(found) != last - first:
                    raise ValueError(f"The task gave {len(found)} results for {last - first} cells.")
                if store:
                    store(cells[first:last], found)
                else:
                    results[first:last] = found
                done += last - first
                growth = CHUNK_SECONDS / seconds if seconds > 0.0 else _GROWTH
                size = max(int((last - first) * min(growth, _GROWTH)), 1)
            progress(done, len(cells))
    except BaseException as error:
        for future in under_way:
            future.cancel()
        if isinstance(error, BrokenExecutor):  # either a future raised it, or submit() did
            raise LostWorkers from error
        raise
    return results


def begin_worker() -> None:
    """Initialise a worker process: ignore Ctrl+C, set a low priority, exit with the parent.

    A terminal sends Ctrl+C to every process, and the parent handles it. A killed parent cannot notify its
    workers, so each worker waits for the end of its parent in a thread.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    low_priority()
    Worker("parent").submit(_exit_with_parent)


def _exit_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


_NICEST = 19
# constants of sys/resource.h: the calling thread, and background priority
_DARWIN_THREAD, _DARWIN_BACKGROUND = 3, 0x1000
# constant of winbase.h: idle priority
_WINDOWS_IDLE = -15


def low_priority() -> None:
    """Give the calling thread the lowest priority, if the system supports it."""
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "linux":
            try:  # only for this thread: id 0 means the calling thread
                os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
            except OSError:
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICEST)
        elif sys.platform == "darwin":
            os.setpriority(_DARWIN_THREAD, 0, _DARWIN_BACKGROUND)
        elif sys.platform == "win32":
            kernel = ctypes.WinDLL("kernel32")
            kernel.GetCurrentThread.restype = ctypes.c_void_p
            kernel.SetThreadPriority.argtypes = [ctypes.c_void_p, ctypes.c_int]
            kernel.SetThreadPriority(kernel.GetCurrentThread(), _WINDOWS_IDLE)

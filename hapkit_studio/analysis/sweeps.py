"""Many independent cells, computed by any ``concurrent.futures.Executor``: in order, watched, cancellable.

Cells travel in chunks of about a tenth of a second, so that progress moves and a cancel is obeyed at once,
and only a few chunks are under way, so that a sweep of any length costs its executor nothing.
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

Progress = Callable[[int, int], None]
Task = Callable[[list], list]
Keep = Callable[[Sequence, list], None]

# A chunk takes about this long, and progress is told at least every LOOK.
CHUNK_SECONDS = 0.1
LOOK_SECONDS = 0.15
_GROWTH = 8
# Chunks under way for each worker, so that none waits for the next; and the workers of who does not say.
_AHEAD = 2
_UNKNOWN_WORKERS = 16
# How often a chunk is sent again after its executor has given it up with one of its ``lost`` exceptions.
_MOST_LOSSES = 3


class LostWorkers(StudioError):
    """An executor gave up a part of the work."""

    def __init__(self) -> None:
        super().__init__("A part of the work was given up: a worker was killed, or its executor shut down.")


class Cancelled(StudioError):
    """The work was cancelled; raised by a progress function, it comes out of what it watches."""


def no_progress(done: int, of: int) -> None:
    """No-op callback."""


def workers(executor: Executor | None = None) -> int:
    """Return how many chunks an executor computes at once; None: this machine's cores."""
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
    keep: Keep | None = None,
) -> list:
    """Return task's result of every cell, in the order of the cells.

    task: a module's function from a list of cells to the list of their results, each cell's its own; cells
    and results are numbers and names, for they may travel to another machine. executor: None for threads
    on every core below everything else, which pays where the task is compiled. progress is called in the
    calling thread; what it raises, and what a task raises, comes out once the waiting chunks are cancelled.
    chunk: how many cells travel together, None for what takes about 0.1 s. keep is given each chunk's cells
    and results as they come, in the calling thread; nothing is collected then. Raise ParameterError.
    """
    if chunk is not None:
        chunk = whole_number(chunk, "A chunk", 1)
    if executor is not None:
        return _swept(task, cells, executor, progress, chunk, keep)
    count = min(workers(), max(len(cells), 1))
    with ThreadPoolExecutor(count, "hapkit-sweep", initializer=low_priority) as threads:
        return _swept(task, cells, threads, progress, chunk, keep)


def timed(task: Task, cells: list) -> tuple[list, float]:
    """Return a chunk's results and the seconds they took, where they were computed."""
    begin = time.perf_counter()
    results = task(cells)
    return results, time.perf_counter() - begin


def _swept(
    task: Task, cells: Sequence, executor: Executor, progress: Progress, chunk: int | None, keep: Keep | None
) -> list:
    """Send chunks, few at a time, and put what comes back in its place; a lost chunk is sent again."""
    results: list = [] if keep else [None] * len(cells)
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
                if submit(first, sent).done():  # an executor that computes at once is collected from at once
                    break
            for future in wait(under_way, LOOK_SECONDS, FIRST_COMPLETED).done:
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
                if keep:
                    keep(cells[first:last], found)
                else:
                    results[first:last] = found
                done += last - first
                growth = CHUNK_SECONDS / seconds if seconds > 0.0 else _GROWTH
                size = max(int((last - first) * min(growth, _GROWTH)), 1)
            progress(done, len(cells))
    except BaseException as error:
        for future in under_way:
            future.cancel()
        if isinstance(error, BrokenExecutor):  # raised by a future, or already by submit()
            raise LostWorkers from error
        raise
    return results


def begin_worker() -> None:
    """Set up a worker process: it ignores Ctrl+C, has low priority, and ends with its parent.

    A terminal sends Ctrl+C to every process; the parent obeys it. A parent that is killed tells nobody.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    low_priority()
    threading.Thread(target=_exit_with_parent, name="parent", daemon=True).start()


def _exit_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


_NICEST = 19
# sys/resource.h: the calling thread, and the band that all other threads go before
_DARWIN_THREAD, _DARWIN_BACKGROUND = 3, 0x1000
# winbase.h
_WINDOWS_IDLE = -15


def low_priority() -> None:
    """Put the calling thread below everything else; where the system has no way to, it stays as it is."""
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "linux":
            try:  # for this thread alone: 0 is the calling thread here, not the program
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

"""Tasks for tests of sweeps, and executors that are synchronous, hold tasks back, or lose them."""

import math
import os
import sys
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

from hapkit_studio.analysis.sweeps import begin_worker


def roots(cells: list[float]) -> list[float]:
    return [math.sqrt(x) for x in cells]


def roots_and_place(cells: list[float]) -> list[tuple[float, int]]:
    """Return the square root of every cell, with the id of the process that computed it."""
    return [(math.sqrt(x), os.getpid()) for x in cells]


def busy_roots(cells: list[float]) -> list[float]:
    """Return the square roots; each takes about 0.1 ms, because of extra work."""
    return [math.sqrt(x + 0.0 * sum(math.sin(i) for i in range(1000))) for x in cells]


def fails_at_thirty(cells: list[float]) -> list[float]:
    if 30.0 in cells:
        raise KeyError("cell thirty")
    return cells


class Serial(Executor):
    """An executor that computes synchronously in the calling thread."""

    def __init__(self):
        self.chunks = 0

    def submit(self, fn, /, *args, **kwargs):
        self.chunks += 1
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class Held(Executor):
    """An executor that holds tasks until the test finishes them."""

    _max_workers = 3

    def __init__(self):
        self.given: list[tuple[Future, partial]] = []
        self.most = 0

    def submit(self, fn, /, *args, **kwargs):
        future: Future = Future()
        self.given.append((future, partial(fn, *args, **kwargs)))
        self.most = max(self.most, sum(not f.done() for f, _ in self.given))
        return future

    def finish(self, which: int) -> None:
        """Finish the pending task with this index, counted from the oldest."""
        waiting = [pair for pair in self.given if not pair[0].done()]
        if waiting:
            future, call = waiting[which % len(waiting)]
            future.set_result(call())


class Lost(Exception):
    """Raised for a chunk whose workers are gone."""


class Forgetful(Serial):
    """An executor that loses the first chunks, each of them ``times`` times."""

    lost = (Lost,)
    _max_workers = 1

    def __init__(self, times: int):
        super().__init__()
        self.times = times

    def submit(self, fn, /, *args, **kwargs):
        self.chunks += 1
        if self.chunks > self.times:
            return super().submit(fn, *args, **kwargs)
        future: Future = Future()
        future.set_exception(Lost("gone"))
        return future


def wait_for_a_minute() -> None:
    """Print this process's id, then wait for a minute."""
    print(os.getpid(), flush=True)
    threading.Event().wait(60.0)


def main() -> None:
    """Start two waiting worker processes, for a test that kills this process."""
    with ProcessPoolExecutor(2, get_context("spawn"), initializer=begin_worker) as programs:
        for future in [programs.submit(wait_for_a_minute) for _ in range(2)]:
            future.result()


if __name__ == "__main__":
    sys.exit(main())

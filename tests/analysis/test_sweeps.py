"""Sweeps give the same results in the same order with every executor; progress and cancelling work."""

import math
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from contextlib import suppress

import pytest

from hapkit_studio.analysis import sweeps
from hapkit_studio.analysis.sweeps import LostWorkers, sweep
from hapkit_studio.errors import Cancelled, ParameterError
from tests.analysis import sweep_tasks
from tests.analysis.sweep_tasks import Forgetful, Held, Lost, Serial


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    """Let sweeps report progress often, so that tasks finish as soon as they are released."""
    monkeypatch.setattr(sweeps, "POLL_SECONDS", 0.01)


CELLS = [0.5 * i for i in range(997)]
WANTED = [math.sqrt(x) for x in CELLS]


@pytest.mark.parametrize("chunk", [None, 1, 7, 5000])
def test_the_default_threads_give_every_result_in_order(chunk):
    assert sweep(sweep_tasks.roots, CELLS, chunk=chunk) == WANTED
    assert sweep(sweep_tasks.roots, []) == []


def test_processes_give_the_same_results():
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as programs:
        found = sweep(sweep_tasks.roots_and_place, CELLS, executor=programs, chunk=50)
    assert [root for root, _ in found] == WANTED
    assert os.getpid() not in {place for _, place in found}


def test_chunks_may_finish_in_any_order_and_few_are_pending():
    executor = Held()
    turns = iter(range(10_000))

    def go_on(done, of):
        executor.finish(next(turns) * 7)

    assert sweep(sweep_tasks.roots, CELLS, executor=executor, chunk=10, progress=go_on) == WANTED
    assert executor.most == 2 * executor._max_workers


def test_progress_is_reported_during_long_chunks():
    """The function that receives the progress can also cancel the sweep during a long chunk."""
    go, reports = threading.Event(), []

    def waits(cells):
        go.wait(30.0)
        return cells

    def watch(done, of):
        reports.append(done)
        if len(reports) == 4:
            go.set()

    assert sweep(waits, CELLS, progress=watch, chunk=len(CELLS)) == CELLS
    assert reports[:4] == [0, 0, 0, 0]


def test_cancelling_raises_and_cancels_pending_chunks():
    executor = Held()

    def watch(done, of):
        executor.finish(0)
        if done >= 40:
            raise Cancelled("Cancelled.")

    with pytest.raises(Cancelled):
        sweep(sweep_tasks.roots, CELLS, executor=executor, progress=watch, chunk=10)
    unfinished = [future for future, _ in executor.given if not future.done()]
    assert unfinished == []
    assert any(future.cancelled() for future, _ in executor.given)
    assert len(executor.given) < 20


@pytest.mark.parametrize("chunk", [None, 4])
def test_a_tasks_error_is_raised_unchanged(chunk):
    with pytest.raises(KeyError, match="cell thirty"):
        sweep(sweep_tasks.fails_at_thirty, CELLS, chunk=chunk)
    with pytest.raises(KeyError, match="cell thirty"):
        sweep(sweep_tasks.fails_at_thirty, CELLS, chunk=chunk, executor=Serial())


def test_a_lost_chunk_is_resubmitted_a_few_times():
    assert sweep(sweep_tasks.roots, CELLS, executor=Forgetful(3), chunk=5000) == WANTED
    with pytest.raises(Lost):
        sweep(sweep_tasks.roots, CELLS, executor=Forgetful(4), chunk=5000)


def test_invalid_chunks_and_incomplete_results_are_rejected():
    with pytest.raises(ParameterError, match="A chunk must be a whole number, 1 or more, not 0"):
        sweep(sweep_tasks.roots, CELLS, chunk=0)
    with pytest.raises(ValueError, match="gave 1 results for 10 cells"):
        sweep(lambda cells: cells[:1], CELLS, chunk=10)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux's scheduler")
def test_default_threads_have_low_priority():
    policies = sweep(lambda cells: [os.sched_getscheduler(0) for _ in cells], range(20), chunk=1)
    assert set(policies) == {os.SCHED_IDLE}


class Broken(Serial):
    """An executor that computes some chunks, then raises from submit(), like a pool with a killed worker."""

    def submit(self, fn, /, *args, **kwargs):
        self.left = getattr(self, "left", 3) - 1
        if self.left < 0:
            raise BrokenExecutor
        return super().submit(fn, *args, **kwargs)


def test_a_pool_that_breaks_at_submit_is_reported_as_lost_workers():
    with pytest.raises(LostWorkers, match=r"^A part of the work was lost: a worker was killed, or"):
        sweep(sweep_tasks.roots, CELLS, executor=Broken(), chunk=10)


@pytest.mark.skipif(sys.platform == "win32", reason="kills as POSIX does")
def test_workers_end_when_their_parent_is_killed():
    """Workers hold the parent's output open, so the output ends only when the last worker has exited."""
    program = [sys.executable, "-m", "tests.analysis.sweep_tasks"]
    with subprocess.Popen(program, stdout=subprocess.PIPE) as parent:
        numbers = {int(parent.stdout.readline()) for _ in range(2)}
        assert len(numbers - {parent.pid}) == 2
        parent.kill()
        try:
            assert parent.communicate(timeout=50.0)[0] == b""
        finally:
            for number in numbers:
                with suppress(ProcessLookupError):
                    os.kill(number, signal.SIGKILL)

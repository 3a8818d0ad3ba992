"""Sweeps: the same numbers in the same order whoever computes them; watched, cancelled, failed cleanly."""

import math
import multiprocessing
import os
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import pytest

from hapkit_studio.analysis import sweeps
from hapkit_studio.analysis.sweeps import Cancelled, sweep
from hapkit_studio.errors import ParameterError
from tests.analysis import sweep_tasks
from tests.analysis.sweep_executors import Forgetful, Held, Lost, Serial

CELLS = [0.5 * i for i in range(997)]
WANTED = [math.sqrt(x) for x in CELLS]


@pytest.mark.parametrize("chunk", [None, 1, 7, 5000])
def test_the_default_threads_give_every_result_in_order(chunk):
    assert sweep(sweep_tasks.roots, CELLS, chunk=chunk) == WANTED
    assert sweep(sweep_tasks.roots, []) == []


def test_any_executor_gives_the_same():
    assert sweep(sweep_tasks.roots, CELLS, executor=Serial()) == WANTED
    with ThreadPoolExecutor(3) as threads:
        assert sweep(sweep_tasks.roots, CELLS, executor=threads) == WANTED
        assert threads.submit(int, "4").result() == 4  # still its owner's


def test_processes_give_the_same():
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as programs:
        found = sweep(sweep_tasks.roots_and_place, CELLS, executor=programs, chunk=50)
    assert [root for root, _ in found] == WANTED
    assert os.getpid() not in {place for _, place in found}


def test_chunks_finished_in_any_order_land_in_their_place_and_few_are_under_way():
    executor = Held()
    turns = iter(range(10_000))

    def go_on(done, of):
        executor.finish(next(turns) * 7)

    assert sweep(sweep_tasks.roots, CELLS, executor=executor, chunk=10, progress=go_on) == WANTED
    assert executor.most == 2 * executor._max_workers


def test_progress_goes_from_none_to_all():
    said = []
    sweep(sweep_tasks.roots, CELLS, progress=lambda done, of: said.append((done, of)), chunk=100)
    assert said[0] == (0, len(CELLS))
    assert said[-1] == (len(CELLS), len(CELLS))
    assert said == sorted(said)


def test_progress_is_told_while_nothing_finishes():
    """A chunk that takes long: progress comes again and again, and may cancel."""
    go, said = threading.Event(), []

    def waits(cells):
        go.wait(30.0)
        return cells

    def watch(done, of):
        said.append(done)
        if len(said) == 4:
            go.set()

    assert sweep(waits, CELLS, progress=watch, chunk=len(CELLS)) == CELLS
    assert said[:4] == [0, 0, 0, 0]


def test_cancelled_comes_out_and_what_waits_is_cancelled():
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


def test_no_thread_is_at_work_after_a_cancel():
    def watch(done, of):
        if done:
            raise Cancelled("Cancelled.")

    with pytest.raises(Cancelled):
        sweep(sweep_tasks.busy_roots, CELLS, progress=watch, chunk=3)
    assert not [t for t in threading.enumerate() if t.name.startswith("hapkit-sweep")]


@pytest.mark.parametrize("chunk", [None, 4])
def test_a_task_s_error_comes_out_as_it_was(chunk):
    with pytest.raises(KeyError, match="cell thirty"):
        sweep(sweep_tasks.fails_at_thirty, CELLS, chunk=chunk)
    with pytest.raises(KeyError, match="cell thirty"):
        sweep(sweep_tasks.fails_at_thirty, CELLS, chunk=chunk, executor=Serial())


def test_a_lost_chunk_is_sent_again_but_not_for_ever():
    assert sweep(sweep_tasks.roots, CELLS, executor=Forgetful(3), chunk=5000) == WANTED
    with pytest.raises(Lost):
        sweep(sweep_tasks.roots, CELLS, executor=Forgetful(4), chunk=5000)


def test_chunks_grow_with_what_the_last_one_took():
    assert sweeps._next_size(1, 1e-3) == 8  # step by step
    assert sweeps._next_size(100, 0.05) == 200
    assert sweeps._next_size(100, 1.0) == 10
    assert sweeps._next_size(1, 60.0) == 1
    assert sweeps._next_size(4, 0.0) == 32


def test_refuses_what_is_no_chunk_and_a_task_that_loses_cells():
    with pytest.raises(ParameterError, match="A chunk takes a whole number, 1 or more, not 0"):
        sweep(sweep_tasks.roots, CELLS, chunk=0)
    with pytest.raises(ValueError, match="gave 1 results for 10 cells"):
        sweep(lambda cells: cells[:1], CELLS, chunk=10)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux's scheduler")
def test_a_low_thread_is_below_all_others_and_nobody_else_changes():
    found = []

    def ask():
        sweeps.low_priority()
        found.append(os.sched_getscheduler(0))

    thread = threading.Thread(target=ask)
    before = os.sched_getscheduler(0)
    thread.start()
    thread.join()
    assert found == [os.SCHED_IDLE]
    assert os.sched_getscheduler(0) == before


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux's scheduler")
def test_the_default_threads_are_low():
    policies = sweep(lambda cells: [os.sched_getscheduler(0) for _ in cells], range(20), chunk=1)
    assert set(policies) == {os.SCHED_IDLE}

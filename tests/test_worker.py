"""A worker runs jobs one after another, and never outlives its owner or the program."""

import subprocess
import sys
import threading
import weakref

import pytest

from hapkit_studio.worker import Worker

PATIENCE = 60.0


@pytest.fixture
def worker():
    with Worker("tested") as made:
        yield made


@pytest.fixture
def busy(worker):
    """Return a worker whose thread is inside a job, and the event that ends the job."""
    begun, may = threading.Event(), threading.Event()
    worker.submit(lambda: (begun.set(), may.wait(PATIENCE)))
    assert begun.wait(PATIENCE)
    yield worker, may
    may.set()


def threads():
    return [thread for thread in threading.enumerate() if thread.name == "tested"]


def test_jobs_run_in_their_order_in_one_thread(worker):
    assert not threads(), "a worker without a job has no thread"
    seen = [worker.submit(lambda k: (k, threading.get_ident()), k) for k in range(20)]
    found = [job.result(PATIENCE) for job in seen]
    assert [k for k, _ in found] == list(range(20))
    assert {ident for _, ident in found} == {threads()[0].ident}


def test_a_failing_job_does_not_end_the_thread(worker):
    with pytest.raises(ZeroDivisionError):
        worker.submit(lambda: 1 / 0).result(PATIENCE)
    assert worker.submit(int).result(PATIENCE) == 0


def test_only_the_newest_waiting_job_runs(busy):
    worker, may = busy
    seen = []
    jobs = [worker.submit_newest(seen.append, k) for k in range(5)]
    may.set()
    worker.wait()
    assert seen == [4]
    assert [job.cancelled() for job in jobs] == [True] * 4 + [False]


def test_shutdown_cancels_only_what_has_not_begun(busy):
    worker, may = busy
    waiting = worker.submit(int)
    worker.shutdown(cancel_futures=True, timeout=0.01)
    assert waiting.cancelled()
    assert threads(), "the running job continues after the time-out"
    may.set()
    worker.shutdown()
    assert not threads()
    with pytest.raises(RuntimeError, match="shut down"):
        worker.submit(int)


def test_the_thread_ends_with_its_worker_and_releases_results():
    class Result:
        pass

    worker = Worker("tested")
    result = worker.submit(Result).result(PATIENCE)
    worker.wait()
    gone, thread = weakref.ref(result), threads()[0]
    del result
    assert gone() is None
    del worker
    thread.join(PATIENCE)
    assert not thread.is_alive()


def test_the_program_ends_while_a_job_runs():
    program = (
        "import time\nfrom hapkit_studio.worker import Worker\nw = Worker('w')\nw.submit(time.sleep, 3600)\n"
    )
    subprocess.run([sys.executable, "-c", program], timeout=PATIENCE, check=True)

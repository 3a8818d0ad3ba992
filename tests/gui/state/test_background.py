"""Results from a worker thread: only the newest request is answered, and a late answer is announced."""

import threading
import time

import pytest
from PySide6.QtCore import QObject

from hapkit_studio.gui.state.background import Job, LatestResult, end_all


@pytest.fixture
def blocked(qtbot):
    """Return a worker that waits for an event and then echoes its request; the event; the emitted signals."""
    may = threading.Event()
    worker = LatestResult(lambda question: (may.wait(), question)[1])
    seen = []
    worker.answered.connect(seen.append)
    worker.late.connect(lambda: seen.append("late"))
    yield worker, may, seen
    may.set()
    worker.end()


def test_a_slow_answer_is_announced_as_late_once_even_after_a_second_request(blocked, qtbot):
    worker, may, seen = blocked
    worker.ask(1)
    waiting = worker._waiting
    left = waiting.remainingTime()
    worker.ask(2)
    assert waiting.isActive()
    assert waiting.remainingTime() <= left, "it waits since the first"
    waiting.timeout.emit()
    may.set()
    worker.wait()
    qtbot.waitUntil(lambda: 2 in seen)
    assert seen == ["late", 2]
    assert not waiting.isActive()


def test_a_cancelled_request_is_neither_late_nor_answered(blocked, qtbot):
    worker, may, seen = blocked
    worker.ask(1)
    worker.forget()
    assert not worker._waiting.isActive()
    may.set()
    worker.wait()
    qtbot.wait(0)
    assert seen == []


def test_an_outdated_answer_is_not_emitted(blocked, qtbot):
    """The first answer already exists and waits in the event queue when the second request is made."""
    worker, may, seen = blocked
    worker.ask(1)
    may.set()
    worker.wait()
    worker.ask(2)
    worker.wait()
    qtbot.waitUntil(lambda: 2 in seen)
    assert seen == [2]


def test_every_thread_ends_with_its_owner_but_uncancellable_jobs_finish(qtbot):
    before, written = set(threading.enumerate()), []
    owner, begun = QObject(), [threading.Event() for _ in range(2)]
    measuring, writing = Job(QObject(owner), needs=""), Job(owner, needs="", must_finish=True)
    answers = LatestResult(lambda question: question, QObject(owner))

    def measure(progress):
        begun[0].set()
        while True:
            progress(0, 1)
            time.sleep(0)

    def write(progress):
        begun[1].set()
        for done in range(1000):
            progress(done, 1000)
        written.append(True)

    measuring.start(measure)
    writing.start(write)
    answers.ask(1)
    assert all(one.wait(60.0) for one in begun)
    end_all(owner)
    assert set(threading.enumerate()) <= before
    assert written == [True]


def test_closing_the_window_ends_every_thread(make_window, qtbot):
    before = set(threading.enumerate())
    window = make_window()
    window.studio.device.open_simulated()
    qtbot.waitUntil(lambda: window.studio.engine is not None)
    window.studio.choose("wall")
    window.quiz.begin()
    assert window.quiz.side.job.running
    assert set(threading.enumerate()) > before
    window.close()
    assert set(threading.enumerate()) <= before

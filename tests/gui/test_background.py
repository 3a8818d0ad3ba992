"""The newest question's answer: which one counts, and when it is said to be late, without a clock."""

import threading

import pytest

from hapkit_studio.gui.background import LatestAnswer


@pytest.fixture
def held(qtbot):
    """Return a worker that answers with its question once it may, and what it emitted."""
    may = threading.Event()
    worker = LatestAnswer(lambda question: (may.wait(), question)[1])
    seen = []
    worker.answered.connect(seen.append)
    worker.late.connect(lambda: seen.append("late"))
    yield worker, may, seen
    may.set()
    worker.close()


def test_what_takes_long_is_late_once_though_it_is_asked_anew(held, qtbot):
    worker, may, seen = held
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


def test_what_is_forgotten_is_not_late_and_not_answered(held, qtbot):
    worker, may, seen = held
    worker.ask(1)
    worker.forget()
    assert not worker._waiting.isActive()
    may.set()
    worker.wait()
    qtbot.wait(0)
    assert seen == []


def test_an_answer_that_a_newer_question_overtook_is_not_shown(held, qtbot):
    """It was given already, and waited for the window's thread."""
    worker, may, seen = held
    worker.ask(1)
    may.set()
    worker.wait()
    worker.ask(2)
    worker.wait()
    qtbot.waitUntil(lambda: 2 in seen)
    assert seen == [2]

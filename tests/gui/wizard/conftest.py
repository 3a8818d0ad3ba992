"""Dialogs that have a kit to themselves; none leaves its thread behind."""

import threading

import pytest
import shiboken6

from hapkit_studio.gui.wizard.setup import SetupDialog
from tests.gui.wizard.support import Bench, Played


@pytest.fixture
def bench(qtbot):
    """Return what stands for the window below a dialog, with a studio of its own."""
    made = Bench()
    made.show()
    yield made
    made.closed.emit()
    made.studio.close()
    shiboken6.delete(made)


@pytest.fixture
def played(bench, qtbot):
    """Return a maker of open set-ups, each on a kit with its own truth; over the bench or a window."""
    return lambda window=bench, kind=SetupDialog, **truth: Played(kind, window, qtbot, **truth)


@pytest.fixture(autouse=True)
def no_thread_left():
    """Fail where a board's thread outlives the window that it belongs to."""
    yield
    left = [thread for thread in threading.enumerate() if thread.name == "wizard"]
    for thread in left:
        thread.join(10.0)
    assert not any(thread.is_alive() for thread in left), "a board's thread still streams"

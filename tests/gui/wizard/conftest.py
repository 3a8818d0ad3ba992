"""Fixtures for dialogs that control a kit. Each dialog's thread must end with the dialog."""

import threading

import pytest
import shiboken6

from hapkit_studio.gui.wizard.setup import SetupDialog
from tests.gui.wizard.support import Bench, Played


@pytest.fixture
def bench(qtbot):
    """Return a simple window with a studio, which replaces the main window as a dialog's parent."""
    made = Bench()
    made.show()
    yield made
    made.closed.emit()
    made.studio.close()
    shiboken6.delete(made)


@pytest.fixture
def played(bench, qtbot):
    """Return a function that opens a set-up on a simulated kit, over the bench or a window."""
    return lambda window=bench, kind=SetupDialog, **truth: Played(kind, window, qtbot, **truth)


@pytest.fixture(autouse=True)
def no_thread_left():
    """Fail if a board's thread outlives its window."""
    yield
    left = [thread for thread in threading.enumerate() if thread.name == "wizard"]
    for thread in left:
        thread.join(10.0)
    assert not any(thread.is_alive() for thread in left), "a board's thread still streams"

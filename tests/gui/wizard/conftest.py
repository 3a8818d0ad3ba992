"""Dialogs that have a kit to themselves; none leaves its thread behind."""

import threading

import pytest

from hapkit_studio.gui.wizard.check import CheckDialog
from hapkit_studio.gui.wizard.setup import SetupDialog
from tests.gui.wizard.support import Played


@pytest.fixture
def play_dialog(idle_window, qtbot):
    """Return a maker of open dialogs, each on a kit with its own truth."""
    return lambda kind, **truth: Played(kind, idle_window, qtbot, **truth)


@pytest.fixture
def played(play_dialog):
    """Return a maker of open set-ups."""
    return lambda **truth: play_dialog(SetupDialog, **truth)


@pytest.fixture
def checked(play_dialog):
    """Return a maker of open tests of a kit."""
    return lambda **truth: play_dialog(CheckDialog, **truth)


@pytest.fixture(autouse=True)
def no_thread_left():
    """Fail where a board's thread outlives the window that it belongs to."""
    yield
    left = [thread for thread in threading.enumerate() if thread.name == "wizard"]
    for thread in left:
        thread.join(10.0)
    assert not any(thread.is_alive() for thread in left), "a board's thread still streams"

"""Wizards to play, closed after the test."""

import contextlib

import pytest

from tests.gui.wizard_support import wizard


@pytest.fixture
def played(idle_window, qtbot):
    """Return a maker of open wizards, each on a kit with its own truth."""
    made = []

    def play(**truth):
        made.append(wizard(idle_window, qtbot, **truth))
        return made[-1]

    yield play
    for one in made:
        with contextlib.suppress(RuntimeError):  # it closed itself
            one.shell.close()

"""Fixtures for the page Break it, which is tested outside a window and with invented failures."""

import pytest

from hapkit_studio.analysis import failures
from hapkit_studio.gui.pages.break_it.page import BreakItPage
from hapkit_studio.gui.state import prepare
from hapkit_studio.gui.state.studio import Studio
from tests.gui.pages.break_it_support import Gate, library, measured


@pytest.fixture
def gate(monkeypatch):
    """Return the gate of the slow failure; the page has only invented failures, which are not compiled."""
    made = Gate()
    monkeypatch.setattr(failures, "failures", lambda: library(made))
    monkeypatch.setattr(prepare, "begin", lambda *_, **__: None)
    yield made
    made.go_on.set()


@pytest.fixture
def break_it_page(gate, qtbot):
    """Return the page outside a window, after its first failure was measured."""
    found = BreakItPage(Studio(list), None)
    qtbot.addWidget(found)
    found.resize(920, 430)
    found.show()
    found.set_shown(True)
    measured(found, qtbot)
    yield found
    gate.go_on.set()
    found.end()

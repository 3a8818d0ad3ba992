"""Windows on a scripted board that accepts laws and streams nothing, so tests do not depend on time."""

import pytest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.haptics import drivers
from tests.devices.fake_board import FakeKit
from tests.gui.window_support import PATIENCE_MS, SIMULATED


@pytest.fixture
def scripted(fake_board):
    return fake_board(FakeKit())


@pytest.fixture
def board_window(make_window, qtbot, monkeypatch, scripted):
    """Return a window on a scripted board that renders."""
    monkeypatch.setattr(drivers, "ZERO_FORCE_SECONDS", 0.0)
    entry = DeviceEntry("board", "Board", lambda: HapkitBoard(scripted.path))
    window = make_window((SIMULATED, entry))
    window.studio.device.open(entry)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    answered(window, qtbot)
    return window


def answered(window, qtbot):
    """Wait until the board's answer to the current law is known and shown."""
    qtbot.waitUntil(lambda: not window.studio.engine.decision().pending, timeout=PATIENCE_MS)
    window.studio.board_answer.poll()


@pytest.fixture
def held_board_window(board_window):
    """Return a window on a board with a simulated hand, so that both renderers can be compared."""
    board_window.studio.engine.device.simulated_hand = True
    board_window.loop.where.show_state()
    return board_window

"""Windows on a scripted board that renders by itself; nothing is streamed, so nothing depends on time."""

import pytest

from hapkit_studio.devices import DeviceEntry
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.haptics import drivers
from tests.devices.fake_board import FakeBoard
from tests.gui.window_support import PATIENCE_MS, SIMULATED
from tests.haptics.board_support import RendersItself


@pytest.fixture
def scripted():
    board = FakeBoard(RendersItself(changed=("friction",)))
    yield board
    board.unplug()


@pytest.fixture
def board_window(make_window, qtbot, monkeypatch, scripted):
    """Return a window on a scripted board that renders."""
    monkeypatch.setattr(drivers, "HOLD_SECONDS", 0.0)
    entry = DeviceEntry("board", "Board", lambda: HapkitBoard(scripted.path))
    window = make_window((SIMULATED, entry))
    window.studio.open(entry)
    qtbot.waitUntil(lambda: window.studio.engine is not None, timeout=PATIENCE_MS)
    return window


@pytest.fixture
def held_board_window(board_window):
    """Return a window on a board whose hand is the mouse, so that both ways can be compared."""
    board_window.studio.engine.device.hand = True
    board_window.loop.where.show_state()
    return board_window

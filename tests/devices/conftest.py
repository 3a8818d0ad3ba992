"""Fixtures of scripted boards."""

import pytest

from hapkit_studio.devices import hapkit, padding
from hapkit_studio.devices.hapkit import HapkitBoard
from tests.devices.fake_board import FakeLine


@pytest.fixture
def lined(monkeypatch):
    """Return a factory of fake serial lines; boards are opened on the newest line."""

    def make(answer):
        line = FakeLine(answer)
        monkeypatch.setattr(hapkit.serial, "Serial", line)
        for module in (hapkit, padding):
            monkeypatch.setattr(module, "time", line)
        return line

    return make


@pytest.fixture
def opened(lined):
    """Return a function that opens a board on a fake line, and returns both."""
    boards = []

    def make(answer):
        line = lined(answer)
        boards.append(HapkitBoard("/dev/ttyTEST"))
        boards[-1].open()
        return boards[-1], line

    yield make
    for board in boards:
        board.close()

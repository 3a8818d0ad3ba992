"""Boards that a test scripts."""

import pytest

from hapkit_studio.devices.hapkit import HapkitBoard
from tests.devices.fake_board import FakeBoard


@pytest.fixture
def opened():
    """Return a maker of open boards, each with the scripted one behind it."""
    pairs = []

    def make(answer):
        peer = FakeBoard(answer)
        board = HapkitBoard(peer.path)
        pairs.append((board, peer))
        board.open()
        return board, peer

    yield make
    for board, peer in pairs:
        board.close()
        peer.unplug()

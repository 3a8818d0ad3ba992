"""Boards that a test scripts."""

import pytest

from hapkit_studio.devices.hapkit import HapkitBoard


@pytest.fixture
def opened(fake_board):
    """Return a maker of open boards, each with the scripted one behind it."""
    boards = []

    def make(answer):
        peer = fake_board(answer)
        boards.append(HapkitBoard(peer.path))
        boards[-1].open()
        return boards[-1], peer

    yield make
    for board in boards:
        board.close()

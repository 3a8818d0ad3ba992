"""Flashing uses the real avrdude and boot loaders in the virtual board, including boards that fail."""

from contextlib import ExitStack

import pytest

from hapkit_studio.devices.avrdude import WRITING
from hapkit_studio.devices.flash import flash
from hapkit_studio.errors import FlashError
from tests.firmware import boot
from tests.firmware.vb import Host

pytestmark = [boot.needs_avrdude, pytest.mark.slow]


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a board with a boot loader and an idle program."""
    with ExitStack() as ended:

        def begin(boot_loader):
            board = boot.Board(tmp_path, boot_loader)
            ended.callback(board.end)
            return board

        yield begin


def test_the_boot_loader_of_older_boards_is_reached_at_its_own_speed(start, tmp_path):
    board = start(boot.OLD)
    assert flash(board.port, boot.small_image(tmp_path), speeds=(57600,)).speed == 57600
    host = Host(board.port)
    host.read(20)
    host.close()


def test_verification_errors_state_the_address(start, tmp_path):
    board = start(boot.that_writes_nothing(tmp_path))
    with pytest.raises(
        FlashError,
        match=r"verification of the written firmware failed: 0x\w+ instead of 0x\w+ at 0x\w+\. Flash again",
    ):
        flash(board.port, boot.small_image(tmp_path))


def test_after_unplugging_during_flashing_the_board_can_be_flashed_again(start, tmp_path):
    board = start(boot.optiboot(tmp_path))

    def pull(stage, part):
        if stage == WRITING and 0.3 < part < 0.6:
            board.send("unplug")

    with pytest.raises(FlashError, match="was disconnected before the firmware was complete"):
        flash(board.port, progress=pull)
    board.plug()
    assert flash(board.port, boot.small_image(tmp_path)).speed == 115200
    host = Host(board.port)
    host.read(20)
    host.close()

"""Flashing with the real avrdude, the real boot loaders in the virtual board, and boards that fail."""

import pytest

from hapkit_studio.devices import flash as flashing
from hapkit_studio.devices.flash import flash, greet, shipped
from hapkit_studio.devices.flash_output import CONNECTING, VERIFYING, WRITING
from hapkit_studio.errors import FlashError
from tests.firmware import boot
from tests.firmware.vb import Host

pytestmark = boot.needs_avrdude


@pytest.fixture
def start(tmp_path):
    """Return a function that starts a board with a boot loader and an idle program."""
    started = []

    def begin(boot_loader):
        started.append(boot.Board(tmp_path, boot_loader))
        return started[-1]

    yield begin
    for board in started:
        board.end()


def test_the_shipped_firmware_is_written_verified_and_says_hello(start, tmp_path):
    board, seen = start(boot.optiboot(tmp_path)), []
    done = flash(board.port, progress=lambda stage, part: seen.append((stage, part)))
    assert done.speed == 115200
    assert done.size == len(flashing.hex_image.read(shipped()).data)
    assert seen[0] == (CONNECTING, 0.0)
    assert {(WRITING, 1.0), (VERIFYING, 1.0)} <= set(seen)
    order = [(CONNECTING, WRITING, VERIFYING).index(stage) + part for stage, part in seen]
    assert order == sorted(order)
    assert len(seen) > 40  # a bar that moves
    hello = greet(board.port)
    assert hello.build.encode() in shipped_bytes()


def shipped_bytes():
    return flashing.hex_image.read(shipped()).data


def test_the_boot_loader_of_older_boards_is_reached_at_its_own_speed(start, tmp_path):
    board = start(boot.OLD)
    assert flash(board.port, boot.small_image(tmp_path), speeds=(57600,)).speed == 57600
    host = Host(board.port)
    host.read(20)
    host.close()


def test_a_chip_with_another_signature_is_not_written_to(start, tmp_path):
    board = start(boot.of_another_chip(tmp_path))
    with pytest.raises(FlashError, match=r"another chip \(signature 1e940f\).*ATmega328P"):
        flash(board.port, boot.small_image(tmp_path))


def test_what_reads_back_differently_is_said_with_its_place(start, tmp_path):
    board = start(boot.that_writes_nothing(tmp_path))
    with pytest.raises(
        FlashError, match=r"reads back differently: 0x\w+ instead of 0x\w+ at 0x\w+\. Flash again"
    ):
        flash(board.port, boot.small_image(tmp_path))


def test_a_cable_pulled_in_the_middle_leaves_a_board_that_can_be_flashed_again(start, tmp_path):
    board = start(boot.optiboot(tmp_path))

    def pull(stage, part):
        if stage == WRITING and 0.3 < part < 0.6:
            board.send("unplug")

    with pytest.raises(FlashError, match="went away before the firmware was whole"):
        flash(board.port, progress=pull)
    board.plug()
    assert flash(board.port, boot.small_image(tmp_path)).size > 100
    host = Host(board.port)
    host.read(20)
    host.close()

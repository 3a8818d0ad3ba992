"""Flashing with the real avrdude, the real boot loaders in the virtual board, and boards that fail."""

from dataclasses import replace

import pytest

from hapkit_studio.devices import profiles, virtual_board
from hapkit_studio.devices.avrdude import CONNECTING, VERIFYING, WRITING
from hapkit_studio.devices.flash import flash, read_image, shipped
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.errors import FlashError
from hapkit_studio.protocol.messages import Origin
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


SOON = 1_000_000
"""bit/s of a boot loader that takes a whole firmware in little time."""


def newest():
    """Return the image that was built beside the virtual board, else the one that ships."""
    beside = virtual_board.program().with_name("hapkit.hex")
    return beside if beside.is_file() else shipped()


@pytest.mark.slow
def test_a_firmware_is_written_verified_and_says_hello_and_the_kits_settings_stay(tmp_path):
    board, seen, image = boot.Board(tmp_path, boot.optiboot(tmp_path, SOON), newest()), [], newest()
    try:
        label = saved_label(board.port)
        done = flash(board.port, image, None, lambda stage, part: seen.append((stage, part)), (SOON,))
        kit = HapkitBoard(board.port)
        kit.open()
        settings, build = kit.settings(), kit.hello.build
        kit.close()
    finally:
        board.end()
    assert (settings.label, settings.origin) == (label, Origin.STORED)
    assert done.size == len(read_image(image))
    assert build.encode() in read_image(image)
    assert seen[0] == (CONNECTING, 0.0)
    assert {(WRITING, 1.0), (VERIFYING, 1.0)} <= set(seen)
    order = [(CONNECTING, WRITING, VERIFYING).index(stage) + part for stage, part in seen]
    assert order == sorted(order)
    assert len(set(seen)) > 40  # a bar that moves


def saved_label(port):
    """Keep settings of its own on the board; return their label."""
    kit = HapkitBoard(port)
    kit.open()
    kit.configure(replace(profiles.of_settings(kit.settings()), label="Mine"))
    assert kit.save().origin == Origin.STORED
    kit.close()
    return "Mine"


@pytest.mark.slow
def test_the_boot_loader_of_older_boards_is_reached_at_its_own_speed(start, tmp_path):
    board = start(boot.OLD)
    assert flash(board.port, boot.small_image(tmp_path), speeds=(57600,)).speed == 57600
    host = Host(board.port)
    host.read(20)
    host.close()


def test_what_reads_back_differently_is_said_with_its_place(start, tmp_path):
    board = start(boot.that_writes_nothing(tmp_path))
    with pytest.raises(
        FlashError, match=r"reads back differently: 0x\w+ instead of 0x\w+ at 0x\w+\. Flash again"
    ):
        flash(board.port, boot.small_image(tmp_path))


@pytest.mark.slow
def test_a_cable_pulled_in_the_middle_leaves_a_board_that_can_be_flashed_again(start, tmp_path):
    board = start(boot.optiboot(tmp_path))

    def pull(stage, part):
        if stage == WRITING and 0.3 < part < 0.6:
            board.send("unplug")

    with pytest.raises(FlashError, match="went away before the firmware was whole"):
        flash(board.port, newest(), progress=pull)
    board.plug()
    assert flash(board.port, boot.small_image(tmp_path)).speed == 115200
    host = Host(board.port)
    host.read(20)
    host.close()

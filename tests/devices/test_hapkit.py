"""The serial Hapkit against a scripted board on a pseudo-terminal."""

import fcntl
import math
import os
import struct
import sys
from dataclasses import replace

import pytest

from hapkit_studio import errors
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.protocol.framing import encode, frame
from hapkit_studio.protocol.messages import Force, Hello, HelloRequest, Release, Stream
from tests.devices.fake_board import HELLO_FIELDS, UNPLUG, FakeBoard

HELLO = Hello(**HELLO_FIELDS)
SHORT = 0.3


def says_hello(message, hello=HELLO):
    return encode(hello) if isinstance(message, HelloRequest) else None


@pytest.fixture
def fake():
    """Return a maker of scripted boards that are unplugged in the end."""
    boards = []

    def make(answer=says_hello):
        boards.append(FakeBoard(answer))
        return boards[-1]

    yield make
    for board in boards:
        board.unplug()


def failure(kind, path, handshake_time=SHORT):
    board = HapkitBoard(path)
    with pytest.raises(kind) as caught:
        board.open(handshake_time)
    with pytest.raises(errors.DeviceError):
        board.fileno()
    return str(caught.value)


def short(path):
    return path.removeprefix("/dev/")


def test_every_constant_comes_from_the_board(fake):
    board = HapkitBoard(fake().path)
    board.open()
    assert board.hello.counts_per_flip == 921
    assert board.hello.build == "test"
    assert board.max_force == 2.5
    assert board.quantum == pytest.approx(2e-5, rel=1e-7)
    assert board.rate == 1000.0
    # torque 0.0183 N·m at the motor, times the gear 74/5, over the handle's 90 mm
    assert board.full_force == pytest.approx(0.0183 * 74 / 5 / 0.090, rel=1e-6)
    assert not board.simulated
    assert board.title == f"Hapkit on {short(board.port)}"
    board.close()


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        *(("max_force", value, "force limit of the board") for value in (math.inf, math.nan, -1.0, 5.05)),
        *(("quantum", value, "handle travel per sensor count") for value in (0.0, 9.9e-8, 2.02e-3)),
        ("pulley_radius", 0.0, "motor pulley"),
        ("pwm_top", 0, "pwm value of full duty"),
        ("sample_rate", 0, "samples per second"),
    ],
)
def test_numbers_that_no_hapkit_has_are_refused(fake, name, value, said):
    words = failure(
        errors.NotAHapkitError, fake(lambda m: says_hello(m, replace(HELLO, **{name: value}))).path
    )
    assert said in words
    assert f"{value:g}" in words
    assert "Flash the firmware." in words


@pytest.mark.parametrize(
    ("name", "value"), [("max_force", 5.0), ("quantum", 1e-7), ("quantum", 2e-3), ("handle_radius", 0.3)]
)
def test_numbers_at_the_limit_are_taken(fake, name, value):
    board = HapkitBoard(fake(lambda m: says_hello(m, replace(HELLO, **{name: value}))).path)
    board.open()
    assert getattr(board.hello, name) == pytest.approx(value, rel=1e-6)
    board.close()


def test_open_leaves_the_motor_free_and_the_samples_off(fake):
    peer = fake()
    board = HapkitBoard(peer.path)
    board.open()
    assert peer.wait_for(3) == [HelloRequest(), Stream(0, 0), Release()]
    board.start_stream()
    assert peer.wait_for(4)[3:] == [Stream(1, 0)]
    board.close()
    assert peer.wait_for(6)[4:] == [Force(0, 0, 0.0), Stream(0, 0)]
    board.close()
    with pytest.raises(errors.DeviceError):
        _ = board.hello


def test_asks_again_while_the_board_starts(fake):
    asked = []

    def slow(message):
        asked.append(message)
        return encode(HELLO) if len(asked) >= 3 else b"bootloader\x00"

    board = HapkitBoard(fake(slow).path)
    board.open()
    assert asked[:3] == [HelloRequest()] * 3
    board.close()


def test_hello_after_half_a_frame_and_noise(fake):
    peer = fake(lambda m: encode(HELLO)[7:] + b"\xff\x00\x13\x00" + encode(HELLO))
    board = HapkitBoard(peer.path)
    board.open()
    assert board.hello.watchdog_ms == 25
    board.close()


def test_nothing_answers(fake):
    path = fake(lambda m: None).path
    expected = f"{short(path)} does not answer. Flash the firmware, or choose another port."
    assert failure(errors.NotAHapkitError, path) == expected


@pytest.mark.parametrize(
    "noise", [b"x=0.0123,F=0.5\r\n", b"\x00\x00", frame(b"\x81"), frame(b"\x81\x03\x00abc")]
)
def test_something_else_answers(fake, noise):
    path = fake(lambda m: noise).path
    expected = f"{short(path)} answers, but not as a Hapkit. Flash the firmware, or choose another port."
    assert failure(errors.NotAHapkitError, path) == expected


@pytest.mark.parametrize(
    ("version", "remedy"), [(2, "Update firmware."), (4, "Update the studio.")], ids=["older", "newer"]
)
@pytest.mark.parametrize("rest", [b"", b"another layout altogether"])
def test_another_version_of_the_protocol(fake, version, remedy, rest):
    other = frame(bytes([Hello.ID]) + version.to_bytes(2, "little") + rest)
    path = fake(lambda m: other).path
    expected = f"Firmware speaks version {version}; this studio needs 3. {remedy}"
    assert failure(errors.WrongProtocolError, path) == expected


def test_port_in_use(fake):
    first = HapkitBoard(fake().path)
    first.open()
    expected = f"{short(first.port)} is used by another program. Close it, then try again."
    assert failure(errors.PortBusyError, first.port) == expected
    first.start_stream()  # the first one is none the worse for it
    first.close()


def test_port_missing():
    with pytest.raises(errors.PortGoneError) as caught:
        HapkitBoard("/dev/ttyNONE7").open()
    expected = "ttyNONE7 is not there. Plug the board in, or see `hapkit-studio devices`."
    assert str(caught.value) == expected
    assert "Looking again every second" in caught.value.brief  # what a window does, and a command does not


def test_not_a_serial_port_at_all(tmp_path):
    file = tmp_path / "notes.txt"
    file.touch()
    assert failure(errors.NotAHapkitError, file) == f"{file} is not a serial port. Choose another port."


def test_unplugged_during_the_handshake(fake):
    path = fake(lambda m: UNPLUG).path
    expected = f"Hapkit on {short(path)} is gone. Force is zero. Plug it in, then try again."
    assert failure(errors.PortGoneError, path, handshake_time=5.0) == expected


def test_unplugged_while_open(fake):
    peer = fake()
    board = HapkitBoard(peer.path)
    board.open()
    peer.unplug()
    with pytest.raises(errors.PortGoneError):
        board.start_stream()
    board.close()


@pytest.mark.skipif(sys.platform != "linux", reason="Linux tells who may open a port")
def test_others_are_kept_off_while_it_is_open(fake):
    def claimed():
        answer = fcntl.ioctl(line, 0x80045440, struct.pack("i", 0))  # TIOCGEXCL
        return struct.unpack("i", answer)[0] != 0

    peer = fake()
    line = os.open(peer.path, os.O_RDWR | os.O_NOCTTY)
    board = HapkitBoard(peer.path)
    assert not claimed()
    board.open()
    assert claimed()
    board.close()
    assert not claimed()
    os.close(line)

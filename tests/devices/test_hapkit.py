"""The serial Hapkit with a scripted board on a pseudo-terminal: opening, requests, samples, closing."""

import itertools
import math
import os
import struct
import sys
from dataclasses import replace

import pytest

from hapkit_studio import errors
from hapkit_studio.devices.hapkit import HANDSHAKE_TIME, PACKET, READ_TIME, HapkitBoard
from hapkit_studio.protocol.framing import encode, frame
from hapkit_studio.protocol.messages import (
    Board,
    Force,
    Hello,
    HelloRequest,
    Origin,
    Release,
    Save,
    Settings,
    SettingsRequest,
    Stream,
)
from tests.devices.fake_board import HELLO_FIELDS, KIT, UNPLUG, FakeKit, sample

fcntl = pytest.importorskip("fcntl")
HELLO = Hello(**HELLO_FIELDS)


def says_hello(message, hello=HELLO):
    return encode(hello) if isinstance(message, HelloRequest) else None


def near(got, want):
    """Compare field by field, with floats in single precision."""
    for f in Board.layout():
        a, b = getattr(got, f.name), getattr(want, f.name)
        assert a == (pytest.approx(b, rel=1e-6) if f.code == "f" else b), f.name
    return True


def refused(kind, message, path="/dev/ttyTEST"):
    board = HapkitBoard(path)
    with pytest.raises(kind) as caught:
        board.open()
    with pytest.raises(errors.DeviceError):
        board.fileno()
    name = str(path).removeprefix("/dev/")
    assert message.format(name) in str(caught.value)
    return caught.value


# --- opening and closing
def test_every_constant_comes_from_the_board(opened):
    board, _ = opened(says_hello)
    assert board.hello.counts_per_flip == 921
    assert board.hello.build == "test"
    assert (board.max_force, board.rate, board.motor) == (2.5, 1000.0, True)
    assert board.quantum == pytest.approx(2e-5, rel=1e-7)
    # motor torque 0.0183 N·m, gear 74/5, handle radius 90 mm
    assert board.full_force == pytest.approx(0.0183 * 74 / 5 / 0.090, rel=1e-6)
    assert board.title == f"Hapkit on {board.port.removeprefix('/dev/')}"


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        *(("max_force", value, "force limit of the board") for value in (math.inf, math.nan, -1.0, 5.05)),
        *(("quantum", value, "handle travel per sensor count") for value in (0.0, 9.9e-8, 2.02e-3)),
        ("pulley_radius", 0.0, "motor pulley"),
        ("pwm_top", 0, "pwm value of full duty"),
        ("sample_rate", 0, "samples per second"),
    ],
)
def test_impossible_numbers_are_rejected(lined, name, value, text):
    lined(lambda m: says_hello(m, replace(HELLO, **{name: value})))
    error = refused(errors.NotAHapkitError, f"{value:g}")
    assert text in str(error)
    assert "Flash the firmware." in str(error)


@pytest.mark.parametrize(
    ("name", "value"), [("max_force", 5.0), ("quantum", 1e-7), ("quantum", 2e-3), ("handle_radius", 0.3)]
)
def test_numbers_at_the_limits_are_accepted(opened, name, value):
    board, _ = opened(lambda m: says_hello(m, replace(HELLO, **{name: value})))
    assert getattr(board.hello, name) == pytest.approx(value, rel=1e-6)


def test_open_and_close_leave_the_motor_free_and_the_samples_off(opened):
    board, peer = opened(says_hello)
    assert peer.received == [HelloRequest(), Stream(0, 0), Release()]
    board.start_stream()
    board.start_stream(padded=PACKET)
    board.padding = PACKET
    board.start_stream()
    assert peer.received[3:] == [Stream(1, 0), Stream(1, 62), Stream(1, 62)]
    board.close()
    assert peer.received[6:] == [Force(0, 0, 0.0), Stream(0, 0)]
    board.close()
    with pytest.raises(errors.DeviceError):
        _ = board.hello


def test_hello_is_repeated_during_start_despite_noise(opened):
    asked = []

    def slow(message):
        asked.append(message)
        noise = encode(HELLO)[7:] + b"\xff\x00\x13\x00"
        return noise + encode(HELLO) if len(asked) >= 3 else b"bootloader\x00"

    board, _ = opened(slow)
    assert asked[:3] == [HelloRequest()] * 3
    assert board.hello.watchdog_ms == 25


@pytest.mark.parametrize(
    "noise", [None, b"x=0.0123,F=0.5\r\n", b"\x00\x00", frame(b"\x81"), frame(b"\x81\x04\x00abc")]
)
def test_other_devices_and_silence_are_reported(lined, noise):
    what = "answers, but is not a Hapkit" if noise else "does not answer"
    line = lined(lambda m: noise)
    refused(errors.NotAHapkitError, f"{{}} {what}. Flash the firmware, or choose another port.")
    assert line.now <= HANDSHAKE_TIME + READ_TIME


@pytest.mark.parametrize(
    ("version", "remedy", "step"), [(3, "Update the firmware.", "update"), (5, "Update Hapkit Studio.", "")]
)
@pytest.mark.parametrize("rest", [b"", b"another layout altogether"])
def test_a_different_protocol_version_is_reported(lined, version, remedy, step, rest):
    other = frame(bytes([Hello.ID]) + version.to_bytes(2, "little") + rest)
    lined(lambda m: other)
    message = f"The firmware has protocol version {version}, but this studio needs version 4. {remedy}"
    assert refused(errors.WrongProtocolError, message).step == step


def test_busy_missing_and_invalid_ports_are_reported(fake_board, tmp_path):
    first = HapkitBoard(fake_board(says_hello).path)
    first.open()
    refused(errors.PortBusyError, "{} is used by another program. Close it, then try again.", first.port)
    first.start_stream()  # the first board is unaffected
    first.close()
    message = "ttyNONE7 does not exist. Plug the board in, or see `hapkit-studio devices`."
    error = refused(errors.PortGoneError, message, "/dev/ttyNONE7")
    assert "Trying to reconnect every second" in error.brief  # the window reconnects, but a command does not
    file = tmp_path / "notes.txt"
    file.touch()
    refused(errors.NotAHapkitError, "{} is not a serial port. Choose another port.", file)


def test_unplugging_is_reported_during_handshake_and_request_and_while_open(fake_board):
    message = "Hapkit on {} is disconnected. Force is zero. Plug the board in, then try again."
    refused(errors.PortGoneError, message, fake_board(lambda m: UNPLUG).path)
    kit = FakeKit()
    board = HapkitBoard(fake_board(lambda m: UNPLUG if isinstance(m, SettingsRequest) else kit(m)).path)
    board.open()
    with pytest.raises(errors.PortGoneError):
        board.settings()
    board.close()
    peer = fake_board(says_hello)
    board = HapkitBoard(peer.path)
    board.open()
    peer.unplug()
    with pytest.raises(errors.PortGoneError):
        board.start_stream()
    board.close()


@pytest.mark.skipif(sys.platform != "linux", reason="Linux tells who may open a port")
def test_an_open_port_is_exclusive(fake_board):
    def claimed():
        answer = fcntl.ioctl(line, 0x80045440, struct.pack("i", 0))  # the request is TIOCGEXCL
        return struct.unpack("i", answer)[0] != 0

    peer = fake_board(says_hello)
    line = os.open(peer.path, os.O_RDWR | os.O_NOCTTY)
    board = HapkitBoard(peer.path)
    assert not claimed()
    board.open()
    assert claimed()
    board.close()
    assert not claimed()
    os.close(line)


# --- requests
def test_configure_applies_at_once_without_saving(opened):
    kit = FakeKit()
    board, peer = opened(kit)
    assert (board.mass, board.viscous, board.coulomb_force) == (0.044, 0.5, 0.10)
    assert near(board.settings(), KIT)
    assert near(board.configure(board.settings()), KIT)  # the settings that a board returns can be sent back
    wanted = replace(KIT, quantum=1.5e-5, max_force=1.25, mass=0.031, viscous=0.25, label="mine")
    settings = board.configure(wanted)
    assert near(settings, wanted)
    assert settings.origin == Origin.UNSAVED
    assert kit.stored is None
    assert board.max_force == 1.25  # the computer uses the board's new constants
    assert (board.quantum, board.mass, board.viscous) == pytest.approx((1.5e-5, 0.031, 0.25), rel=1e-6)
    assert board.save().origin == Origin.STORED
    assert near(kit.stored, wanted)
    assert any(isinstance(m, Save) for m in peer.received)


def test_rejected_settings_change_nothing(opened):
    board, _ = opened(FakeKit())
    with pytest.raises(errors.ParameterError, match=r"refused these settings.*Nothing was changed") as error:
        board.configure(replace(KIT, max_force=1000.0))
    assert "\n" not in str(error.value)
    assert board.max_force == 2.5
    assert near(board.settings(), KIT)


def test_a_lost_request_is_repeated_and_a_late_reply_discarded(opened):
    asked, kit = [], FakeKit()

    def slow(message):
        if isinstance(message, SettingsRequest):
            asked.append(message)
            # the first reply arrives together with the second
            return kit(message) * 2 if len(asked) == 2 else None
        return kit(message)

    board, _ = opened(slow)
    assert near(board.request(SettingsRequest(), Settings, seconds=2.0), KIT)
    assert len(asked) == 2
    changed = replace(KIT, mass=0.05)
    assert near(board.configure(changed), changed)


def test_a_running_stream_does_not_delay_a_reply(opened):
    """On a line that is never silent, a read takes one sample period."""
    asked, kit = [], FakeKit()

    def answer(message):
        asked.append(message)
        return kit(message) if len(asked) == 2 or isinstance(message, HelloRequest) else None

    board, line = opened(answer)
    asked.clear()

    def stream(size):
        line.now += 1e-3
        data, line._data = line._data, b""
        return encode(sample(1)) + data

    line.read = stream
    assert near(board.request(SettingsRequest(), Settings, 0.2), KIT)


def test_a_missing_reply_has_its_own_message(opened):
    board, _ = opened(FakeKit(deaf={SettingsRequest: 2}))
    with pytest.raises(errors.NoDataError, match=r"did not answer when asked for its settings within 0\.2 s"):
        board.request(SettingsRequest(), Settings, seconds=0.2)


def test_samples_are_yielded_until_silence(opened):
    board, _ = opened(FakeKit(burst=20))
    board.start_stream()
    assert list(itertools.islice(board.samples(), 20)) == [sample(k, count=k) for k in range(20)]
    with pytest.raises(errors.NoDataError, match=r"identified itself, but sent no sample for 0\.2 s"):
        next(board.samples(silence=0.2))
    board.stop_stream()
    assert near(board.settings(), KIT)


@pytest.mark.parametrize("use", [HapkitBoard.settings, HapkitBoard.save, lambda b: next(b.samples())])
def test_a_closed_board_raises_an_error(use):
    with pytest.raises(errors.DeviceError, match="is not connected"):
        use(HapkitBoard("/dev/ttyNONE7"))

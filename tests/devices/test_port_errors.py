"""Each failure of a port has its own text and next step."""

import errno
import os
import subprocess
import sys

import pytest
import serial

from hapkit_studio import errors
from hapkit_studio.devices import port_errors, serial_ports
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.port_errors import unopened
from hapkit_studio.devices.serial_ports import Identity, Port, Role, port_name
from hapkit_studio.protocol.framing import frame
from hapkit_studio.protocol.messages import Hello
from tests.devices.fake_board import FakeBoard
from tests.devices.fake_ports import FT232, UNO, info, list_ports

SHORT = 0.3
linux = pytest.mark.skipif(sys.platform != "linux", reason="Linux says who holds a port")


@pytest.fixture
def fake():
    boards = []

    def make(answer):
        boards.append(FakeBoard(lambda message: answer))
        return boards[-1].path

    yield make
    for board in boards:
        board.unplug()


def refusal(path):
    with pytest.raises(errors.DeviceError) as caught:
        HapkitBoard(path).open(SHORT)
    assert "\n" not in str(caught.value)
    return caught.value


@pytest.mark.parametrize(
    ("heard", "text"),
    [
        (None, "{} does not answer. The board has no firmware yet, or another sketch: flash the firmware."),
        (b"x=1.25,F=0\r\n", "{} sends text, not frames. Another sketch is on the board: flash the firmware."),
        (
            b"\xfe\x81\x00",
            "{} answers, but not as a Hapkit. Another sketch is on the board: flash the firmware.",
        ),
    ],
)
def test_a_kit_without_firmware_is_offered_to_be_flashed(fake, monkeypatch, heard, text):
    path = fake(heard)
    list_ports(monkeypatch, info(path, UNO))
    error = refusal(path)
    assert isinstance(error, errors.NoFirmwareError)
    assert str(error) == text.format(port_name(path))
    assert error.step == "flash"


def test_what_is_surely_something_else_is_not_offered_to_be_flashed(fake, monkeypatch):
    path = fake(b"OK\r\n")
    list_ports(monkeypatch, info(path, (0x12D1, 0x1506)))
    error = refusal(path)
    expected = f"{port_name(path)} is a port of another kind: mobile modem. Choose another port."
    assert (str(error), error.step) == (expected, "")


@pytest.mark.parametrize(("version", "step"), [(2, "update"), (4, "")])
def test_only_old_firmware_is_updated(fake, version, step):
    error = refusal(fake(frame(bytes([Hello.ID]) + version.to_bytes(2, "little"))))
    assert isinstance(error, errors.WrongProtocolError)
    assert error.step == step


@linux
def test_who_holds_a_port_is_named_whether_it_locks_it_or_shares_it(fake):
    path = fake(None)
    words = (
        "import sys, os; os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY); print(flush=True); sys.stdin.read()"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", words, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    child.stdout.readline()
    try:
        name = f"{os.path.basename(sys.executable)} (process {child.pid})"
        assert serial_ports.holder(path) == name
        error = refusal(path)  # it reads what is meant for us
        assert isinstance(error, errors.PortBusyError)
        assert str(error) == f"{port_name(path)} is used by {name}. Close it, then try again."
        refused = unopened(path, serial.SerialException(errno.EBUSY, "busy"))
        assert str(refused) == str(error)
    finally:
        child.communicate()
    assert serial_ports.holder(path) == ""


@linux
@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("/usr/bin/python3\0-m\0hapkit_studio\0", "Hapkit Studio"),
        ("/opt/a/bin/python\0/opt/a/bin/hapkit-studio\0run\0", "Hapkit Studio"),
        ("/usr/bin/python3\0/opt/a/hapkit_studio.py\0", "python3"),
    ],
)
def test_the_studio_is_called_by_its_name(monkeypatch, tmp_path, line, name):
    monkeypatch.setattr(serial_ports, "LOCKS", tmp_path)
    monkeypatch.setattr(serial_ports, "PROCESSES", tmp_path)
    (tmp_path / "41").mkdir()
    (tmp_path / "41" / "cmdline").write_text(line)
    (tmp_path / "LCK..ttyUSB0").write_text("41\n")
    assert serial_ports.holder("/dev/ttyUSB0") == f"{name} (process 41)"


@linux
def test_a_lock_file_names_who_may_not_be_looked_into(monkeypatch, tmp_path):
    monkeypatch.setattr(serial_ports, "LOCKS", tmp_path)
    monkeypatch.setattr(serial_ports, "PROCESSES", tmp_path)
    (tmp_path / "41").mkdir()
    (tmp_path / "41" / "cmdline").write_bytes(b"/usr/bin/minicom\0-D\0/dev/ttyUSB0\0")
    (tmp_path / "LCK..ttyUSB0").write_text("        41\n")
    assert serial_ports.holder("/dev/ttyUSB0") == "minicom (process 41)"
    (tmp_path / "LCK..ttyUSB0").write_text("        42\n")  # long gone
    assert serial_ports.holder("/dev/ttyUSB0") == ""


def forbidden(monkeypatch, group, joined=False):
    monkeypatch.setattr(port_errors.sys, "platform", "linux")
    monkeypatch.setattr(port_errors, "_group", lambda path: group)
    monkeypatch.setattr(port_errors, "_joined", lambda name: joined)
    return unopened("/dev/ttyUSB0", serial.SerialException(errno.EACCES, "Permission denied"))


def test_a_forbidden_port_comes_with_the_line_to_run(monkeypatch):
    error = forbidden(monkeypatch, "dialout")
    assert isinstance(error, errors.PortPermissionError)
    assert error.command == "sudo usermod -a -G dialout $USER"
    expected = "You may not open ttyUSB0. Run `sudo usermod -a -G dialout $USER`. Then log out and in again."
    assert str(error) == error.brief == expected


def test_who_has_joined_the_group_has_only_to_log_in_again(monkeypatch):
    error = forbidden(monkeypatch, "dialout", joined=True)
    assert error.command == ""
    assert str(error).endswith("You are in the group dialout since you logged in: log out and in again.")


def test_where_no_group_helps_a_udev_rule_for_this_chip_does(monkeypatch):
    list_ports(monkeypatch, info("/dev/ttyUSB0", FT232))
    error = forbidden(monkeypatch, "")
    rule = 'SUBSYSTEM=="tty", ATTRS{idVendor}=="0403", MODE="0660", TAG+="uaccess"'
    assert error.command.startswith(f"echo '{rule}' | sudo tee /etc/udev/rules.d/")
    assert error.command in str(error)
    assert len(error.brief) < 130
    assert "Copy the line" in error.brief


@linux
def test_the_group_counts_only_where_it_may_read_and_write(tmp_path):
    port = tmp_path / "ttyUSB0"
    port.touch()
    port.chmod(0o600)
    assert port_errors.permission_remedy(str(port), None)[1].startswith("echo ")
    unknown = Port("ttyUSB0", "x", Role.UNKNOWN, Identity())
    assert 'KERNEL=="ttyUSB*|ttyACM*"' in port_errors.permission_remedy(str(port), unknown)[1]


def test_nothing_to_run_where_there_is_no_udev(monkeypatch):
    monkeypatch.setattr(port_errors.sys, "platform", "darwin")
    assert port_errors.permission_remedy("/dev/cu.x", None) == ("Ask for the right to use it.", "")

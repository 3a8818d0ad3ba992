"""Serial ports: the list, other users, probing, error messages, and the latency timer."""

import errno
import json
import os
import subprocess
import sys

import pytest
import serial

from hapkit_studio import cli, errors
from hapkit_studio.devices import hapkit, port_errors, serial_ports
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.port_errors import unopened
from hapkit_studio.devices.serial_ports import NOWHERE, Identity, Latency, Role, port_name, shorten_latency
from hapkit_studio.protocol.messages import SettingsRequest
from tests.devices.fake_board import FakeKit
from tests.devices.fake_ports import CH340, FT232, UNO, info, list_ports

linux = pytest.mark.skipif(sys.platform != "linux", reason="Linux says who holds a port")
MODEM = (0x12D1, 0x1506)


PATH = "/dev/ttyTEST"


@pytest.fixture
def plugged(monkeypatch, lined):
    """Return a function that plugs a board in, and returns its port's entry and its line."""

    def plug(answer, numbers=FT232):
        list_ports(monkeypatch, info(PATH, numbers, "AAA"))
        (entry,) = hapkit.entries()
        return entry, lined(answer)

    return plug


# --- the list of ports
def test_kits_are_first_and_other_devices_last(monkeypatch):
    nothing = info("/dev/ttyS4")
    nothing.hwid = "n/a"
    list_ports(
        monkeypatch,
        info("/dev/rfcomm0"),
        info("/dev/ttyACM1", MODEM, product="HUAWEI Mobile"),
        info("/dev/ttyS0"),
        info("/dev/ttyUSB1", CH340, product="USB Serial"),
        info("/dev/ttyACM0", UNO),
        info("/dev/ttyUSB0", FT232, "AB0LB3DQ", "1-2", "FT232R USB UART"),
        info("/dev/ttyACM2", (0x1234, 0x5678), product="Strange device"),
        info("/dev/ttyACM3", (0x2341, 0x0042)),  # this is a different product of the same vendor
        info("/dev/cu.debug-console"),  # macOS lists this port
        nothing,
    )
    assert [(entry.key, entry.title) for entry in hapkit.entries()] == [
        ("/dev/ttyACM0", "ttyACM0: Arduino Uno"),
        ("/dev/ttyUSB0", "ttyUSB0: Hapkit board (FT232)"),
        ("/dev/ttyUSB1", "ttyUSB1: Uno-like board (CH340)"),
        ("/dev/ttyACM2", "ttyACM2: Strange device"),
        ("/dev/ttyACM3", "ttyACM3: Arduino, but not an Uno"),
        ("/dev/ttyS0", "ttyS0: serial port"),
        ("/dev/cu.debug-console", "cu.debug-console: console, not a Hapkit"),
        ("/dev/rfcomm0", "rfcomm0: Bluetooth, not a Hapkit"),
        ("/dev/ttyACM1", "ttyACM1: mobile modem, not a Hapkit"),
    ]


def test_every_row_of_the_chip_table_is_reachable():
    rows = [numbers for chip in serial_ports.CHIPS for numbers in chip.numbers]
    assert len(set(rows)) == len(rows)


A, B = Identity(*FT232, "AAA", "1-1"), Identity(*FT232, "BBB", "1-2")
BARE = Identity(*CH340, "", "1-1")


@pytest.mark.parametrize(
    ("wanted", "there", "path"),
    [
        (A, {"u1": B, "u2": A}, "u2"),
        (A, {"u1": A._replace(place="3-4")}, "u1"),  # the same board is plugged into another socket
        (A, {"u0": B}, None),  # a different kit must not replace the chosen one
        (A, {}, None),
        (BARE, {"u0": BARE._replace(place="1-9"), "u1": BARE}, "u1"),
        (BARE, {"u3": BARE._replace(place="1-9")}, "u3"),
        (BARE, {"u3": BARE._replace(place="1-8"), "u4": BARE._replace(place="1-9")}, None),
        (BARE, {"u0": A}, None),
    ],
)
def test_the_same_board_is_found_again(wanted, there, path):
    ports = [serial_ports.Port(p, "x", Role.KIT, identity) for p, identity in there.items()]
    found = serial_ports.find_same_board(wanted, ports)
    assert (found.path if found else None) == path


def test_another_kit_on_the_same_port_is_not_used(plugged, monkeypatch):
    entry, peer = plugged(FakeKit())
    board = entry.make()
    list_ports(monkeypatch, info(PATH, FT232, "BBB"))
    with pytest.raises(errors.PortGoneError, match="is disconnected"):
        board.open()
    assert peer.received == []


# --- probing
def test_probing_a_kit_gives_firmware_and_settings(plugged, capsys, monkeypatch):
    entry, _ = plugged(FakeKit())
    found = entry.make().probe()
    assert found["ok"]
    assert (found["build"], found["version"], found["arena"]) == ("test", 4, 760)
    assert (found["settings"]["label"], found["settings"]["origin"]) == ("fake kit", "default")
    assert found["text"].startswith(
        "Firmware test, version 4, 760 bytes of memory for a law. "
        "Kit 'fake kit', 20.0 µm of travel per count, force limit 2.5 N. "
        "Settings are default values, because nothing is stored. The USB chip delays data by up to 16 ms"
    )
    monkeypatch.setattr("hapkit_studio.devices.virtual_board.built", lambda: False)
    assert cli.main(["devices", "--probe", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["devices"]
    assert [(d["key"], d["ok"]) for d in listed] == [("simulated", True), (entry.key, True)]
    assert cli.main(["devices", "--probe"]) == 0
    out = capsys.readouterr().out
    assert f"{entry.key:<16} {entry.title}\n" in out
    assert "Kit 'fake kit'" in out


def test_an_uncalibrated_kit_is_listed(plugged):
    found = plugged(FakeKit(deaf={SettingsRequest: 9}))[0].make().probe()
    assert found["ok"]
    assert "did not answer when asked for its settings" in found["text"]


def test_other_devices_are_neither_probed_nor_flashed(plugged):
    entry, peer = plugged(lambda m: b"OK\r\n", MODEM)
    assert entry.make().probe() == {
        "ok": False,
        "text": "This port was not tested, because its device is not a Hapkit.",
    }
    assert peer.received == []
    with pytest.raises(errors.NotAHapkitError, match=r"different kind of port: mobile modem\.") as caught:
        HapkitBoard(PATH).open()
    assert caught.value.step == ""


@pytest.mark.parametrize(
    ("heard", "text"),
    [
        (
            None,
            "{} does not answer. The board has no firmware yet, or runs another sketch: flash the firmware.",
        ),
        (
            b"x=1.25,F=0\r\n",
            "{} sends text instead of Hapkit data. The board runs another sketch: flash the firmware.",
        ),
        (
            b"\xfe\x81\x00",
            "{} answers, but is not a Hapkit. The board runs another sketch: flash the firmware.",
        ),
    ],
)
def test_a_kit_without_firmware_is_offered_to_be_flashed(plugged, heard, text):
    entry, _ = plugged(lambda m: heard, UNO)
    with pytest.raises(errors.NoFirmwareError) as caught:
        entry.make().open()
    assert str(caught.value) == text.format(port_name(PATH))
    assert caught.value.step == "flash"


# --- other users of a port
@pytest.mark.slow
@linux
def test_a_ports_user_is_named_with_or_without_lock(fake_board):
    peer = fake_board(lambda message: None)
    text = (
        "import sys, os; os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY); print(flush=True); sys.stdin.read()"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", text, peer.path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    child.stdout.readline()
    try:
        name = f"{os.path.basename(sys.executable)} (process {child.pid})"
        assert serial_ports.holder(peer.path) == name
        with pytest.raises(errors.PortBusyError) as caught:
            HapkitBoard(peer.path).open()  # the other program reads bytes that the board sends to the studio
        assert str(caught.value) == f"{port_name(peer.path)} is used by {name}. Close it, then try again."
        refused = unopened(peer.path, serial.SerialException(errno.EBUSY, "busy"))
        assert str(refused) == str(caught.value)
    finally:
        child.communicate()
    assert serial_ports.holder(peer.path) == ""


@linux
@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("/usr/bin/python3\0-m\0hapkit_studio\0", "Hapkit Studio"),
        ("/opt/a/bin/python\0/opt/a/bin/hapkit-studio\0run\0", "Hapkit Studio"),
        ("/usr/bin/python3\0/opt/a/hapkit_studio.py\0", "python3"),
        ("/usr/bin/minicom\0-D\0/dev/ttyUSB0\0", "minicom"),
    ],
)
def test_a_ports_user_has_its_program_name(monkeypatch, tmp_path, line, name):
    monkeypatch.setattr(serial_ports, "PROCESSES", tmp_path)
    (tmp_path / "41" / "fd").mkdir(parents=True)
    (tmp_path / "41" / "cmdline").write_text(line)
    (tmp_path / "41" / "fd" / "3").symlink_to("/dev/ttyUSB0")
    assert serial_ports.holder("/dev/ttyUSB0") == f"{name} (process 41)"
    assert serial_ports.holder("/dev/ttyUSB1") == ""


# --- permissions
def forbidden(monkeypatch, group, joined=False):
    monkeypatch.setattr(port_errors.sys, "platform", "linux")
    monkeypatch.setattr(port_errors, "_group", lambda path: group)
    monkeypatch.setattr(port_errors, "_needs_new_login", lambda name: joined)
    return unopened("/dev/ttyUSB0", serial.SerialException(errno.EACCES, "Permission denied"))


def test_a_forbidden_port_is_reported_with_the_command(monkeypatch):
    error = forbidden(monkeypatch, "dialout")
    assert isinstance(error, errors.PortPermissionError)
    assert error.command == "sudo usermod -a -G dialout $USER"
    expected = (
        "You have no permission to open ttyUSB0. Run `sudo usermod -a -G dialout $USER`. "
        "Then log out and in again."
    )
    assert str(error) == error.brief == expected
    joined = forbidden(monkeypatch, "dialout", joined=True)
    assert joined.command == ""
    assert str(joined).endswith("added to the group dialout after your login: log out and in again.")


@linux
def test_without_a_group_a_udev_rule_is_offered(monkeypatch, tmp_path):
    list_ports(monkeypatch, info("/dev/ttyUSB0", FT232))
    error = forbidden(monkeypatch, "")
    rule = 'SUBSYSTEM=="tty", ATTRS{idVendor}=="0403", MODE="0660", TAG+="uaccess"'
    assert error.command.startswith(f"echo '{rule}' | sudo tee /etc/udev/rules.d/")
    assert error.command in str(error)
    assert len(error.brief) < 130
    assert "Copy the command" in error.brief
    monkeypatch.undo()
    port = tmp_path / "ttyUSB0"
    port.touch()
    port.chmod(0o600)  # the port's group may neither read nor write
    assert 'KERNEL=="ttyUSB*|ttyACM*"' in port_errors.permission_remedy(str(port), None)[1]
    monkeypatch.setattr(port_errors.sys, "platform", "darwin")  # without udev there is no command
    assert port_errors.permission_remedy("/dev/cu.x", None) == (
        "Ask the administrator of this computer for permission.",
        "",
    )


# --- latency timer of the USB chip
class Line:
    """A port that records calls."""

    def __init__(self, refuses=None):
        self.asked, self.refuses = [], refuses

    def set_low_latency_mode(self, on):
        self.asked.append(on)
        if self.refuses:
            raise self.refuses


@pytest.fixture
def timer(monkeypatch, tmp_path):
    """Return a function that sets the contents of the system's latency file of ttyUSB0."""
    monkeypatch.setattr(serial_ports, "TIMERS", tmp_path)
    monkeypatch.setattr(serial_ports.sys, "platform", "linux")

    def show(text):
        (tmp_path / "ttyUSB0").mkdir(exist_ok=True)
        (tmp_path / "ttyUSB0" / "latency_timer").write_text(text)

    return show


def test_a_short_timer_needs_no_remedy(timer):
    line = Line()
    timer("1\n")
    latency = shorten_latency(line, "/dev/ttyUSB0", A)
    assert line.asked == [True]
    assert latency == Latency(0.001, True, "/dev/ttyUSB0")
    assert latency.text == "The USB chip delays data by up to 1 ms."


@pytest.mark.parametrize("refuses", [OSError(1, "Operation not permitted"), ValueError(), AttributeError()])
def test_a_refusal_is_reported_with_a_remedy(timer, refuses):
    timer("16\n")
    latency = shorten_latency(Line(refuses), "/dev/ttyUSB0", A)
    assert latency == Latency(0.016, True, "/dev/ttyUSB0")
    assert latency.text.startswith("The USB chip delays data by up to 16 ms. Run `echo 1 | sudo tee ")
    assert "/ttyUSB0/latency_timer`" in latency.text
    assert "let the board compute the force" in latency.text


def test_an_unreadable_timer_is_the_default_and_other_chips_have_none(timer, monkeypatch):
    latency = shorten_latency(Line(), "/dev/ttyUSB0", A)
    assert latency == Latency(0.016, False, "/dev/ttyUSB0")
    assert "the usual value" in latency.text
    for identity in (NOWHERE, Identity(0x2341, 0x0043)):
        none = shorten_latency(Line(), "/dev/ttyACM0", identity)
        assert (none.timer, none.long, none.text) == (None, False, "")
    for system, text in (("win32", "Device Manager"), ("darwin", "FTDI's own driver")):
        monkeypatch.setattr(serial_ports.sys, "platform", system)
        assert text in latency.text

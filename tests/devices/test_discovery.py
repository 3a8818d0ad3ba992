"""What is on the ports, in which order; the same board under another name."""

import pytest

from hapkit_studio import errors
from hapkit_studio.devices import hapkit, serial_ports
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.serial_ports import Identity, Role
from tests.devices.fake_board import FakeBoard
from tests.devices.fake_kit import FakeKit
from tests.devices.fake_ports import CH340, FT232, UNO, info, list_ports

ZOO = (
    info("/dev/rfcomm0"),
    info("/dev/ttyACM1", (0x12D1, 0x1506), product="HUAWEI Mobile"),
    info("/dev/ttyS0"),
    info("/dev/ttyUSB1", CH340, product="USB Serial"),
    info("/dev/ttyACM0", UNO),
    info("/dev/ttyUSB0", FT232, "AB0LB3DQ", "1-2", "FT232R USB UART"),
    info("/dev/ttyACM2", (0x1234, 0x5678), product="Strange device"),
)


def test_kits_come_first_and_what_is_surely_else_last(monkeypatch):
    list_ports(monkeypatch, *ZOO)
    assert [(entry.key, entry.title) for entry in hapkit.entries()] == [
        ("/dev/ttyACM0", "ttyACM0: Arduino Uno"),
        ("/dev/ttyUSB0", "ttyUSB0: Hapkit board (FT232)"),
        ("/dev/ttyUSB1", "ttyUSB1: Uno-like board (CH340)"),
        ("/dev/ttyACM2", "ttyACM2: Strange device"),
        ("/dev/ttyS0", "ttyS0: serial port"),
        ("/dev/rfcomm0", "rfcomm0: Bluetooth, not a Hapkit"),
        ("/dev/ttyACM1", "ttyACM1: mobile modem, not a Hapkit"),
    ]


@pytest.mark.parametrize(
    ("numbers", "role"),
    [
        (FT232, Role.KIT),
        ((0x0403, 0x6010), Role.UNKNOWN),
        ((0x2341, 0x0042), Role.UNKNOWN),
        (CH340, Role.KIT),
    ],
)
def test_a_vendors_other_products_are_not_a_kit(numbers, role):
    assert serial_ports.chip_of(*numbers).role is role


def test_no_row_of_the_table_is_hidden_by_another():
    for chip in serial_ports.CHIPS:
        number = 0xFFFF if chip.product is None else chip.product
        assert serial_ports.chip_of(chip.vendor, number) is chip


def test_a_port_on_a_mac_is_known_by_its_name(monkeypatch):
    list_ports(monkeypatch, info("/dev/cu.Bluetooth-Incoming-Port"), info("/dev/cu.debug-console"))
    assert [port.role for port in serial_ports.ports()] == [Role.OTHER, Role.OTHER]


def test_ports_without_hardware_are_left_out(monkeypatch):
    nothing = info("/dev/ttyS4")
    nothing.hwid = "n/a"
    list_ports(monkeypatch, nothing)
    assert serial_ports.ports() == []
    assert serial_ports.at("/dev/ttyS4") is None


A, B = Identity(*FT232, "AAA", "1-1"), Identity(*FT232, "BBB", "1-2")
BARE = Identity(*CH340, "", "1-1")


def port(path, identity):
    return serial_ports.Port(path, "x", Role.KIT, identity)


@pytest.mark.parametrize(
    ("wanted", "there", "path"),
    [
        (A, {"u1": B, "u2": A}, "u2"),
        (A, {"u1": A._replace(place="3-4")}, "u1"),  # another socket, the same board
        (A, {"u0": B}, None),  # another kit never takes its place
        (A, {}, None),
        (BARE, {"u0": BARE._replace(place="1-9"), "u1": BARE}, "u1"),
        (BARE, {"u3": BARE._replace(place="1-9")}, "u3"),
        (BARE, {"u3": BARE._replace(place="1-8"), "u4": BARE._replace(place="1-9")}, None),
        (BARE, {"u0": A}, None),
    ],
)
def test_the_same_board_is_found_again(wanted, there, path):
    found = serial_ports.found_again(wanted, [port(p, identity) for p, identity in there.items()])
    assert (found.path if found else None) == path


def test_a_board_that_came_back_under_another_name_is_opened_there(monkeypatch):
    peer = FakeBoard(FakeKit())
    list_ports(monkeypatch, info("/dev/ttyUSB0", FT232, "AAA"))
    board = hapkit.entries()[0].make()
    list_ports(monkeypatch, info("/dev/ttyUSB0", FT232, "BBB"), info(peer.path, FT232, "AAA"))
    board.open()
    assert board.port == peer.path
    assert board.title == f"{serial_ports.port_name(peer.path)}: Hapkit board (FT232)"
    board.close()
    peer.unplug()


def test_another_kit_under_its_name_is_left_alone(monkeypatch):
    peer = FakeBoard(FakeKit())
    list_ports(monkeypatch, info(peer.path, FT232, "AAA"))
    board = hapkit.entries()[0].make()
    list_ports(monkeypatch, info(peer.path, FT232, "BBB"))
    with pytest.raises(errors.PortGoneError, match="is gone"):
        board.open()
    assert peer.received == []
    peer.unplug()


def test_what_opening_waits_for_is_said():
    peer, said = FakeBoard(FakeKit()), []
    board = HapkitBoard(peer.path)
    board.say = said.append
    board.open()
    assert said == ["Starting board…"]
    board.close()
    peer.unplug()

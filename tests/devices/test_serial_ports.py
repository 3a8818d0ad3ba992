"""Which ports there are, what is behind them, and who answers."""

import json

import pytest

from hapkit_studio import cli, errors
from hapkit_studio.devices import hapkit, serial_ports
from hapkit_studio.devices.hapkit import HapkitBoard, probe
from hapkit_studio.devices.serial_ports import Identity, Role
from hapkit_studio.protocol.messages import SettingsRequest
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
    found = serial_ports.find_same_board(wanted, [port(p, identity) for p, identity in there.items()])
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
    board.on_status = said.append
    board.open()
    assert said == ["Starting board…"]
    board.close()
    peer.unplug()


@pytest.fixture
def plugged(monkeypatch):
    """Return a function that plugs a fake kit in and returns its line of the list."""
    peers = []

    def plug(kit, numbers=FT232):
        peers.append(FakeBoard(kit))
        list_ports(monkeypatch, info(peers[-1].path, numbers, "AAA"))
        (entry,) = hapkit.entries()
        return entry, peers[-1]

    yield plug
    for peer in peers:
        peer.unplug()


def test_a_kit_says_firmware_and_settings(plugged):
    entry, _ = plugged(FakeKit())
    found = probe(entry)
    assert found["ok"]
    assert (found["build"], found["version"], found["arena"]) == ("test", 3, 760)
    assert found["settings"]["label"] == "fake kit"
    assert found["settings"]["origin"] == "default"
    assert found["text"].startswith(
        "Firmware test, version 3, 760 bytes for a law. "
        "Kit 'fake kit', default settings, 20.0 µm a count, limit 2.5 N. USB latency timer 16 ms"
    )


def test_a_kit_that_does_not_know_its_settings_is_there_all_the_same(plugged):
    entry, _ = plugged(FakeKit(deaf={SettingsRequest: 9}))
    found = probe(entry)
    assert found["ok"]
    assert "did not answer when asked for its settings" in found["text"]


def test_what_is_not_a_hapkit_is_not_even_opened(plugged):
    entry, peer = plugged(FakeKit(), (0x12D1, 0x1506))
    assert probe(entry) == {"ok": False, "text": "Not asked: not a Hapkit."}
    assert peer.received == []


def test_the_command_prints_every_port_with_its_answer(plugged, capsys, monkeypatch):
    entry, _ = plugged(FakeKit())
    monkeypatch.setattr("hapkit_studio.devices.virtual_board.built", lambda: False)
    assert cli.main(["devices", "--probe", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["devices"]
    assert [(d["key"], d["ok"]) for d in found] == [("simulated", True), (entry.key, True)]
    assert cli.main(["devices", "--probe"]) == 0
    out = capsys.readouterr().out
    assert f"{entry.key:<16} {entry.title}\n" in out
    assert "Kit 'fake kit'" in out

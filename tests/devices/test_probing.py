"""Who answers: a kit with its settings, old firmware, a port that is surely something else."""

import json

import pytest

from hapkit_studio import cli
from hapkit_studio.devices import hapkit
from hapkit_studio.devices.hapkit import probe
from hapkit_studio.protocol.messages import SettingsRequest
from tests.devices.fake_board import FakeBoard
from tests.devices.fake_kit import FakeKit
from tests.devices.fake_ports import FT232, info, list_ports


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

"""The command that exports a sketch: its words, its folder, the kit of a connected board."""

import os
from dataclasses import replace

import pytest

from hapkit_studio import cli
from hapkit_studio.protocol.messages import Origin
from tests.devices.fake_board import KIT, FakeBoard, FakeKit


def test_it_writes_a_folder_that_the_ide_opens(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", "wall", "-p", "stiffness=400", "-o", "mine.ino", "--rate", "500"]) == 0
    text = (tmp_path / "mine" / "mine.ino").read_text("utf-8")
    assert "stiffness = 400.0f" in text
    assert "kRate = 500" in text
    assert "wrote mine/mine.ino" in capsys.readouterr().out
    assert cli.main(["export", "wall", "-o", "mine"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert cli.main(["export", "wall", "-o", "mine", "--force"]) == 0
    assert cli.main(["export", "spring"]) == 0
    assert (tmp_path / "spring" / "spring.ino").is_file()


@pytest.mark.skipif(os.name != "posix", reason="pseudo-terminals")
@pytest.mark.parametrize(("origin", "known"), [(Origin.STORED, True), (Origin.DEFAULT, False)])
def test_the_kit_of_a_connected_board_is_taken_as_it_is(origin, known, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    kit = FakeKit(replace(KIT, handle_radius=0.0875, zero=377, direction=-1))
    kit.origin = origin
    board = FakeBoard(kit)
    try:
        assert cli.main(["export", "spring", "--port", board.path]) == 0
    finally:
        board.unplug()
    text = (tmp_path / "spring" / "spring.ino").read_text("utf-8")
    assert "kHandleRadius = 0.0875f" in text
    assert "kHighIsRight = false" in text
    assert ("kZero = 377" in text) is known
    assert ("fake kit, as calibrated" in text) is known

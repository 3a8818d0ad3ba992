"""Commands show and change a board's settings, and test a kit; results are text or JSON."""

import json
import sys
from io import StringIO
from types import SimpleNamespace

import pytest

from hapkit_studio import cli
from hapkit_studio.commands import calibrate, check_hapkit
from hapkit_studio.devices import calibration_file
from hapkit_studio.devices.profiles import named
from hapkit_studio.protocol.messages import Origin
from tests.devices.fake_board import FakeBoard, FakeKit
from tests.devices.paddle_kit import PaddleKit


@pytest.fixture
def kit():
    return FakeKit()


@pytest.fixture
def port(kit):
    board = FakeBoard(kit)
    yield board.path
    board.unplug()


def run(capsys, *args):
    """Run a command; return its exit code, and its JSON output or its error message."""
    code = cli.main([*args, "--json"])
    captured = capsys.readouterr()
    return code, json.loads(captured.out) if code != 2 else captured.err


def test_settings_are_printed_as_text(capsys, port):
    assert cli.main(["calibrate", port]) == 0
    text = capsys.readouterr().out
    assert "magnetoresistive, on A2" in text
    assert "PWM D5, direction D8" in text
    assert "N·s/m" in text
    for name in ("MAGNETORESISTIVE", "D5_D8", "viscous", "N*"):
        assert name not in text


def test_a_kit_is_applied_and_saved(capsys, port, kit):
    code, shown = run(capsys, "calibrate", port, "--kit", "hapkit3-short", "--label", "red 7")
    assert code == 0
    assert shown["handle_radius"] == pytest.approx(0.070)
    assert kit.stored.label == "red 7"


def test_a_file_is_applied(capsys, port, kit, tmp_path, monkeypatch):
    monkeypatch.setenv(calibration_file.VARIABLE, str(tmp_path))
    path = calibration_file.write(named("hapkit2013").board, {})
    code, shown = run(capsys, "calibrate", port, "--from", str(path), "--write")
    assert code == 0
    assert kit.stored.sector_radius == pytest.approx(0.0732)
    assert calibration_file.read(shown["written"]).pulley_radius == pytest.approx(0.00419)


@pytest.mark.parametrize(
    ("args", "text"),
    [
        (["--kit", "nokit"], "There is no kit"),
        (["--from", "nowhere.toml"], "Cannot read"),
        (["--kit", "hapkit3", "--from", "x"], "not both"),
        (["--label", "much too long a name"], "12"),
        (["--springs", "100", "150"], "2 × as stiff"),
        (["--springs", "100", "-300"], "40 or more N/m"),
        (["--springs", "100", "300", "--springs-known", "60"], "50 % or less"),
    ],
)
def test_invalid_input_is_one_line_and_changes_nothing(capsys, port, kit, args, text):
    code, complaint = run(capsys, "calibrate", port, *args)
    assert code == 2
    assert text in complaint
    assert complaint.count("\n") == 1
    assert kit.stored is None


class Person(StringIO):
    """Input of a user who attaches the requested spring and presses Enter."""

    def __init__(self, kit, stiffnesses):
        super().__init__()
        self.kit, self.stiffnesses = kit, list(stiffnesses)

    def readline(self):
        if self.stiffnesses:
            self.kit.spring = self.stiffnesses.pop(0)
            return "\n"
        return ""


@pytest.mark.slow
def test_two_springs_attached_by_a_person_measure_the_motor_constant(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv(calibration_file.VARIABLE, str(tmp_path))
    kit = PaddleKit(torque=0.9 * 0.0183)
    monkeypatch.setattr(calibrate, "board_named", lambda key: kit)
    monkeypatch.setattr(sys, "stdin", Person(kit, (100.0, 300.0)))
    args = ["calibrate", "port", "--springs", "300", "100", "--springs-known", "1", "--write"]
    assert cli.main(args) == 0
    captured = capsys.readouterr()
    assert captured.err.index("100 N/m between the handle") < captured.err.index("300 N/m between the handle")
    assert captured.out.startswith("The motor gives 90 ± 2 % of the force that was set")
    assert kit.stored.motor_constant == pytest.approx(0.9 * 0.0183, rel=0.01)
    (file,) = (tmp_path / calibration_file.FOLDER).glob("*.toml")
    assert "# Strength: The motor gives 90 ± 2 %" in file.read_text(encoding="utf-8")
    monkeypatch.setattr(sys, "stdin", Person(kit, ()))
    assert cli.main(args) == 2
    assert "in a terminal" in capsys.readouterr().err


def test_a_simulated_device_has_no_board(capsys):
    for command in ("check", "calibrate"):
        code, complaint = run(capsys, command, "simulated")
        assert code == 2
        assert "no board" in complaint


def test_check_prints_a_result_for_each(monkeypatch):
    kit = PaddleKit(direction=-1)
    kit.origin = Origin.STORED
    monkeypatch.setattr(check_hapkit, "board_named", lambda key: kit)
    result = check_hapkit.run(SimpleNamespace(device="port"))
    assert result.code == check_hapkit.DANGER
    assert result.as_json["pass"] is False
    assert result.as_json["checks"]["direction"]["key"] == "opposite"
    assert "Direction          FAIL" in result.text
    assert "Do not use this Hapkit yet. First repair: direction. " in result.text
    assert "Not tested yet: mass and friction, spring." in result.text

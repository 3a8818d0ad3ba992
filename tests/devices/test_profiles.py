"""Kits: complete, different, as the reference says; and calibrated, in files that are read as written."""

import math
import re
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board

HEADER = Path(__file__).resolve().parents[2] / "firmware" / "hapkit" / "profile.h"


def test_kits_differ_can_travel_on_the_wire_and_are_plausible():
    for of in (lambda k: k.key, lambda k: k.board.profile, lambda k: k.board.label, lambda k: k.title):
        assert len({of(kit) for kit in profiles.KITS}) == len(profiles.KITS)
    for kit in profiles.KITS:
        assert Board.unpack(kit.board.pack()).counts_per_flip == kit.board.counts_per_flip
        assert 1e-6 < kit.board.quantum < 1e-3
        assert kit.board.max_force <= profiles.full_force(kit.board)


@pytest.mark.parametrize(
    ("constant", "field"),
    [("kHandleRadius", "handle_radius"), ("kPulleyRadius", "pulley_radius"), ("kMaxForce", "max_force"),
     ("kSectorRadius", "sector_radius"), ("kMotorConstant", "motor_constant"),
     ("kCountsPerFlip", "counts_per_flip")],
)  # fmt: skip
def test_the_default_is_the_firmwares_own(constant, field):
    found = re.search(rf"\b{constant} = ([0-9.]+)", HEADER.read_text())
    assert float(found[1]) == pytest.approx(getattr(profiles.default().board, field))


@pytest.mark.parametrize(
    ("key", "quantum", "force"),
    [
        ("hapkit3", 20.7e-6, 3.01),
        ("hapkit3-short", 16.1e-6, 3.87),
        ("hapkit3-maxon", 20.7e-6, 4.93),
        ("hapkit2013", 12.8e-6, 7.98),
        # sensors that repeat every turn have twice the travel between repeats
        ("hapkit-hall", 2.0 * 20.7e-6 * 921 / 16384, 3.01),
        ("hapkit-encoder", 2.0 * math.pi * 0.090 * 0.005 / 0.075 / 48, 0.0167 * 0.075 / 0.00045),
    ],
)
def test_travel_per_count_and_full_force_are_those_of_the_reference(key, quantum, force):
    board = profiles.named(key).board
    assert board.quantum == pytest.approx(quantum, rel=0.003)
    assert profiles.full_force(board) == pytest.approx(force, rel=0.002)


def test_an_unknown_kit_is_named_with_those_there_are():
    with pytest.raises(ParameterError, match=r"hapkit9.*hapkit3"):
        profiles.named("hapkit9")
    assert profiles.numbered(200) is None


# --- files
@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv(calibration_file.VARIABLE, str(tmp_path))
    return tmp_path


def test_what_was_written_is_read_again_and_nothing_is_written_over(own):
    board = replace(
        profiles.named("hapkit2013").board, zero=-4711, sense=-1, mass=0.0431234567, label='a "7"'
    )
    day = date(2026, 2, 3)
    path = calibration_file.write(board, {"Sensor": "fine", "Strength": "left out"}, day)
    assert path == own / "calibrations" / "a-7 2026-02-03.toml"
    again = calibration_file.read(path)
    assert again.mass == pytest.approx(board.mass, rel=1e-7)  # a board keeps 32 bits
    assert replace(again, mass=board.mass, quantum=board.quantum) == board
    text = path.read_text(encoding="utf-8")
    assert "# Sensor: fine" in text
    assert "# Written on 2026-02-03" in text
    assert "coulomb = 0.1 " in text  # no digits that the board has not
    assert "# kg: of the paddle at the handle" in text
    other = calibration_file.write(replace(board, zero=2), {}, day)
    assert other.name == "a-7 2026-02-03 2.toml"
    assert [calibration_file.read(file).zero for file in (path, other)] == [-4711, 2]


@pytest.mark.parametrize("text", ["", "[board]\n", "[[", "[board]\nprofile = 1\n", None])
def test_what_is_no_calibration_is_said_in_one_line(own, text):
    path = own / "x.toml"
    if text is None:
        whole = calibration_file.write(profiles.default().board, {}).read_text(encoding="utf-8")
        text = whole.replace("mass = 0.044", 'mass = "heavy"')
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=r"^x\.toml[^\n]*$"):
        calibration_file.read(path)
    with pytest.raises(ParameterError, match="Cannot read"):
        calibration_file.read(own / "nowhere.toml")


@pytest.mark.parametrize(
    ("text", "good"), [("x" * 12, True), ("x" * 13, False), ("  ", False), ("Kätzchen", False)]
)
def test_a_label_fits_the_board(text, good):
    if good:
        assert calibration_file.checked_label(f" {text} ") == text
    else:
        with pytest.raises(ParameterError, match="12"):
            calibration_file.checked_label(text)

"""Calibrations in files: what was written is read again, what is none is said in one line."""

from dataclasses import replace
from datetime import date

import pytest

from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.errors import ParameterError


@pytest.fixture(autouse=True)
def own(tmp_path, monkeypatch):
    monkeypatch.setenv(calibration_file.VARIABLE, str(tmp_path))
    return tmp_path


def test_what_was_written_is_read_again(own):
    board = replace(
        profiles.named("hapkit2013").board,
        zero=-4711,
        sense=-1,
        mass=0.0431234567,
        label='a "7"',
        dead_band=31,
    )
    path = calibration_file.write(board, {"Sensor": "fine", "Strength": "left out"}, date(2026, 2, 3))
    assert path.name == "a-7 2026-02-03.toml"
    assert path.parent == own / "calibrations"
    again = calibration_file.read(path)
    assert again.mass == pytest.approx(board.mass, rel=1e-7)  # a board keeps 32 bits
    assert replace(again, mass=board.mass, quantum=board.quantum) == board
    text = path.read_text(encoding="utf-8")
    assert "# Sensor: fine" in text
    assert "# Written on 2026-02-03" in text
    assert "coulomb = 0.1 " in text  # no digits that the board has not
    assert "# kg: of the paddle at the handle" in text


def test_nothing_is_written_over():
    day = date(2026, 2, 3)
    boards = [replace(profiles.default().board, zero=zero) for zero in (1, 2, 3)]
    paths = [calibration_file.write(board, {}, day) for board in boards]
    assert [path.name for path in paths] == [f"hapkit 2026-02-03{n}.toml" for n in ("", " 2", " 3")]
    assert [calibration_file.read(path).zero for path in paths] == [1, 2, 3]


@pytest.mark.parametrize("text", ["", "[board]\n", "[[", "[board]\nprofile = 1\n"])
def test_what_is_no_calibration_is_said_in_one_line(own, text):
    path = own / "x.toml"
    path.write_text(text)
    with pytest.raises(ParameterError) as caught:
        calibration_file.read(path)
    assert "\n" not in str(caught.value)
    assert "x.toml" in str(caught.value)


def test_numbers_of_another_kind_are_refused(own):
    path = calibration_file.write(profiles.default().board, {})
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("mass = 0.044", 'mass = "heavy"'), encoding="utf-8")
    with pytest.raises(ParameterError, match="mass"):
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

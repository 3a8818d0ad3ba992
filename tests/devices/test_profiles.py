"""Kits are complete and distinct, and agree with the reference; calibration files are read as written."""

import math
import re
import struct
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.protocol.messages import Board

HEADER = Path(__file__).resolve().parents[2] / "firmware" / "hapkit" / "profile.h"


def test_kits_are_distinct_encodable_and_plausible():
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
        # these sensors repeat after a full turn of the motor; the sensors above repeat after half a turn
        ("hapkit-hall", 2.0 * 20.7e-6 * 921 / 16384, 3.01),
        ("hapkit-encoder", 2.0 * math.pi * 0.090 * 0.005 / 0.075 / 48, 0.0167 * 0.075 / 0.00045),
    ],
)
def test_travel_per_count_and_full_force_are_those_of_the_reference(key, quantum, force):
    board = profiles.named(key).board
    assert board.quantum == pytest.approx(quantum, rel=0.003)
    assert profiles.full_force(board) == pytest.approx(force, rel=0.002)


def test_an_unknown_kit_lists_the_known_ones():
    with pytest.raises(ParameterError, match=r"hapkit9.*hapkit3"):
        profiles.named("hapkit9")
    assert profiles.numbered(200) is None


# --- calibration files
@pytest.fixture
def own(tmp_path, monkeypatch):
    monkeypatch.setenv(calibration_file.VARIABLE, str(tmp_path))
    return tmp_path


def test_files_are_read_as_written_and_never_overwritten(own):
    board = replace(
        profiles.named("hapkit2013").board, zero=-4711, sense=-1, mass=0.0431234567, label='a "7"'
    )
    day = date(2026, 2, 3)
    path = calibration_file.write(board, {"Sensor": "fine", "Strength": "left out"}, day)
    assert path == own / "calibrations" / "a-7 2026-02-03.toml"
    again = calibration_file.read(path)
    assert again.mass == pytest.approx(board.mass, rel=1e-7)  # a board stores numbers with 32 bits
    assert replace(again, mass=board.mass, quantum=board.quantum) == board
    text = path.read_text(encoding="utf-8")
    assert "# Sensor: fine" in text
    assert "# Written on 2026-02-03" in text
    assert "coulomb = 0.1 " in text  # the file has no more digits than the board
    assert "# kg: mass of the paddle at the handle" in text
    other = calibration_file.write(replace(board, zero=2), {}, day)
    assert other.name == "a-7 2026-02-03 2.toml"
    assert [calibration_file.read(file).zero for file in (path, other)] == [-4711, 2]


@pytest.mark.parametrize("text", ["", "[board]\n", "[[", "[board]\nprofile = 1\n", None])
def test_invalid_calibrations_give_a_one_line_error(own, text):
    path = own / "x.toml"
    if text is None:
        whole = calibration_file.write(profiles.default().board, {}).read_text(encoding="utf-8")
        text = whole.replace("mass = 0.044", 'mass = "heavy"')
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=r"^x\.toml[^\n]*$"):
        calibration_file.read(path)
    with pytest.raises(ParameterError, match="Cannot read"):
        calibration_file.read(own / "nowhere.toml")


WHOLE = "it must be a whole number from"
EDITED = {
    'label = "Zoë 7"': "label is 'Zoë 7'; it must be at most 12 ASCII characters.",
    'label = "Hapkit number seven"': "label is 'Hapkit number seven'; it must be a line of at most 12",
    'label = "\\u001b[2J"': r"label is '\x1b[2J'; it must be a line of at most 12 printable characters.",
    "label = 7": "label is 7; it must be a line of at most 12 printable characters.",
    "profile = 300": f"profile is 300; {WHOLE} 0 to 255.",
    "profile = true": f"profile is True; {WHOLE} 0 to 255.",
    "pins = -1": f"pins is -1; {WHOLE} 0 to 255.",
    "pins = 2": "pins is 2; it must be one of 0 (PWM D5, direction D8), 1 (PWM D3, direction D12).",
    "sensor = 1.0": f"sensor is 1.0; {WHOLE} 0 to 255.",
    "direction = 0": "direction is 0; it must be one of 1 (right), -1 (left).",
    "sense = 128": f"sense is 128; {WHOLE} -128 to 127.",
    "counts_per_flip = 70000": f"counts_per_flip is 70000; {WHOLE} 0 to 65,535.",
    "zero = 99999999999": f"zero is 99999999999; {WHOLE} -2,147,483,648 to 2,147,483,647.",
    "zero = 0x" + "f" * 200: "zero is 6668014432879854274079851790721257797144…; it must be",
    "dead_band = 300": f"dead_band is 300; {WHOLE} 0 to 255.",
    "mass = nan": "mass is nan; it must be a number from -3.40282e+38 to 3.40282e+38 kg.",
    "viscous = 1e39": "viscous is 1e+39; it must be a number from -3.40282e+38 to 3.40282e+38 N·s/m.",
    "quantum = [1.0]": "quantum is [1.0]; it must be a number from -3.40282e+38 to 3.40282e+38 m.",
    "table = [1, 2, 3]": "table is [1, 2, 3]; it must be a list of 8 values.",
    "table = [1, 2, 3, 4, 5, 6, 7, 256]": f"table[7] is 256; {WHOLE} 0 to 255.",
    "table = 3": "table is 3; it must be a list of 8 values.",
    "coulomb": "coulomb is missing.",
}


@pytest.fixture
def edited(own):
    """Return a function that writes a calibration with one line replaced."""
    path = calibration_file.write(profiles.default().board, {})
    whole = path.read_text(encoding="utf-8")

    def make(line):
        pattern, new = rf"^{line.split(' =')[0]} = .*$", line if "=" in line else ""
        text, count = re.subn(pattern, lambda _: new, whole, flags=re.M)
        assert count == 1
        path.write_text(text, encoding="utf-8")
        return path

    return make


@pytest.mark.parametrize("line", EDITED)
def test_values_out_of_the_boards_range_are_rejected(edited, line):
    path = edited(line)
    with pytest.raises(FileError) as error:
        calibration_file.read(path)
    assert str(error.value).startswith(f"{path.name}: board.{EDITED[line]}")
    assert "\n" not in str(error.value)


def test_numbers_are_accepted_if_their_wire_type_fits(edited):
    """Python's struct module decides which numbers fit."""
    for field in Board.layout():
        if field.code.endswith("s") or field.name in ("pins", "sensor", "motor_map", "sense", "direction"):
            continue
        for bits in (7, 8, 15, 16, 31, 32, 127, 128):
            for value in (2**bits - 1, 2**bits, -(2**bits), -(2**bits) - 1):
                given = [value] * field.numbers
                try:
                    carried = struct.unpack(f"<{field.code}", struct.pack(f"<{field.code}", *given))
                except (struct.error, OverflowError):
                    carried = None
                path = edited(f"{field.name} = {given if field.numbers > 1 else value}")
                if carried is None:
                    with pytest.raises(FileError, match=field.name):
                        calibration_file.read(path)
                else:
                    again = getattr(Board.unpack(calibration_file.read(path).pack()), field.name)
                    assert again == (carried if field.numbers > 1 else carried[0])


@pytest.mark.parametrize(
    ("text", "good"), [("x" * 12, True), ("x" * 13, False), ("  ", False), ("Kätzchen", False)]
)
def test_a_label_fits_the_board(text, good):
    if good:
        assert calibration_file.checked_label(f" {text} ") == text
    else:
        with pytest.raises(ParameterError, match="12"):
            calibration_file.checked_label(text)

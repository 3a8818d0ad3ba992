"""Calibrations as text: the settings of a board with units, and TOML files in the user's folder."""

import contextlib
import itertools
import json
import os
import re
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from hapkit_studio.devices.profiles import numbered
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import (
    checked_integer,
    checked_list,
    checked_number,
    checked_table,
    checked_text,
    read_toml,
)
from hapkit_studio.formatting import number, quoted
from hapkit_studio.protocol.messages import Board, MotorMap, Origin, Pins, Sensor, Wire

FOLDER = "calibrations"
VARIABLE = "HAPKIT_STUDIO_FOLDER"
_CHOICES: dict[str, tuple[str, dict[int, str]]] = {
    "pins": (
        "Pins of the motor",
        {Pins.D5_D8: "PWM D5, direction D8", Pins.D3_D12: "PWM D3, direction D12"},
    ),
    "sensor": (
        "Sensor",
        {
            Sensor.MAGNETORESISTIVE: "magnetoresistive, on A2",
            Sensor.AS5048A: "AS5048A, over SPI",
            Sensor.QUADRATURE: "two channels, on D2 and D3",
        },
    ),
    "motor_map": (
        "Torque as a function of duty",
        {MotorMap.SQUARE: "square of the duty", MotorMap.LINEAR: "proportional", MotorMap.TABLE: "table"},
    ),
    "sense": ("Counts grow when handle moves", {1: "right", -1: "left"}),
    "direction": ("Push direction when pin is high", {1: "right", -1: "left"}),
}
# label, display units per SI unit, unit, decimals
_NUMBERS = {
    "counts_per_flip": ("Counts until the reading repeats", 1.0, "", 0),
    "quantum": ("Travel per count", 1e6, "µm", 2),
    "zero": ("Count at position zero", 1.0, "", 0),
    "motor_constant": ("Motor constant", 1e3, "mN·m", 2),
    "max_force": ("Force limit", 1.0, "N", 2),
    "dead_band": ("Dead band (duty; 255 = full)", 1.0, "", 0),
    "mass": ("Mass felt at the handle", 1e3, "g", 1),
    "viscous": ("Damping", 1.0, "N·s/m", 3),
    "coulomb": ("Dry friction", 1.0, "N", 3),
    "handle_radius": ("From axis to handle, rh", 1e3, "mm", 2),
    "pulley_radius": ("Radius of the pulley, rp", 1e3, "mm", 2),
    "sector_radius": ("Radius of the sector, rs", 1e3, "mm", 2),
}
MEASURED = (
    "counts_per_flip", "quantum", "zero", "sense", "direction", "motor_constant", "max_force", "dead_band",
    "mass", "viscous", "coulomb", "handle_radius", "pulley_radius", "sector_radius",
)  # fmt: skip
"""Settings that a calibration may change, in the order of its steps."""
SHOWN = ("label", "profile", "pins", "sensor", "motor_map", *MEASURED, "table")
ORIGINS = {
    Origin.DEFAULT: "default values, because nothing is stored",
    Origin.STORED: "stored on the board",
    Origin.DAMAGED: "default values, because the stored settings are damaged",
    Origin.UNSAVED: "changed, not stored yet",
}
"""Descriptions of the origin of a board's current settings."""
_LABELS = {"label": "Name", "profile": "Kit", "table": "Torque at 1/8 to 8/8 of full motor power"}


def folder() -> Path:
    """Return the folder of calibrations, which may not exist yet."""
    base = os.environ.get(VARIABLE)
    root = Path(base) if base else Path(platformdirs.user_config_dir("hapkit-studio", appauthor=False))
    return root / FOLDER


def checked_label(text: str) -> str:
    """Return a label if a board can store it: at most 12 ASCII characters; otherwise raise ParameterError."""
    label = text.strip()
    if not label or len(label) > 12 or not (label.isascii() and label.isprintable()):
        raise ParameterError(
            f"A kit's name must have 1 to 12 characters without accents, not {quoted(text)}."
        )
    return label


def write(board: Board, notes: dict[str, str], day: date | None = None) -> Path:
    """Write a calibration with notes on each step to a new file and return its path."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", board.label).strip("-").lower() or "hapkit"
    written = (day or date.today()).isoformat()
    folder().mkdir(parents=True, exist_ok=True)
    for count in itertools.count(1):  # the second and later files of a day have a number
        path = folder() / f"{name} {written}{f' {count}' if count > 1 else ''}.toml"
        with contextlib.suppress(FileExistsError):
            path.touch(exist_ok=False)
            break
    part = path.with_suffix(".part")
    part.write_text(_text(board, notes, written), encoding="utf-8")
    os.replace(part, path)
    return path


def read(path: str | Path) -> Board:
    """Return the settings in a calibration file; raise ParameterError for an invalid file."""
    name = Path(path).name
    table = checked_table(read_toml(path).get("board"), f"{name}: board")
    wires = Board.layout()
    return Board(**{wire.name: _checked(table, wire, f"{name}: board.{wire.name}") for wire in wires})


def _checked(table: dict[str, Any], wire: Wire, place: str) -> Any:
    """Return a setting if the Board message allows its value; otherwise raise FileError."""
    if wire.name not in table:
        raise FileError(f"{place} is missing.")
    value = table[wire.name]
    if wire.code.endswith("s"):
        text = checked_text(value, place, wire.size)
        if not text.isascii():
            raise FileError(f"{place} is {quoted(text)}; it must be at most {wire.size} ASCII characters.")
        return text
    if wire.code.endswith("f"):
        return checked_number(value, place, *wire.limits, wire.unit.replace("*", "·"))
    if wire.numbers > 1:
        parts = enumerate(checked_list(value, place, wire.numbers))
        return tuple(checked_integer(part, f"{place}[{at}]", *wire.limits) for at, part in parts)
    number = checked_integer(value, place, *wire.limits)
    if wire.name in _CHOICES and number not in _CHOICES[wire.name][1]:
        known = ", ".join(f"{option:d} ({label})" for option, label in _CHOICES[wire.name][1].items())
        raise FileError(f"{place} is {number}; it must be one of {known}.")
    return number


def _text(board: Board, notes: dict[str, str], written: str) -> str:
    lines = ["# A calibrated Hapkit. Write it to a board with: hapkit-studio calibrate PORT --from FILE"]
    lines.append(f"# Written on {written}")
    lines += [f"# {step}: {note}" for step, note in notes.items()]
    lines += ["", "[board]"]
    for field in Board.layout():
        unit = f"{field.unit.replace('*', '·')}: " if field.unit else ""
        chosen = field.name in ("pins", "sensor", "motor_map")
        what = f"{setting_label(field.name)}: {setting_text(board, field.name)}" if chosen else field.help
        lines.append(f"{field.name} = {_value(getattr(board, field.name))}  # {unit}{what}")
    return "\n".join(lines) + "\n"


def _value(value: Any) -> str:
    """Format a value for TOML; texts and lists are formatted as JSON."""
    if isinstance(value, float):
        return str(np.float32(value))
    return json.dumps(int(value) if isinstance(value, int) else value)


def setting_label(name: str) -> str:
    """Return the label of a setting."""
    if name in _CHOICES:
        return _CHOICES[name][0]
    return _NUMBERS[name][0] if name in _NUMBERS else _LABELS[name]


def setting_text(board: Board, name: str) -> str:
    """Format one of a board's settings with its unit."""
    value = getattr(board, name)
    if name in _CHOICES:
        return _CHOICES[name][1].get(value, f"unknown, {value}")
    if name in _NUMBERS:
        _label, factor, unit, decimals = _NUMBERS[name]
        return f"{number(factor * value, decimals)} {unit}".strip()
    if name == "profile":
        kit = numbered(value)
        return kit.title if kit else "a custom kit"
    return str(value) if name == "label" else ", ".join(str(int(part)) for part in value)

"""Calibrations as readable files: a new TOML each time, in the person's own folder of settings."""

import os
import re
import tomllib
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from hapkit_studio.devices.calibration_words import shown, words_of
from hapkit_studio.devices.profiles import default
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board

FOLDER = "calibrations"
_KINDS = {int: "a whole number", float: "a number", str: "text", tuple: "eight whole numbers"}
VARIABLE = "HAPKIT_STUDIO_FOLDER"


def folder() -> Path:
    """Return the folder of calibrations, which may not exist yet."""
    base = os.environ.get(VARIABLE)
    root = Path(base) if base else Path(platformdirs.user_config_dir("hapkit-studio", appauthor=False))
    return root / FOLDER


def label_of(text: str) -> str:
    """Return a label as a board can keep it: printable ASCII, 12 at most; raise ParameterError."""
    label = text.strip()
    if not label or len(label) > 12 or not (label.isascii() and label.isprintable()):
        raise ParameterError(f"A kit's name has 1 to 12 plain letters, not {text!r}.")
    return label


def write(board: Board, notes: dict[str, str], day: date | None = None) -> Path:
    """Write a calibration with notes on what each step found; return the file, a new one; raise OSError."""
    name = re.sub(r"[^A-Za-z0-9]+", "-", board.label).strip("-").lower() or "hapkit"
    written = (day or date.today()).isoformat()
    folder().mkdir(parents=True, exist_ok=True)
    path = _claimed(f"{name} {written}")
    part = path.with_suffix(".part")
    part.write_text(_text(board, notes, written), encoding="utf-8")
    os.replace(part, path)
    return path


def _claimed(name: str) -> Path:
    """Return a new empty file of a name, with a number behind it from the second on."""
    number = 1
    while True:
        path = folder() / f"{name}{f' {number}' if number > 1 else ''}.toml"
        try:
            path.touch(exist_ok=False)
        except FileExistsError:
            number += 1
        else:
            return path


def read(path: str | Path) -> Board:
    """Return the settings in a calibration; raise ParameterError with one line."""
    try:
        table = tomllib.loads(Path(path).read_text(encoding="utf-8")).get("board")
    except OSError as error:
        raise ParameterError(f"Cannot read {path}: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ParameterError(f"{Path(path).name} is no calibration: {error}.") from None
    if not isinstance(table, dict):
        raise ParameterError(f"{Path(path).name} is no calibration: it has no [board].")
    return _board(table, Path(path).name)


def _board(table: dict[str, Any], name: str) -> Board:
    """Return a table's settings; every number must be there and of the kind that a board keeps."""
    usual = default().board
    values: dict[str, Any] = {}
    for field in Board.layout():
        value, like = table.get(field.name), getattr(usual, field.name)
        value = tuple(value) if isinstance(value, list) else value
        value = float(value) if isinstance(like, float) and isinstance(value, int) else value
        kind = int if isinstance(like, int) else type(like)
        if not isinstance(value, kind):
            raise ParameterError(f"{name}: {field.name} is missing, or not {_KINDS[kind]}.")
        values[field.name] = value
    return Board(**values)


def _text(board: Board, notes: dict[str, str], written: str) -> str:
    lines = ["# A calibrated Hapkit. Put it on a board again with: hapkit-studio calibrate PORT --from FILE"]
    lines.append(f"# Written on {written}")
    lines += [f"# {step}: {words}" for step, words in notes.items()]
    lines += ["", "[board]"]
    for field in Board.layout():
        unit = f"{field.unit.replace('*', '·')}: " if field.unit else ""
        words = _help(board, field.name, field.help)
        lines.append(f"{field.name} = {_value(getattr(board, field.name))}  # {unit}{words}")
    return "\n".join(lines) + "\n"


def _help(board: Board, name: str, usual: str) -> str:
    """Return what a number means; of a choice, what was chosen."""
    return f"{words_of(name)}: {shown(board, name)}" if name in ("pins", "sensor", "motor_map") else usual


def _value(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, tuple):
        return "[" + ", ".join(str(int(v)) for v in value) + "]"
    return str(np.float32(value)) if isinstance(value, float) else str(int(value))

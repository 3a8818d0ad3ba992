"""The command that shows a board's calibration, or puts a kit's or a file's on it."""

import argparse
from dataclasses import replace
from typing import Any

from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.commands.check_hapkit import board_named
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board, MotorMap, Origin, Pins, Sensor, Settings

_NAMES = {"pins": Pins, "sensor": Sensor, "motor_map": MotorMap}


_KEYS = ", ".join(kit.key for kit in profiles.KITS)
OPTIONS = (
    option("device", help="a device's key or a port"),
    option("--kit", metavar="KEY", help=f"put a kit's usual numbers on the board: {_KEYS}"),
    option("--from", dest="file", metavar="TOML", help="put a calibration file on the board"),
    option("--label", metavar="NAME", help="the kit's name, 12 letters at most"),
    option("--write", action="store_true", help="write the calibration to a file, too"),
)


def run(options: argparse.Namespace) -> Result:
    """Show the settings in force; first put others in force and keep them, where asked."""
    wanted = _wanted(options)
    board = board_named(options.device)
    board.open()
    try:
        settings = board.settings()
        if wanted is not None or options.label:
            chosen = wanted or profiles.of_settings(settings)
            label = calibration_file.checked_label(options.label) if options.label else chosen.label
            board.configure(replace(chosen, label=label))
            settings = board.save()
    finally:
        board.close()
    written = str(calibration_file.write(profiles.of_settings(settings), {})) if options.write else ""
    return Result(_text(settings, written), {**_numbers(settings), "written": written})


def _wanted(options: argparse.Namespace) -> Board | None:
    """Return the settings that the options name; raise ParameterError."""
    if options.kit and options.file:
        raise ParameterError("Name a kit or a file, not both.")
    if options.kit:
        return profiles.named(options.kit).board
    return calibration_file.read(options.file) if options.file else None


def _numbers(settings: Settings) -> dict[str, Any]:
    numbers = {f.name: getattr(settings, f.name) for f in Board.layout()}
    words = {name: kind(numbers[name]).name for name, kind in _NAMES.items()}
    return {**numbers, **words, "origin": Origin(settings.origin).name}


def _text(settings: Settings, written: str) -> str:
    board = profiles.of_settings(settings)
    rows = [
        (calibration_file.setting_label(k), calibration_file.setting_text(board, k)) for k in _shown(board)
    ]
    rows.append(("Settings are", calibration_file.origin_text(settings.origin)))
    lines = [f"{words:<34} {value}" for words, value in rows]
    return "\n".join(lines + ([f"wrote {written}"] if written else []))


def _shown(board: Board) -> list[str]:
    """Return the settings that mean something: the table only where the motor has one."""
    return [k for k in calibration_file.SHOWN if k != "table" or board.motor_map == MotorMap.TABLE]


COMMAND = Command("calibrate", "show a board's calibration, or put another on it", run, OPTIONS, 96)

"""The command that shows a board's calibration, or puts a kit's or a file's on it."""

import argparse
import contextlib
from dataclasses import replace

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
    if options.kit and options.file:
        raise ParameterError("Name a kit or a file, not both.")
    wanted = calibration_file.read(options.file) if options.file else None
    if options.kit:
        wanted = profiles.named(options.kit).board
    with contextlib.closing(board_named(options.device)) as board:
        board.open()
        settings = board.settings()
        if wanted is not None or options.label:
            chosen = wanted or profiles.of_settings(settings)
            label = calibration_file.checked_label(options.label) if options.label else chosen.label
            board.configure(replace(chosen, label=label))
            settings = board.save()
    written = str(calibration_file.write(profiles.of_settings(settings), {})) if options.write else ""
    numbers = {f.name: getattr(settings, f.name) for f in Board.layout()}
    words = {name: kind(numbers[name]).name for name, kind in _NAMES.items()}
    found = {**numbers, **words, "origin": Origin(settings.origin).name, "written": written}
    return Result(_text(settings, written), found)


def _text(settings: Settings, written: str) -> str:
    board = profiles.of_settings(settings)
    rows = [
        (calibration_file.setting_label(name), calibration_file.setting_text(board, name))
        for name in calibration_file.SHOWN
        if name != "table" or board.motor_map == MotorMap.TABLE
    ]
    rows.append(("Settings are", calibration_file.ORIGINS[Origin(settings.origin)]))
    lines = [f"{words:<34} {value}" for words, value in rows]
    return "\n".join(lines + ([f"wrote {written}"] if written else []))


COMMAND = Command("calibrate", "show a board's calibration, or put another on it", run, OPTIONS, 96)

"""The command that shows a board's calibration, applies a new calibration, or measures the motor constant."""

import argparse
import contextlib
import sys
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.commands.check_hapkit import board_named
from hapkit_studio.devices import calibration_file, profiles
from hapkit_studio.devices.board_runner import BoardRunner
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import check_number
from hapkit_studio.protocol.messages import Board, MotorMap, Origin, Pins, Sensor, Settings

if TYPE_CHECKING:
    from hapkit_studio.analysis.calibrate.motor import Strength

_NAMES = {"pins": Pins, "sensor": Sensor, "motor_map": MotorMap}


_KEYS = ", ".join(kit.key for kit in profiles.KITS)
OPTIONS = (
    option("device", help="a device's key or a port"),
    option("--kit", metavar="KEY", help=f"write a kit's default settings to the board: {_KEYS}"),
    option("--from", dest="file", metavar="TOML", help="write a calibration file to the board"),
    option("--label", metavar="NAME", help="the kit's name, 12 letters at most"),
    option(
        "--springs", nargs=2, type=float, metavar="N/m",
        help="measure the motor constant with two springs that are hooked to the handle in turn, and keep it",
    ),
    option(
        "--springs-known", type=float, default=3.0, metavar="%",
        help="tolerance of each spring's stiffness; 3",
    ),
    option("--write", action="store_true", help="write the calibration also to a file"),
)  # fmt: skip


def run(options: argparse.Namespace) -> Result:
    """Apply settings and measure the motor if requested; show the settings in use; save if requested."""
    wanted = _wanted(options)
    strength = None
    with contextlib.closing(board_named(options.device)) as board:
        board.open()
        settings = board.settings()
        if wanted is not None or options.label:
            chosen = wanted or profiles.of_settings(settings)
            label = calibration_file.checked_label(options.label) if options.label else chosen.label
            board.configure(replace(chosen, label=label))
            settings = board.save()
        if options.springs:
            strength = _strength(board, options.springs, 0.01 * options.springs_known)
            settings = board.save()
    notes = {"Strength": strength.text} if strength else {}
    written = str(calibration_file.write(profiles.of_settings(settings), notes)) if options.write else ""
    numbers = {f.name: getattr(settings, f.name) for f in Board.layout()}
    names = {name: kind(numbers[name]).name for name, kind in _NAMES.items()}
    found = {**numbers, **names, "origin": Origin(settings.origin).name, "written": written}
    more = {"strength": asdict(strength)} if strength else {}
    return Result("\n".join([*notes.values(), _text(settings, written)]), found | more)


def _wanted(options: argparse.Namespace) -> Board | None:
    """Return the settings to apply; raise ParameterError for incompatible options."""
    if options.kit and options.file:
        raise ParameterError("Name a kit or a file, not both.")
    if options.springs:
        from hapkit_studio.analysis.calibrate.motor import (
            check_springs,
        )  # imported here because the import takes a second

        check_springs(options.springs)
        check_number(options.springs_known, "springs' tolerance", "%", high=50.0)
    if options.kit:
        return profiles.named(options.kit).board
    return calibration_file.read(options.file) if options.file else None


def _strength(board: Any, springs: list[float], known: float) -> "Strength":
    """Measure the motor constant of an open board with springs in N/m, and apply it."""
    from hapkit_studio.analysis.calibrate.calibration import Calibration
    from hapkit_studio.analysis.calibrate.motor import HOOKED

    runner = BoardRunner(board)
    runner.read_settings()
    work = Calibration(runner)
    for stiffness in sorted(springs):
        if not board.simulated_hand:  # the program itself attaches the springs of a simulated board
            hook = f"Attach the spring of {stiffness:g} N/m {HOOKED}."
            print(f"{hook} Hands off, then press Enter.", end=" ", file=sys.stderr, flush=True)
            if sys.stdin is None or not sys.stdin.readline():
                raise ParameterError("A person must attach the springs: run this in a terminal.")
        if sys.stderr.isatty():
            print(f"Pulling at {stiffness:g} N/m …", file=sys.stderr)
        work.pull(stiffness)
    return work.use_springs(known)


def _text(settings: Settings, written: str) -> str:
    board = profiles.of_settings(settings)
    rows = [
        (calibration_file.setting_label(name), calibration_file.setting_text(board, name))
        for name in calibration_file.SHOWN
        if name != "table" or board.motor_map == MotorMap.TABLE
    ]
    rows.append(("Settings are", calibration_file.ORIGINS[Origin(settings.origin)]))
    lines = [f"{label:<34} {value}" for label, value in rows]
    return "\n".join(lines + ([f"wrote {written}"] if written else []))


COMMAND = Command(
    "calibrate",
    "show a board's calibration, put another on it, or measure its force with two springs",
    run,
    OPTIONS,
    96,
)

"""The command line: the window, headless runs, lists, and a test of the loop."""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from io import TextIOWrapper

from hapkit_studio import commands
from hapkit_studio.arguments import LineParser, window_parser
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.errors import StudioError

INTERRUPTED = 130
ESTIMATOR_HELP = f"{', '.join(ESTIMATORS)}; options as iir:cutoff=20"


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return the exit code: 2 for bad input, with one line that says what is wrong."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console without N·s/m shows N?s/m
    given = list(sys.argv[1:] if argv is None else argv)
    if not given or (given[0].startswith("-") and given[0] not in ("-h", "--help", "--version")):
        return _window(given)
    options = parser().parse_args(given)
    try:
        result = options.command(options)
        print(json.dumps(result.as_json, ensure_ascii=False) if options.json else result.text, flush=True)
    except StudioError as error:
        print(f"hapkit-studio: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"hapkit-studio: {error.filename or 'output'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of every command."""
    from hapkit_studio import __version__, commands_measure

    top = LineParser(
        prog="hapkit-studio",
        description="Virtual environments on a Hapkit, real or simulated. Without a command: the window.",
    )
    top.add_argument("--version", action="version", version=__version__)
    made = top.add_subparsers(required=True, metavar="COMMAND")
    _scene_options(_command(made, "run", commands.run, "render an environment headless"))
    listing = _command(
        made, "environments", commands.environments, "list the environments and their parameters"
    )
    listing.add_argument("--markdown", action="store_true", help="as a page with pictures and explanations")
    _command(made, "devices", commands.devices, "list the devices that can be chosen now")
    words = "compute what a scene's simulated device must model, and what each term costs"
    commands_measure.fidelity_options(_command(made, "fidelity", commands_measure.fidelity, words))
    test = _command(made, "loop-test", commands.loop_test, "run the real-time loop and measure it")
    test.add_argument("device", nargs="?", default="simulated", help="a device's key or a port")
    test.add_argument("--rate", type=float, default=1000.0, metavar="HZ")
    test.add_argument("--seconds", type=float, default=5.0, metavar="S")
    return top


def _command(made, name: str, function, words: str) -> argparse.ArgumentParser:
    command = made.add_parser(name, help=words, description=words.capitalize() + ".")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(command=function)
    return command


def _scene_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("environment", help="an environment's key, or a Python file: my_env.py")
    command.add_argument("--trust", action="store_true", help="execute a file that you have read")
    command.add_argument("-p", "--parameter", action="append", default=[], metavar="KEY=VALUE")
    command.add_argument(
        "--hand", metavar="SCRIPT", help="press, tap, stroke, …; without it the handle is free"
    )
    command.add_argument("--seconds", type=float, default=2.0, metavar="S")
    command.add_argument("--rate", type=float, default=1000.0, metavar="HZ")
    command.add_argument("--delay", type=float, default=0.0, metavar="S")
    command.add_argument("--estimator", default="difference", metavar="NAME", help=ESTIMATOR_HELP)
    command.add_argument("--seed", type=int, default=0)
    command.add_argument("--csv", metavar="PATH", help="write every sample")
    command.add_argument("--plot", metavar="PATH", help="write a picture")


def _window(given: Sequence[str]) -> int:
    options = window_parser().parse_args(given)  # bad options are said before anything starts
    if not _has_display():
        return _demo()
    from hapkit_studio.gui import prepare

    preparing = prepare.begin("loop", options.environment)  # compiles while Qt is still being loaded
    from hapkit_studio.gui import app

    return app.run(given, preparing)


def _has_display() -> bool:
    if sys.platform in ("win32", "darwin") or os.environ.get("QT_QPA_PLATFORM"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _demo() -> int:
    """Say that there is no display, render a hand pressing into the wall, write the picture."""
    print("No display here, so the window cannot open. Running the demo headless instead.")
    folder = "" if os.access(".", os.W_OK) else tempfile.mkdtemp(prefix="hapkit-studio-")
    try:
        print(commands.demo(os.path.join(folder, "hapkit-studio-demo.png")).text)
    except (StudioError, OSError) as error:
        print(f"hapkit-studio: {error}", file=sys.stderr)
        return 2
    return 0

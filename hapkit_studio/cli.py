"""The command line: the window, headless runs, lists, and a test of the loop."""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Sequence
from io import TextIOWrapper

from hapkit_studio.arguments import LineParser, window_parser
from hapkit_studio.errors import StudioError
from hapkit_studio.formatting import printable

INTERRUPTED = 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; return the exit code: 2 for bad input, with one line that says what is wrong."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console without N·s/m shows N?s/m
    given = list(sys.argv[1:] if argv is None else argv)
    if not given or (given[0].startswith("-") and given[0] not in ("-h", "--help", "--version")):
        return _window(given)
    options = parser().parse_args(given)
    from hapkit_studio.commands import base

    try:
        base.check_outputs(options)
        result = options.command(options)
        text = json.dumps(result.as_json, ensure_ascii=False) if options.json else result.text
        print(printable(text), flush=True)
    except StudioError as error:
        # the step that a window would offer, for the port that was named
        port = getattr(options, "port", None) or getattr(options, "device", None)
        step = f" Run `hapkit-studio flash {port}`." if port and getattr(error, "step", "") else ""
        print(printable(f"hapkit-studio: {error}{step}"), file=sys.stderr)
        return 2
    except OSError as error:
        print(printable(f"hapkit-studio: {error.filename or 'output'}: {error.strerror}"), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return INTERRUPTED
    return result.code


def parser() -> argparse.ArgumentParser:
    """Return the parser of every command."""
    from hapkit_studio import __version__, commands

    top = LineParser(
        prog="hapkit-studio",
        description="Virtual environments on a Hapkit, real or simulated. Without a command: the window.",
    )
    top.add_argument("--version", action="version", version=__version__)
    made = top.add_subparsers(required=True, metavar="COMMAND")
    for command in commands.discover().values():
        words, whole = command.help, command.help[0].upper() + command.help[1:] + "."
        taking = made.add_parser(
            command.name, aliases=command.aliases, help=words.replace("%", "%%"), description=whole
        )
        taking.add_argument("--json", action="store_true", help="print one JSON object")
        taking.set_defaults(command=command.run)
        for names, how in command.options:
            taking.add_argument(*names, **how)
    return top


def _window(given: Sequence[str]) -> int:
    options = window_parser().parse_args(given)  # bad options are said before anything starts
    qt = sys.platform in ("win32", "darwin") or os.environ.get("QT_QPA_PLATFORM")
    if not (qt or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return _demo()
    from hapkit_studio.gui import prepare

    first = options.environment or prepare.FIRST
    preparing = prepare.begin("loop", first)  # compiles while Qt is still being loaded
    from hapkit_studio.gui import app

    return app.run(given, preparing)


def _demo() -> int:
    """Say that there is no display, render a hand pressing into the wall, write the picture."""
    from hapkit_studio.commands.run import demo

    print("No display here, so the window cannot open. Running the demo headless instead.")
    folder = "" if os.access(".", os.W_OK) else tempfile.mkdtemp(prefix="hapkit-studio-")
    try:
        print(demo(os.path.join(folder, "hapkit-studio-demo.png")).text)
    except (StudioError, OSError) as error:
        print(f"hapkit-studio: {error}", file=sys.stderr)
        return 2
    return 0

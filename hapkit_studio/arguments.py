"""Command-line options: a parser with one-line error messages, and the window's options."""

import argparse
import re
import sys
from pathlib import Path
from typing import Any

from hapkit_studio.formatting import printable


class LineParser(argparse.ArgumentParser):
    """An argument parser with one-line error messages and exit code 2."""

    def __init__(self, *given: Any, **named: Any):
        super().__init__(*given, **named)
        # Python 3.14 has the same expression; older versions take -5e-3 for an option
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str):
        self.exit(2, printable(f"{self.prog}: {message}\n"))

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help, version or an error.

        Raise OSError if the output is closed; argparse would hide this error.
        """
        print(message or "", end="", file=file or sys.stderr, flush=True)


def window_parser() -> LineParser:
    """Return the parser of the window's options; those from --screenshot on are for developers.

    It does not depend on Qt, so that invalid options are reported even without a display.
    """
    parser = LineParser(prog="hapkit-studio", description="The studio's window.")
    parser.add_argument("--environment", help="environment at the start; by default the last one")
    parser.add_argument("--device", default="simulated", help="device at the start")
    parser.add_argument(
        "--demo",
        nargs="?",
        const="",
        metavar="NAME",
        help="play a demo or the demo in a file; without a name, the first",
    )
    parser.add_argument("--replay", type=Path, metavar="FILE", help="recorded session at the start")
    parser.add_argument("--lessons", type=Path, metavar="FOLDER", help="folder with your own lessons")
    parser.add_argument("--theme", choices=("system", "light", "dark", "contrast"), help="light or dark")
    parser.add_argument("--size", type=size, metavar="WxH", help="window size in pixels, e.g. 1280x720")
    parser.add_argument("--screenshot", metavar="PATH", help="save a picture of the window, then exit")
    parser.add_argument("--seconds", type=float, default=5.0, help="time before the picture")
    parser.add_argument("--push", type=float, metavar="mm", help="for the picture: push the handle to MM")
    return parser


def size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(f"a size has the form 1280x720, not {text!r}")
    return int(width), int(height)

"""The entry point of the command line: it opens the window or runs a command."""

import atexit
import gc
import os
import sys
from collections.abc import Sequence
from contextlib import suppress

from hapkit_studio import interrupts
from hapkit_studio.errors import StudioError

# Slow modules are imported in the functions below, after the handling of Ctrl+C has started.
TYPE_CHECKING = False
if TYPE_CHECKING:
    import argparse

    from hapkit_studio.commands.base import Result

FAILED = 2
SESSION_SUFFIX = ".hapkit"  # the same as in sessions.file, which is slow to import
_TEXTS_HELP = "print every text that the window can show and its place, for proofreading"
EXIT_SECONDS = 1.0
_NO_FOLDERS = (
    "The system does not know your home directory or your documents folder. "
    "Set HOME (on Windows USERPROFILE) to a folder of yours, then start again."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return the exit code; for invalid input, print one line and return 2.

    ``argv`` is None for the program itself, which exits within EXIT_SECONDS even if threads still run.
    """
    if argv is not None:
        return _run(argv)
    interrupts.begin()
    ends: list[int] = []
    atexit.register(_exit_now, ends)  # registered first, so that it is called last
    code = _run(sys.argv[1:])
    _flush()  # the forced exit discards unwritten output
    _end_soon(code)
    if "PySide6" not in sys.modules:
        ends.append(code)
    return code


def _run(given: Sequence[str]) -> int:
    """Open the window or run a command; return the exit code."""
    _prepare_streams()
    if not _has_folders():
        return fail(_NO_FOLDERS)
    try:
        return _window(given) if _is_for_window(given) else _command(given)
    except StudioError as error:
        return fail(str(error), error.exit_code)
    except BrokenPipeError:
        return fail("")  # the reader has closed the pipe
    except OSError as error:
        return fail(f"{error.filename or 'output'}: {error.strerror or error}")
    except KeyboardInterrupt:
        return interrupts.INTERRUPTED


def _has_folders() -> bool:
    """Return True if the system knows the user's folders, which may be missing or closed to the user."""
    import platformdirs

    try:
        for folder in ("config", "data", "cache", "documents"):
            getattr(platformdirs, f"user_{folder}_dir")()
    except (KeyError, RuntimeError, ValueError):  # different systems report this differently
        return False
    return os.path.expanduser("~") != "~"  # older versions of platformdirs leave "~" in the path


def _is_for_window(given: Sequence[str]) -> bool:
    """Return True if there is no command: no argument, a recorded session, or the window's options."""
    if not given or given[0].endswith(SESSION_SUFFIX):
        return True
    return given[0].startswith("-") and given[0] not in ("-h", "--help", "--version")


def _prepare_streams() -> None:
    from io import TextIOWrapper

    if sys.stderr is None:  # stderr is closed, and print would use stdout
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115, open as long as the program runs
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a console that lacks "·" shows "?"


def _command(given: Sequence[str]) -> int:
    import json

    from hapkit_studio.formatting import printable

    if sys.stdout is None:
        return fail("the output is closed.")
    options = parser().parse_args(given)
    from hapkit_studio.commands import base

    try:
        with interrupts.raised():
            interrupts.listen()
            base.check_outputs(options)
            result = options.command(options)
            # a code page lacks most characters; a replaced stream may have no encoding
            limited = (getattr(sys.stdout, "encoding", None) or "utf-8").lower() != "utf-8"
            text = json.dumps(result.as_json, ensure_ascii=limited) if options.json else result.text
            print(printable(text), flush=True)
    except StudioError as error:
        # add the next step for the port that was given on the command line
        port = getattr(options, "port", None) or getattr(options, "device", None)
        step = f" Run `hapkit-studio flash {port}`." if port and getattr(error, "step", "") else ""
        return fail(f"{error}{step}", error.exit_code)
    return result.code


def fail(text: str, code: int = FAILED) -> int:
    """Print an error line on stderr unless it is empty, and return the exit code."""
    from hapkit_studio.formatting import printable

    with suppress(OSError):
        print(f"hapkit-studio: {printable(text)}\n" if text else "", end="", file=sys.stderr)
    _flush()
    return code


def _flush() -> None:
    """Flush the outputs; if an output is closed or full, discard its data.

    Otherwise Python would try again at exit and print a traceback.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except OSError:
            with suppress(OSError, ValueError):  # a replaced output may not have a file
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _end_soon(code: int) -> None:
    """Exit within EXIT_SECONDS, because threads of a user's file may still run."""
    import threading

    timer = threading.Timer(EXIT_SECONDS, os._exit, (code,))
    timer.daemon = True
    timer.start()


def _exit_now(ends: Sequence[int]) -> None:
    """Exit at once if ``ends`` has an exit code, which Ctrl+C during Python's shutdown could change."""
    for code in ends:
        _flush()
        os._exit(code)


def parser() -> "argparse.ArgumentParser":
    """Return the parser of every command."""
    from hapkit_studio import __version__, commands
    from hapkit_studio.arguments import LineParser
    from hapkit_studio.commands import base

    top = LineParser(
        prog="hapkit-studio",
        description="Virtual environments on a Hapkit, real or simulated. Without a command: the window.",
    )
    top.add_argument("--version", action="version", version=__version__)
    made = top.add_subparsers(required=True, metavar="COMMAND", dest="called")
    for command in (*commands.discover().values(), base.Command("texts", _TEXTS_HELP, _texts)):
        text, whole = command.help, command.help[0].upper() + command.help[1:] + "."
        taking = made.add_parser(
            command.name, aliases=command.aliases, help=text.replace("%", "%%"), description=whole
        )
        taking.add_argument("--json", action="store_true", help="print one JSON object")
        taking.set_defaults(command=command.run)
        for names, how in command.options:
            taking.add_argument(*names, **how)
    return top


def _texts(_options: "argparse.Namespace") -> "Result":
    """List the texts of the window; the modules of ``commands`` must not import the window."""
    from hapkit_studio.commands.base import Result

    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    from hapkit_studio.gui.shell.texts import texts

    found = texts()
    lines = "\n".join(f"{place} | {text}" for place, text, _source in found)
    return Result(
        lines,
        {"texts": [{"place": place, "text": text, "source": source} for place, text, source in found]},
    )


def _window(given: Sequence[str]) -> int:
    from hapkit_studio.arguments import window_parser

    if given and given[0].endswith(SESSION_SUFFIX):  # the desktop opens a session in this way
        given = ["--replay", *given]
    options = window_parser().parse_args(given)  # invalid options are reported before any other work starts
    qt = sys.platform in ("win32", "darwin") or os.environ.get("QT_QPA_PLATFORM")
    if not (qt or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return _demo()
    gc.disable()  # garbage collection during the imports takes 0.1 s and frees nothing
    from hapkit_studio.gui.state import prepare

    first = options.environment or prepare.FIRST
    preparing = prepare.begin("loop", first)  # compile while Qt is being loaded
    from hapkit_studio.gui.shell import app

    return app.run(given, preparing)


def _demo() -> int:
    """Report that there is no display, simulate a hand that presses into the wall, and write the figure."""
    import tempfile

    from hapkit_studio.commands.run import demo

    print("There is no display, so the window cannot open. Running the demo headless instead.")
    with interrupts.raised():
        folder = "" if os.access(".", os.W_OK) else tempfile.mkdtemp(prefix="hapkit-studio-")
        print(demo(os.path.join(folder, "hapkit-studio-demo.png")).text, flush=True)
    return 0

"""The command line's way to a person's file: harmless, trusted or asked about, then tried out, then read."""

import contextlib
import sys
from pathlib import Path

from hapkit_studio.errors import LawError
from hapkit_studio.workshop import reading, trial, tried, trust, words
from hapkit_studio.workshop.own import OwnEnvironment

YES = ("y", "yes")


def environment(path: str, trusting: bool = False) -> OwnEnvironment:
    """Return the environment of a file; raise LawError, one line with the file's name and the line in it.

    A text that is neither trusted nor harmless by construction is shown first, and executed if a person at
    the terminal says so; trusting stands for having said so.
    """
    file = Path(path).expanduser().absolute()
    try:
        text = reading.text_of(file)
        _consent(text, file, trusting)
        _try(text, file)
        return reading.load_text(text, file)
    except LawError as error:
        where = f"{file.name}, line {error.line}" if error.line else file.name
        raise LawError(f"{where}: {words.plain(error)}") from None


def _consent(text: str, file: Path, trusting: bool) -> None:
    """Raise LawError unless a text may be executed."""
    if trust.is_trusted(text) or (not trusting and reading.is_harmless(text)):
        return
    if not trusting:
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise LawError(
                "not executed, as it does more than declare an environment: read it, then pass --trust"
            )
        print(trust.shown(text), file=sys.stderr)
        print(f"Execute {file.name} as it stands above? [y/N] ", end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() not in YES:
            raise LawError("not executed")
    with contextlib.suppress(OSError):  # where nothing can be remembered, the next run asks again
        trust.trust(text)


def _try(text: str, file: Path) -> None:
    """Raise LawError unless a text passes its trial, now or before."""
    if tried.has_passed(text, file):
        return
    for problem in trial.check(file, trust.digest(text)).problems:
        raise LawError(problem.text, problem.line)

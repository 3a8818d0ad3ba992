"""The command line's way to a person's file: agreed to or asked about, then tried out, then read."""

import contextlib
import sys
from pathlib import Path

from hapkit_studio.errors import LawError
from hapkit_studio.workshop import reading, trial, tried, trust, words
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.source import Source, read

YES = ("y", "yes")


def environment(path: str, trusting: bool = False) -> OwnEnvironment:
    """Return the environment of a file; raise LawError, one line with the file's name and the line in it.

    A file that nobody agreed to is shown first, and executed if a person at the terminal says so; trusting
    stands for having said so.
    """
    file = Path(path).expanduser().absolute()
    try:
        source = read(file)
        _consent(source, trusting)
        _try(source)
        return reading.load_source(source)
    except LawError as error:
        where = f"{file.name}, line {error.line}" if error.line else file.name
        raise LawError(f"{where}: {words.plain(error)}") from None


def _consent(source: Source, trusting: bool) -> None:
    """Raise LawError unless a file may be executed."""
    if trust.is_trusted(source):
        return
    if not trusting:
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise LawError("not executed, as nobody agreed to it yet: read it, then pass --trust")
        print(trust.shown(source.text), file=sys.stderr)
        question = f"Execute {source.path.name} as it stands above? [y/N] "
        print(question, end="", file=sys.stderr, flush=True)
        if sys.stdin.readline().strip().lower() not in YES:
            raise LawError("not executed")
    with contextlib.suppress(OSError):  # where nothing can be remembered, the next run asks again
        trust.trust(source)


def _try(source: Source) -> None:
    """Raise LawError unless a file passes its trial, now or before."""
    if tried.has_passed(source):
        return
    verdict = trial.check(source)
    tried.note(source, verdict.ok)
    for problem in verdict.problems:
        raise LawError(problem.text, problem.line)

"""What a command is: its words, what it takes, and what it does."""

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

QUIET_SECONDS = 1.0


@dataclass(frozen=True)
class Result:
    """A command's outcome: text for a person, one object for ``--json``; code: the exit code."""

    text: str
    as_json: dict
    code: int = 0


def _nothing(command: argparse.ArgumentParser) -> None:
    """Take no options but ``--json``."""


@dataclass(frozen=True)
class Command:
    """One command; ``options`` declares what it takes besides ``--json``, ``run`` does it."""

    name: str
    help: str
    run: Callable[[argparse.Namespace], Result]
    options: Callable[[argparse.ArgumentParser], None] = _nothing
    order: int = 100


def progress_line(what: str) -> Callable[[int, int], None]:
    """Return what writes one line that follows the work (done, of), on a terminal and once it takes long."""
    begin = time.monotonic()

    def say(done: int, of: int) -> None:
        if time.monotonic() - begin < QUIET_SECONDS or not sys.stderr.isatty():
            return
        last = done >= of
        line = f"{what}: {done} of {of}"
        print(f"\r{'' if last else line:<60}", end="\r" if last else "", file=sys.stderr, flush=True)

    return say

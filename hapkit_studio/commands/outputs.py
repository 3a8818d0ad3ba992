"""Files that a command is to write, looked at before it works: no hour of samples for a wrong path."""

import argparse
import os
from pathlib import Path

from hapkit_studio import figures
from hapkit_studio.errors import ParameterError

_OPTIONS = ("csv", "plot")
_PICTURE = ".png"


def check(options: argparse.Namespace) -> None:
    """Raise ParameterError where --csv or --plot cannot be written; a picture without an ending is a PNG."""
    for name in _OPTIONS:
        given = getattr(options, name, None)
        if given is None:
            continue
        _check(given, f"--{name}")
        if name == "plot":
            figures.check(given)
            setattr(options, name, given if Path(given).suffix else given + _PICTURE)


def _check(given: str, option: str) -> None:
    path = Path(given)
    if not given or path.is_dir():
        raise ParameterError(f"{option} takes the path of a file, not {given!r}.")
    if not path.parent.is_dir():
        raise ParameterError(f"{option}: there is no folder {path.parent}. Make it, or name another.")
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise ParameterError(f"{option}: you may not write {path}. Name another file.")

"""How late a recording's samples were: of a session, or of a table that was written from one."""

from contextlib import closing
from pathlib import Path

import numpy as np

from hapkit_studio import tables
from hapkit_studio.errors import FileError, ParameterError
from hapkit_studio.files import checked_number
from hapkit_studio.sessions.session import Session

_COLUMN = "lateness"
_MOST = 3600.0  # s


def recorded(path: str | Path) -> np.ndarray:
    """Return how late in s each sample of a session, or of a CSV with a column of lateness, was.

    Raise ParameterError; SessionError for a damaged session.
    """
    file = Path(path)
    if file.suffix.lower() == ".csv":
        found = _column(file)
    else:
        with closing(Session(file)) as session:
            found = session.read([_COLUMN])[_COLUMN]
    found = found[np.isfinite(found)]
    if not found.size:
        raise ParameterError(f"{file.name} says of no sample how late it was.")
    for extreme in (found.min(), found.max()):
        checked_number(float(extreme), f"{file.name}: lateness", -_MOST, _MOST, "s")
    return found


def _column(file: Path) -> np.ndarray:
    """Return the column of lateness of a CSV; raise FileError."""
    table = tables.read(file)
    name = next((name for name in table.names if name.startswith(_COLUMN)), None)
    if name is None:
        raise FileError(f"{table.file} has no column {_COLUMN}.")
    return table.values([name])[:, 0]

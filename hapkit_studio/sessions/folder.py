"""The folder that sessions are recorded into, and what a new one is called."""

import os
from datetime import datetime
from pathlib import Path

import platformdirs

from hapkit_studio.sessions.file import SUFFIX, SessionError
from hapkit_studio.workshop.folder import VARIABLE, plain_name


def folder() -> Path:
    """Return the folder of a person's sessions, which need not be there yet."""
    return Path(os.environ.get(VARIABLE) or platformdirs.user_documents_dir()) / "Hapkit sessions"


def files() -> list[Path]:
    """Return the sessions in the folder; none where there is no folder."""
    try:
        return [path for path in folder().glob(f"*{SUFFIX}") if path.is_file()]
    except OSError:
        return []


def new_path(environment: str) -> Path:
    """Return a path in the folder that no file has, of an environment's key, date and time.

    The folder is made where it is missing; raise SessionError.
    """
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SessionError(f"{place} cannot be made: {error.strerror}.") from None
    stem = name = f"{plain_name(environment)} {datetime.now():%Y-%m-%d %H.%M.%S}"
    number = 2
    while (path := place / f"{name}{SUFFIX}").exists():
        name, number = f"{stem} ({number})", number + 1
    return path

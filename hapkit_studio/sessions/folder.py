"""The folder for recorded sessions, which the user may change, and the names of the files in it."""

import os
import re
from contextlib import suppress
from datetime import datetime
from pathlib import Path

import platformdirs

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_text, read_text, replacing
from hapkit_studio.sessions.file import LOG, SUFFIX, SessionError
from hapkit_studio.workshop.folder import VARIABLE, plain_name

_LONGEST_PATH = 4_096  # maximum number of characters of a path
_LONGEST_NAME = 200  # maximum number of bytes of a name; file systems allow 255 bytes including suffixes
# Characters that Windows forbids; the file may also be opened on Windows.
_FORBIDDEN = re.compile(r'[<>:"/\\|?*]')


def folder() -> Path:
    """Return the folder for sessions; it may not exist yet."""
    with suppress(FileError):
        return chosen_folder() or usual_folder()
    return usual_folder()


def usual_folder() -> Path:
    """Return the default folder for sessions."""
    return Path(os.environ.get(VARIABLE) or platformdirs.user_documents_dir()) / "Hapkit sessions"


def chosen_folder() -> Path | None:
    """Return the folder that the user has chosen, or None; raise FileError if the choice cannot be read."""
    stored = choice_file()
    if not os.path.exists(stored):  # for a folder without access this is False, but Path.exists may raise
        return None
    text = checked_text(read_text(stored, 4 * _LONGEST_PATH).strip(), stored.name, _LONGEST_PATH)
    if not Path(text).is_absolute():
        raise FileError(f"{stored.name} is {text!r}; it must be the whole path of a folder.")
    return Path(text)


def choose_folder(path: Path) -> None:
    """Record into another folder from now on, and create it if it is missing.

    Raise SessionError if this is impossible.
    """
    chosen = path.expanduser().absolute()
    try:
        checked_text(str(chosen), "The folder", _LONGEST_PATH)
        chosen.mkdir(parents=True, exist_ok=True)
        if not os.access(chosen, os.W_OK | os.X_OK):
            raise SessionError(f"You have no permission to write into {chosen}: choose another folder.")
        stored = choice_file()
        if chosen == usual_folder():
            stored.unlink(missing_ok=True)
            return
        stored.parent.mkdir(parents=True, exist_ok=True)
        with replacing(stored) as part:
            part.write_text(str(chosen), encoding="utf-8")
    except OSError as error:
        raise SessionError(f"{chosen} cannot be chosen: {error.strerror}.") from None


def choice_file() -> Path:
    """Return the path of the file that stores the chosen folder."""
    base = os.environ.get(VARIABLE)
    root = Path(base) if base else Path(platformdirs.user_config_dir("hapkit-studio", appauthor=False))
    return root / "recording-folder.txt"


def files() -> list[Path]:
    """Return the sessions in the folder; if the folder is missing, return an empty list."""
    try:
        return [path for path in folder().glob(f"*{SUFFIX}") if path.is_file()]
    except OSError:
        return []


def new_path(environment: str) -> Path:
    """Return an unused path in the folder; its name contains an environment's key, date and time.

    Create the folder if it is missing; raise SessionError if this fails.
    """
    place = folder()
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SessionError(f"{place} cannot be created: {error.strerror}.") from None
    stem = name = f"{plain_name(environment)} {datetime.now():%Y-%m-%d %H.%M.%S}"
    number = 2
    while (path := place / f"{name}{SUFFIX}").exists():
        name, number = f"{stem} ({number})", number + 1
    return path


def rename(path: Path, name: str) -> Path:
    """Rename a session in its folder and return its path; ``name`` may be with or without the suffix.

    Raise SessionError if a file has that name, or the session is incomplete.
    """
    new = path.with_name(f"{_checked_name(name)}{SUFFIX}")
    if path.with_name(f"{path.name}{LOG}").exists():
        raise SessionError(
            f"{path.name} is incomplete and needs {path.name}{LOG}: save a copy instead of renaming it."
        )
    if new == path:
        return path
    try:
        path.stat()  # if the session is missing, raise before a file with the new name is created
        # the mode "x" creates the file only if it does not exist, so no file is ever replaced
        new.open("xb").close()
    except FileExistsError:
        raise SessionError(f"{new.name} exists already: choose another name.") from None
    except OSError as error:
        raise SessionError(f"{path.name} cannot be renamed: {error.strerror}.") from None
    try:
        path.replace(new)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise SessionError(f"{path.name} cannot be renamed: {error.strerror}.") from None
    return new


def _checked_name(name: str) -> str:
    """Return a file's name without its suffix; raise SessionError if an operating system forbids the name."""
    stem = name.strip().removesuffix(SUFFIX).strip()
    if not stem or stem[0] == "." or stem[-1] == "." or not stem.isprintable() or _FORBIDDEN.search(stem):
        raise SessionError(
            f'A name must not contain <>:"/\\|?* or begin or end with a period; choose a name other than '
            f"{stem!r}."
        )
    if len(os.fsencode(stem)) > _LONGEST_NAME:
        raise SessionError(f"A name must have at most {_LONGEST_NAME} bytes, not {len(os.fsencode(stem))}.")
    return stem

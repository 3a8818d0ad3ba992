"""The folder that sessions are recorded into, which a person may choose, and the names of files in it."""

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

_LONGEST_PATH = 4_096  # characters
_LONGEST_NAME = 200  # bytes; file systems take 255 with what is added
_FORBIDDEN = re.compile(r'[<>:"/\\|?*]')  # in names on Windows, from where a stick may come


def folder() -> Path:
    """Return the folder of a person's sessions, which need not be there yet."""
    with suppress(FileError):
        return chosen_folder() or usual_folder()
    return usual_folder()


def usual_folder() -> Path:
    """Return the folder of a person's sessions where none was chosen."""
    return Path(os.environ.get(VARIABLE) or platformdirs.user_documents_dir()) / "Hapkit sessions"


def chosen_folder() -> Path | None:
    """Return the folder that a person chose, None for none; raise FileError where that cannot be read."""
    stored = _choice()
    if not stored.exists():
        return None
    text = checked_text(read_text(stored, 4 * _LONGEST_PATH).strip(), stored.name, _LONGEST_PATH)
    if not Path(text).is_absolute():
        raise FileError(f"{stored.name} is {text!r}; it must be the whole path of a folder.")
    return Path(text)


def choose_folder(path: Path) -> None:
    """Record into another folder from now on, which is made where it is missing; raise SessionError."""
    chosen = path.expanduser().absolute()
    try:
        checked_text(str(chosen), "The folder", _LONGEST_PATH)
        chosen.mkdir(parents=True, exist_ok=True)
        if not os.access(chosen, os.W_OK | os.X_OK):
            raise SessionError(f"You may not write into {chosen}: choose another folder.")
        stored = _choice()
        if chosen == usual_folder():
            stored.unlink(missing_ok=True)
            return
        stored.parent.mkdir(parents=True, exist_ok=True)
        with replacing(stored) as part:
            part.write_text(str(chosen), encoding="utf-8")
    except OSError as error:
        raise SessionError(f"{chosen} cannot be chosen: {error.strerror}.") from None


def _choice() -> Path:
    """Return the file that holds the folder that was chosen."""
    base = os.environ.get(VARIABLE)
    root = Path(base) if base else Path(platformdirs.user_config_dir("hapkit-studio", appauthor=False))
    return root / "recording-folder.txt"


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


def rename(path: Path, name: str) -> Path:
    """Give a session another name in its folder, with or without its ending; return its path.

    Raise SessionError where a file has that name, or the session was not ended.
    """
    new = path.with_name(f"{_checked_name(name)}{SUFFIX}")
    if path.with_name(f"{path.name}{LOG}").exists():
        raise SessionError(
            f"{path.name} was not ended, and {path.name}{LOG} belongs to it: save a copy instead."
        )
    if new == path:
        return path
    try:
        path.stat()  # before a file is made that has the new name
        new.open("xb").close()  # so that a file which has it is never replaced
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
    """Return a file's name without its ending; raise SessionError where a system would not take it."""
    stem = name.strip().removesuffix(SUFFIX).strip()
    if not stem or stem[0] == "." or stem[-1] == "." or not stem.isprintable() or _FORBIDDEN.search(stem):
        raise SessionError(
            f'A name holds none of <>:"/\\|?* and has no point at its ends; it is not {stem!r}.'
        )
    if len(os.fsencode(stem)) > _LONGEST_NAME:
        raise SessionError(f"A name has at most {_LONGEST_NAME} bytes, not {len(os.fsencode(stem))}.")
    return stem

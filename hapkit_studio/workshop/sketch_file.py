"""Where a sketch is written: the Arduino IDE opens a file only in a folder of the same name."""

import re
from pathlib import Path

from hapkit_studio.errors import ParameterError

ENDING = ".ino"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,62}")


def place(wanted: str | Path) -> Path:
    """Return the path of the file, its folder included, for "wall", "wall.ino" or "wall/wall.ino".

    Raise ParameterError for a name that the Arduino IDE does not take.
    """
    path = Path(wanted).expanduser()
    if path.suffix and path.suffix != ENDING and not path.suffix[1:].isdigit():
        raise ParameterError(f"A sketch's name ends in {ENDING}, or has no ending: not {path.suffix!r}.")
    name = path.name.removesuffix(ENDING)
    if not _NAME.fullmatch(name):
        raise ParameterError(
            f"A sketch's name has letters, digits, _ and -, up to 63 of them: the IDE takes no {name!r}."
        )
    folder = path.parent if path.parent.resolve().name == name else path.parent / name
    return folder / f"{name}{ENDING}"


def write(wanted: str | Path, text: str, over: bool = False) -> Path:
    """Write a sketch and return its path; raise ParameterError where one is already there, OSError."""
    path = place(wanted)
    if path.exists() and not over:
        raise ParameterError(f"{path} is there already. Give another name, or --force to write over it.")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path

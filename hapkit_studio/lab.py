"""Settings that an administrator makes for all users of a lab's computer, in one read-only file."""

import functools
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import platformdirs

from hapkit_studio.errors import DeviceError, FileError
from hapkit_studio.files import checked_list, checked_number, checked_text, read_toml
from hapkit_studio.formatting import quoted

FILE = "lab.toml"
SIMULATED = "simulated"
"""Key of the simulated device; the file cannot exclude it, because it has no motor."""
_USUAL_ON_WINDOWS = r"C:\ProgramData\hapkit-studio"
_LONGEST = 4_096  # maximum number of characters of a path
_MOST_FORCE = 100.0  # N: maximum force limit, which exceeds that of every kit
# number of words in a lockable setting, by its first word
_LOCKABLE = {"environment": 2, "value": 3, "loop": 1, "grip": 1, "device": 1}


@dataclass(frozen=True)
class LabSettings:
    """The settings of a lab's computer; without a file, nothing is limited or locked.

    ``force_limit`` in N applies to every loop with a motor. ``devices`` are patterns of the keys of allowed
    devices; None allows all. ``lessons`` is a folder of lessons in addition to the studio's. ``locked`` are
    settings, as tuples of words, that cannot be unlocked with a code. ``mistake`` describes a mistake in the
    file, or is "".
    """

    force_limit: float = math.inf
    devices: tuple[str, ...] | None = None
    lessons: Path | None = None
    locked: frozenset[tuple[str, ...]] = frozenset()
    mistake: str = ""

    def allows(self, device: str) -> bool:
        """Return whether the device with a key may be used."""
        if self.devices is None or device == SIMULATED:
            return True
        return any(fnmatchcase(device, pattern) for pattern in self.devices)


def path() -> Path:
    """Return the path of the file: /etc/xdg/hapkit-studio/lab.toml on Linux, an equivalent path elsewhere."""
    try:
        folder = platformdirs.site_config_dir("hapkit-studio", appauthor=False)
    except (KeyError, ValueError):  # Windows does not know its folder: look where it usually is
        folder = _USUAL_ON_WINDOWS
    return Path(folder) / FILE


@functools.cache
def settings() -> LabSettings:
    """Return this computer's settings, which are read once.

    If the file has a mistake or cannot be read, no force and only the simulated device is allowed.
    """
    file = path()
    try:
        os.lstat(file)  # not exists(), which is false for a broken link and fails for a folder without access
        return read(file)
    except (FileNotFoundError, NotADirectoryError):
        return LabSettings()
    except OSError as error:
        return LabSettings(0.0, (), mistake=f"Cannot read {FILE}: {error.strerror}.")
    except FileError as error:
        return LabSettings(0.0, (), mistake=str(error))


def remedy() -> str:
    """Return what to do about a mistake in the file."""
    return f"The force stays zero. Correct {path()}, or ask the administrator; then start again."


def check() -> None:
    """Raise FileError if the file has a mistake."""
    if settings().mistake:
        raise FileError(f"{settings().mistake} {remedy()}")


def force_limit() -> float:
    """Return the force limit in N, or inf; raise DeviceError if the file has a mistake."""
    try:
        check()
    except FileError as error:  # the limit is unknown, so no force may be commanded
        raise DeviceError(str(error)) from None
    return settings().force_limit


def read(file: Path) -> LabSettings:
    """Return the settings in a file; raise FileError if the file is invalid."""
    table = read_toml(file)
    readers = {"force_limit": _force, "devices": _patterns, "lessons": _folder, "locked": _locked}
    for key in table:
        if key not in readers:
            raise FileError(f"{FILE}: there is no setting {quoted(key)}; available: {', '.join(readers)}.")
    found: Mapping[str, Any] = {key: readers[key](table[key], f"{FILE}: {key}") for key in table}
    return LabSettings(**found)


def _force(value: object, place: str) -> float:
    return checked_number(value, place, 0.1, _MOST_FORCE, "N")


def _texts(value: object, place: str) -> list[str]:
    return [checked_text(text, place, _LONGEST) for text in checked_list(value, place)]


def _patterns(value: object, place: str) -> tuple[str, ...]:
    return tuple(_texts(value, place))


def _folder(value: object, place: str) -> Path:
    folder = Path(checked_text(value, place, _LONGEST))
    if not folder.is_absolute():
        raise FileError(f"{place} is {quoted(str(folder))}; it must be the whole path of a folder.")
    return folder


def _locked(value: object, place: str) -> frozenset[tuple[str, ...]]:
    found = [tuple(text.split(".")) for text in _texts(value, place)]
    for parts in found:
        if len(parts) != _LOCKABLE.get(parts[0]):
            raise FileError(
                f'{place} contains {quoted(".".join(parts))}; it may contain "loop", "grip", "device", '
                '"environment.wall" and "value.wall.stiffness".'
            )
    return frozenset(found)

"""Where avrdude is on this computer: given, on the path, or inside the Arduino IDE; else how to get it."""

import os
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hapkit_studio.errors import AvrdudeMissingError

NAME = "avrdude"
_FOLDERS = {
    "linux": (
        "~/.arduino15/packages/arduino/tools/avrdude/*/bin",
        "~/snap/arduino/current/.arduino15/packages/arduino/tools/avrdude/*/bin",
        "/usr/share/arduino/hardware/tools/avr/bin",
        "/usr/local/share/arduino/hardware/tools/avr/bin",
        "/opt/arduino*/hardware/tools/avr/bin",
        "~/arduino*/hardware/tools/avr/bin",
    ),
    "darwin": (
        "/opt/homebrew/bin",
        "/usr/local/bin",
        "~/Library/Arduino15/packages/arduino/tools/avrdude/*/bin",
        "/Applications/Arduino.app/Contents/Java/hardware/tools/avr/bin",
    ),
    "win32": (
        "$LOCALAPPDATA/Arduino15/packages/arduino/tools/avrdude/*/bin",
        "$PROGRAMFILES/Arduino/hardware/tools/avr/bin",
        "$PROGRAMFILES(X86)/Arduino/hardware/tools/avr/bin",
    ),
}
"""Of the Arduino IDE 2 (under the user's own folder) and 1; on macOS also Homebrew's, off a window's path."""

_REMEDY = {
    "linux": "Run `sudo apt install avrdude` (Fedora: `sudo dnf install avrdude`)",
    "darwin": "Run `brew install avrdude`, or install the Arduino IDE and open it once",
    "win32": "Install the Arduino IDE and open it once, or run `winget install AVRDudes.AVRDUDE`",
}


@dataclass(frozen=True)
class Avrdude:
    """The program, and the list of chips that belongs to it where it would not find that by itself."""

    program: Path
    chips: Path | None = None

    @property
    def words(self) -> list[str]:
        """Return how the command line begins."""
        return [os.fspath(self.program), *([f"-C{self.chips}"] if self.chips else [])]


def find(given: str | Path | None = None, system: str = sys.platform) -> Avrdude:
    """Return the avrdude that was given, is on the path or in the Arduino IDE; raise AvrdudeMissingError."""
    if given is not None:
        found = shutil.which(os.path.expanduser(given))
        if found is None:
            raise AvrdudeMissingError(f"{given} is no program. Give the path of avrdude itself.")
        return _of(Path(found))
    on_path = shutil.which(NAME)
    if on_path is not None:
        return _of(Path(on_path))
    for folder in _folders(system):
        found = shutil.which(NAME, path=os.fspath(folder))
        if found is not None:
            return _of(Path(found))
    raise AvrdudeMissingError(explanation(system))


def explanation(system: str = sys.platform) -> str:
    """Return one line on what is missing and how to get it on this system."""
    remedy = _REMEDY.get(system, "Install avrdude")
    return f"avrdude, which writes to the board, was not found. {remedy}; or say where it is with --avrdude."


def _of(program: Path) -> Avrdude:
    # the Arduino IDE's avrdude was built for another place and looks for its chips there
    beside = program.resolve().parent.parent / "etc" / "avrdude.conf"
    return Avrdude(program, beside if beside.is_file() else None)


def _folders(system: str) -> Iterator[Path]:
    """Yield the folders there are, of each pattern the newest version first."""
    for pattern in _FOLDERS.get(system, ()):
        whole = Path(os.path.expandvars(os.path.expanduser(pattern)))
        anchor = Path(whole.anchor)
        if "*" in pattern:
            yield from sorted(anchor.glob(os.fspath(whole.relative_to(anchor))), key=_version, reverse=True)
        elif whole.is_dir():
            yield whole


def _version(folder: Path) -> list[tuple[int, ...]]:
    """Return the numbers in a path, so that 6.10 is newer than 6.3."""
    digits = "".join(c if c.isdigit() else " " for c in os.fspath(folder))
    return [tuple(int(n) for n in digits.split())]

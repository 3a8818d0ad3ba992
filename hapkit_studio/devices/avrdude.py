"""Find avrdude on this computer; parse the output of versions 6 to 8 into progress and errors."""

import glob
import os
import re
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from hapkit_studio.devices import port_errors
from hapkit_studio.errors import AvrdudeMissingError, DeviceError, FlashError, PortGoneError
from hapkit_studio.program import AVRDUDE

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
        "%PROGRAMFILES(X86)%/Arduino/hardware/tools/avr/bin",
    ),
}
"""Folders of the Arduino IDE 2 (in the user's home) and 1; on macOS also those of Homebrew."""

_REMEDY = {
    "linux": "Run `sudo apt install avrdude` (Fedora: `sudo dnf install avrdude`)",
    "darwin": "Run `brew install avrdude`, or install the Arduino IDE and open it once",
    "win32": "Install the Arduino IDE and open it once, or run `winget install AVRDudes.AVRDUDE`",
}


@dataclass(frozen=True)
class Avrdude:
    """The path of avrdude, and the path of its list of chips if avrdude cannot find this list itself."""

    program: Path
    chips: Path | None = None

    @property
    def command(self) -> list[str]:
        """Return the first words of the command line."""
        return [os.fspath(self.program), *([f"-C{self.chips}"] if self.chips else [])]


def find(given: str | Path | None = None, system: str = sys.platform) -> Avrdude:
    """Return the given avrdude, or one on the PATH or in the Arduino IDE; else raise AvrdudeMissingError."""
    if given is not None:
        found = shutil.which(os.path.expanduser(given))
        if found is None:
            raise AvrdudeMissingError(
                f"{given} is not a program. Enter the path of avrdude, the program that writes the firmware."
            )
        return _avrdude(Path(found))
    folders: list[str | None] = [None]  # None means the PATH
    for pattern in _FOLDERS.get(system, ()):
        versions = glob.glob(os.path.expandvars(os.path.expanduser(pattern)))
        # sort by version numbers, the newest first: 6.10 is newer than 6.3
        versions.sort(key=lambda path: [int(n) for n in re.findall(r"\d+", path)], reverse=True)
        folders += versions
    folders.append(os.fspath(AVRDUDE))
    for folder in folders:
        found = shutil.which(NAME, path=folder)
        if found is not None:
            return _avrdude(Path(found))
    remedy = _REMEDY.get(system, "Install avrdude")
    raise AvrdudeMissingError(
        f"avrdude, which writes to the board, was not found. {remedy}; or give its path with --avrdude."
    )


def _avrdude(program: Path) -> Avrdude:
    # pass the list of chips: the Arduino IDE's avrdude looks for it in the folder of its build
    beside = program.resolve().parent.parent / "etc" / "avrdude.conf"
    return Avrdude(program, beside if beside.is_file() else None)


CONNECTING, WRITING, VERIFYING = "connecting", "writing", "verifying"
Progress = Callable[[str, float], object]
"""A callback ``(stage, fraction)`` for the progress of each stage; an exception from it ends the flashing."""

_BAR = 50
_AGAIN = "Flash again; if it happens again, use another cable or another port."
_NO_SYNC = re.compile(r"not in sync|not responding|out of sync|protocol error")
_ATTEMPT = re.compile(r"attempt \d+ of")
_MISMATCH = re.compile(r"verification (error|mismatch)", re.IGNORECASE)
_WHERE = re.compile(r"device (0x\w+) != input (0x\w+) at addr (0x\w+)|mismatch at byte (0x\w+)")
_SIGNATURE = re.compile(r"signature = (0x)?((?:[0-9a-f]{2} ?){3})", re.IGNORECASE)
_OTHER_CHIP = re.compile(r"expected signature|invalid device signature", re.IGNORECASE)
_ANY_ERROR = re.compile(
    r"^avrdude(?: OS)? error: (.*)|^(?:avrdude|error): (.*(?:fail|can't|cannot).*)", re.I | re.M
)


def not_there(port: str) -> PortGoneError:
    """Return the error for a port that does not exist."""
    return PortGoneError(
        f"{port_errors.port_name(port)} does not exist. Plug the board in, then flash again."
    )


_PORT = (
    (re.compile(r"permission denied", re.IGNORECASE), port_errors.forbidden),
    (re.compile(r"resource busy|access is denied", re.IGNORECASE), port_errors.busy),
    (re.compile(r"no such (file|device)|cannot find the file", re.IGNORECASE), not_there),
)


class Output:
    """The output of avrdude so far; ``feed`` reports progress."""

    def __init__(self, progress: Progress):
        self.text = ""
        self.stage, self.part = CONNECTING, 0.0
        self._progress = progress

    def feed(self, text: str) -> None:
        """Process more output; with an empty text, report progress again, so that the callback can abort."""
        self.text += text
        stage, part = self._where()
        if text and (stage, part) == (self.stage, self.part):
            return
        if self.stage == WRITING and stage == VERIFYING and self.part < 1.0:
            self._progress(WRITING, 1.0)  # one chunk contained the end of writing and the start of verifying
        self.stage, self.part = stage, part
        self._progress(stage, part)

    @property
    def failed(self) -> bool:
        """Return True if at least one attempt to reach the boot loader failed."""
        return bool(_ATTEMPT.search(self.text))

    @property
    def no_sync(self) -> bool:
        """Return True if the boot loader has sent nothing, or only noise."""
        found = _NO_SYNC.search(self.text) and not _OTHER_CHIP.search(self.text)
        return self.stage == CONNECTING and bool(found)

    def _where(self) -> tuple[str, float]:
        writing = self.text.rfind("Writing |")
        if writing < 0:
            return CONNECTING, 0.0
        verifying = self.text.rfind("Reading |")
        stage, start = (VERIFYING, verifying) if verifying > writing else (WRITING, writing)
        bar = self.text[start:].split("|")[1]
        return stage, min(bar.count("#") / _BAR, 1.0)

    def error(self, port: str) -> DeviceError:
        """Return the error that the output shows, with its remedy."""
        name = port_errors.port_name(port)
        if _MISMATCH.search(self.text):
            where = ""
            if found := _WHERE.search(self.text):
                device, wanted, address, only = found.groups()
                where = f" from {only} on" if only else f": {device} instead of {wanted} at {address}"
            return FlashError(f"The verification of the written firmware failed{where}. {_AGAIN}")
        if _OTHER_CHIP.search(self.text):
            found = _SIGNATURE.search(self.text)
            seen = f" (signature {found[2].strip()})" if found else ""
            return FlashError(
                f"The board on {name} has a different chip{seen}; the firmware needs an ATmega328P (1e950f). "
                "Choose the Hapkit's port."
            )
        if self.stage == CONNECTING:
            for pattern, text in _PORT:
                if pattern.search(self.text):
                    return text(port)
        errors = [text.strip().rstrip(".") for pair in _ANY_ERROR.findall(self.text) for text in pair if text]
        return FlashError(f"avrdude failed on {': '.join([name, *errors[-1:]])}. {_AGAIN}")


def no_boot_loader(port: str, speeds: tuple[int, ...]) -> FlashError:
    """Return the error for a board whose boot loader answers at none of the baud rates."""
    tried, name = " or ".join(f"{speed:,}" for speed in speeds), port_errors.port_name(port)
    return FlashError(
        f"The boot loader on {name} does not answer at {tried} baud. Unplug the board, plug it in, then "
        "flash again. If the chip has no boot loader yet, write one (Arduino IDE: Tools, Burn Bootloader)."
    )

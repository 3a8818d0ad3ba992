"""Which program holds a port, where the system tells: Linux shows what one's own programs have open."""

import os
from pathlib import Path

PROCESSES = Path("/proc")
LOCKS = Path("/var/lock")
STUDIO = "Hapkit Studio"
"""What a person calls the studio, whose process is a python."""


def holder(port: str) -> str:
    """Return the name and number of another program that has a port open; nothing where nobody can tell."""
    real, own = os.path.realpath(port), str(os.getpid())
    for process in _processes():
        if process.name != own and any(_leads_to(file, real) for file in _files(process)):
            return _words(process)
    locked = _locked(port)
    return _words(locked) if locked is not None and locked.name != own else ""


def _processes() -> list[Path]:
    try:
        return [entry for entry in PROCESSES.iterdir() if entry.name.isdigit()]
    except OSError:
        return []


def _files(process: Path) -> list[Path]:
    """Return what a process has open; nothing for another user's."""
    try:
        return list((process / "fd").iterdir())
    except OSError:
        return []


def _leads_to(file: Path, real: str) -> bool:
    try:
        return os.readlink(file) == real
    except OSError:
        return False


def _locked(port: str) -> Path | None:
    """Return the living process that a lock file names: terminal programs of old write one."""
    try:
        words = (LOCKS / f"LCK..{Path(port).name}").read_text().split()
    except (OSError, UnicodeDecodeError):
        return None
    process = PROCESSES / words[0] if words and words[0].isdigit() else None
    return process if process is not None and process.is_dir() else None


def _is_studio(word: str) -> bool:
    """Tell whether a word of a command line starts the studio: ``-m hapkit_studio``, or its own program."""
    return word == "hapkit_studio" or Path(word).name in ("hapkit-studio", "hapkit-studio.exe")


def _words(process: Path) -> str:
    """Return what a program calls itself, without its folder, and its number."""
    try:
        line = (process / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
        name = Path(line[0]).name or (process / "comm").read_text().strip()
        name = STUDIO if any(map(_is_studio, line)) else name
    except OSError:
        name = "a program"
    return f"{name} (process {process.name})"

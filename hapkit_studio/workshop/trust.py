"""Which texts may be executed: those saved here, and those a person has read and agreed to."""

import hashlib
from pathlib import Path

import platformdirs


def digest(text: str) -> str:
    """Return what a text is known by; how its lines end makes no difference."""
    lines = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    return hashlib.sha256(lines.encode("utf-8", "surrogatepass")).hexdigest()


def is_trusted(text: str) -> bool:
    """Say whether exactly this text was trusted before."""
    try:
        return digest(text) in _list().read_text(encoding="ascii").split()
    except (OSError, ValueError):
        return False


def trust(text: str) -> None:
    """Remember that this text may be executed; raise OSError."""
    if is_trusted(text):
        return
    file = _list()
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "a", encoding="ascii") as known:
        known.write(digest(text) + "\n")


def shown(text: str) -> str:
    """Return a text as it is shown to be judged: what is invisible, or turns letters round, as its code."""
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


def _list() -> Path:
    return Path(platformdirs.user_data_dir("hapkit-studio", appauthor=False)) / "trusted"

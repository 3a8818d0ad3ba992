"""Which files may be executed, by the hash of their bytes: saved here, or agreed to by a person."""

from pathlib import Path

import platformdirs

from hapkit_studio.workshop.source import Source


def is_trusted(source: Source) -> bool:
    """Say whether a person agreed to exactly this file before."""
    try:
        return source.digest in _list().read_text(encoding="ascii").split()
    except (OSError, ValueError):
        return False


def trust(source: Source) -> None:
    """Remember that this file may be executed; raise OSError."""
    if is_trusted(source):
        return
    file = _list()
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "a", encoding="ascii") as known:
        known.write(source.digest + "\n")


def shown(text: str) -> str:
    """Return a text as it is shown to be judged: what is invisible, or turns letters round, as its code."""
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


def _list() -> Path:
    return Path(platformdirs.user_data_dir("hapkit-studio", appauthor=False)) / "trusted"

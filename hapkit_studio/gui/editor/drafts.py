"""What was typed and not saved yet, kept beside its file: neither a crash nor closing the window loses it."""

from pathlib import Path


def _place(path: Path) -> Path:
    return path.with_name(path.name + ".draft")


def keep(path: Path, text: str) -> None:
    """Write a file's draft; on a full or read-only disk there is none."""
    try:
        _place(path).write_text(text, encoding="utf-8")
    except OSError:
        drop(path)


def kept(path: Path) -> str | None:
    """Return a file's draft, None where there is none."""
    try:
        return _place(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None


def drop(path: Path) -> None:
    """Forget a file's draft."""
    try:
        _place(path).unlink(missing_ok=True)
    except OSError:
        return

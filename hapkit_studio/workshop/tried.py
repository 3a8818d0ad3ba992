"""How texts fared in their trial here: a record for each file, with a mark for each of its last versions."""

import contextlib
import hashlib
import os
import sys
import time
from pathlib import Path

import platformdirs

import hapkit_studio
from hapkit_studio.laws.native import KEPT_SECONDS
from hapkit_studio.workshop.source import Source

# how many versions of a file are known: going back to one of them needs no trial
KEPT = 10
_FAILED = "!"


def has_passed(source: Source) -> bool:
    """Say whether this text of a file passed its trial with this studio, this Python and this cache."""
    return _mark(source) in _marks(_record(source.path))


def has_failed(source: Source) -> bool:
    """Say whether this text of a file failed its last trial, in the same surroundings."""
    return _FAILED + _mark(source) in _marks(_record(source.path))


def note(source: Source, passed: bool) -> None:
    """Remember how a trial ended; where nothing can be written, it is tried again another time."""
    record, mark = _record(source.path), _mark(source)
    marks = [m for m in _marks(record) if m.removeprefix(_FAILED) != mark]
    marks.append(mark if passed else _FAILED + mark)
    with contextlib.suppress(OSError):
        record.parent.mkdir(parents=True, exist_ok=True)
        part = record.with_suffix(f".{os.getpid()}.part")
        part.write_text("\n".join(marks[-KEPT:]), encoding="ascii")
        part.replace(record)
        _forget_unused(record.parent)


def _forget_unused(folder: Path) -> None:
    """Remove the records of files that passed no trial for as long as a compiled law is kept."""
    for record in folder.glob("*"):
        if time.time() - record.stat().st_mtime > KEPT_SECONDS:
            record.unlink(missing_ok=True)


def _marks(record: Path) -> list[str]:
    try:
        return record.read_text(encoding="ascii").split()
    except (OSError, ValueError):
        return []


def _mark(source: Source) -> str:
    where = os.environ.get("NUMBA_CACHE_DIR", "")
    return _hashed(source.digest, sys.version, sys.prefix, hapkit_studio.__version__, where)


def _record(file: Path) -> Path:
    folder = Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / "tried"
    return folder / f"{_hashed(str(file.absolute()))}.txt"


def _hashed(*facts: str) -> str:
    return hashlib.sha256("\n".join(facts).encode("utf-8", "surrogatepass")).hexdigest()[:20]

"""Which texts passed their trial here, and which compiled laws they left in the cache.

One small record for each file: its path, then a line for each of its last versions: its mark, its law's name.
"""

import contextlib
import hashlib
import os
import sys
from pathlib import Path

import platformdirs

import hapkit_studio
from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.workshop import trust

# how many versions keep their compiled law: going back to one of them costs no compiling
KEPT = 10
Versions = dict[str, str]


def has_passed(text: str, file: Path) -> bool:
    """Say whether this text of a file passed its trial with this studio, this Python and this cache."""
    return _mark(text) in _read(_record(file))[1]


def passed(text: str, file: Path, environment: Environment) -> None:
    """Remember that a text passed; clear away the laws of versions long before and of files that are gone."""
    law = Path(str(getattr(environment.force.compiled().keepalive, "__file__", "")))
    with contextlib.suppress(OSError):
        record = _record(file)
        versions = _read(record)[1]
        versions.pop(_mark(text), None)
        versions[_mark(text)] = law.stem
        before = set(versions.values())
        _write(record, file, dict(list(versions.items())[-KEPT:]))
        _clear(law.parent, before | _forget_files_gone())


def _forget_files_gone() -> set[str]:
    """Remove the records of files that are no more; return the laws they had."""
    laws: set[str] = set()
    for record in _folder().glob("*.txt"):
        file, versions = _read(record)
        if not Path(file).exists():
            laws |= set(versions.values())
            record.unlink(missing_ok=True)
    return laws


def _clear(folder: Path, laws: set[str]) -> None:
    """Remove those laws and their machine code that no record and no environment of the library needs."""
    for record in _folder().glob("*.txt"):
        laws -= set(_read(record)[1].values())
    if laws:
        laws -= {_law_name(e) for e in environments.discover().values()}
    for law in laws:
        for place in (folder, folder / "__pycache__", *folder.parent.glob(f"{folder.name}_*/")):
            for old in place.glob(f"{law}.*"):
                old.unlink(missing_ok=True)


def _read(record: Path) -> tuple[str, Versions]:
    """Return a record's path and versions, the newest last; none where it cannot be read."""
    try:
        file, *lines = record.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
        return file, dict(line.split(" ") for line in lines)
    except (OSError, ValueError):
        return "", {}


def _write(record: Path, file: Path, versions: Versions) -> None:
    record.parent.mkdir(parents=True, exist_ok=True)
    part = record.with_suffix(f".{os.getpid()}.part")
    lines = [str(file.absolute()), *(f"{mark} {law}" for mark, law in versions.items())]
    part.write_text("\n".join(lines) + "\n", encoding="utf-8", errors="surrogateescape")
    part.replace(record)


def _law_name(environment: Environment) -> str:
    return "law_" + hashlib.sha256(environment.force.source.encode()).hexdigest()[:20]


def _mark(text: str) -> str:
    where = os.environ.get("NUMBA_CACHE_DIR", "")
    return _hashed(trust.digest(text), sys.version, sys.prefix, hapkit_studio.__version__, where)


def _record(file: Path) -> Path:
    return _folder() / f"{_hashed(str(file.absolute()))}.txt"


def _folder() -> Path:
    return Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / "own"


def _hashed(*facts: str) -> str:
    return hashlib.sha256("\n".join(facts).encode("utf-8", "surrogatepass")).hexdigest()[:20]

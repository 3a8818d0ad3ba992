"""Paths of the files that the studio contains, both in a checkout and in a wheel."""

import hashlib
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent


def path(*parts: str) -> Path:
    """Return the path of a shipped file, for example ``path("icons", "wall.svg")``."""
    inside = PACKAGE / "assets"
    root = inside if inside.is_dir() else PACKAGE.parent / "assets"
    return root.joinpath(*parts)


def sources_stamp(*folders: str, package: Path = PACKAGE) -> str:
    """Return a hash of the names and modification times of the Python files in folders of the package."""
    found = [f for folder in folders for f in sorted((package / folder).rglob("*.py"))]
    facts = "\n".join(f"{f}:{f.stat().st_mtime_ns}" for f in found)
    return hashlib.sha256(facts.encode()).hexdigest()[:16]

"""Mutations of the code that the tests must detect; this proves that shortened tests still work.

python -m tests.mutations --area laws    # tries each of tests/mutations.json in a copy of the project

A mutation changes one line, which is found by its text, so code may move. It is not part of `make test`: most
mutations start without compiled code, and all together take an hour.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = Path(__file__).with_name("mutations.json")
SECONDS = 400
"""A test that takes longer than this time in s counts as failed."""
INTERPRETED = ("codec", "window")
"""Areas without compiled code, whose mutations share a cache."""


@dataclass(frozen=True)
class Mutation:
    """A line of a file in the package, its replacement, and the tests that must fail with it."""

    area: str
    path: str
    before: str
    after: str
    tests: list[str]


def listed() -> list[Mutation]:
    """Return the mutations of the list."""
    return [Mutation(**given) for given in json.loads(LIST.read_text(encoding="utf-8"))]


def placed(mutation: Mutation, root: Path) -> tuple[Path, str]:
    """Return the mutated file in a copy of the project, and its new text; the old line must be unique."""
    own = root / "hapkit_studio" / mutation.path
    for files in ([own] if own.exists() else [], sorted((root / "hapkit_studio").rglob("*.py"))):
        found = []
        for file in files:
            lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
            found += [(file, lines, i) for i, line in enumerate(lines) if line.strip() == mutation.before]
        if len(found) == 1:
            file, lines, i = found[0]
            lines[i] = lines[i].replace(mutation.before, mutation.after)
            return file, "".join(lines)
    raise LookupError(
        f"{mutation.path}: {mutation.before!r} does not stand once any more. Mutate what stands for it."
    )


def fails(root: Path, mutation: Mutation) -> bool:
    """Return True if a mutation's tests fail in a copy of the project."""
    with tempfile.TemporaryDirectory() as fresh:
        cache = str(root / "cache") if mutation.area in INTERPRETED else fresh
        command = [sys.executable, "-m", "pytest", "-qx", "-p", "no:cacheprovider", *mutation.tests]
        command += ["-m", "not alone"]
        around = os.environ | {"NUMBA_CACHE_DIR": cache, "QT_QPA_PLATFORM": "offscreen"}
        around |= {"PYTHONPATH": str(root)}
        try:
            done = subprocess.run(command, cwd=root, env=around, capture_output=True, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            return True
    return done.returncode == 1


def caught(mutation: Mutation, root: Path) -> bool:
    """Return True if the tests fail with a mutation in a copy of the project."""
    file, text = placed(mutation, root)
    was = file.read_text(encoding="utf-8")
    file.write_text(text, encoding="utf-8")
    try:
        return fails(root, mutation)
    finally:
        file.write_text(was, encoding="utf-8")


def copied(folder: str) -> Path:
    """Copy the files under version control, and the built firmware."""
    root = Path(folder) / "project"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(root)], check=True)
    if (ROOT / "firmware" / "build").is_dir():
        shutil.copytree(ROOT / "firmware" / "build", root / "firmware" / "build", symlinks=True)
    return root


def check(chosen: list[Mutation]) -> int:
    """Try every mutation; return the number of undetected ones."""
    lost = 0
    with tempfile.TemporaryDirectory() as folder:
        root = copied(folder)
        for mutation in chosen:
            found = caught(mutation, root)
            lost += not found
            print(f"{'caught' if found else 'LOST'}: {mutation.path}: {mutation.after}", flush=True)
    return lost


def main() -> int:
    """Return the number of undetected mutations of the list, or of an area."""
    known = listed()
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--area", choices=sorted({mutation.area for mutation in known}))
    area = parser.parse_args().area
    return check([mutation for mutation in known if area in (None, mutation.area)])


if __name__ == "__main__":
    sys.exit(main())

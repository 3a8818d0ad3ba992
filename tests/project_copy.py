"""Run programs and pytest in a copy of the project with one added file.

This shows that an extension needs no other change.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
_PARTS = "hapkit_studio", "tests", "assets", "firmware"


def copy_with(folder: Path, path: str, text: str) -> Path:
    """Copy the project to a folder and add a file there by its path in the project; return the folder."""
    left = shutil.ignore_patterns("__pycache__", "build", ".*")
    for name in _PARTS:
        shutil.copytree(ROOT / name, folder / name, ignore=left)
    shutil.copy(ROOT / "pyproject.toml", folder)
    if (ROOT / "firmware" / "build").is_dir():
        (folder / "firmware" / "build").symlink_to(ROOT / "firmware" / "build")
    (folder / path).write_text(text, encoding="utf-8")
    return folder


def run_program(folder: Path, *args: str) -> str:
    """Run Python with these arguments in a copy of the project.

    Return its output, or fail with its last lines.
    """
    around = os.environ | {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
    program = [sys.executable, *args]
    done = subprocess.run(program, cwd=folder, env=around, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    return done.stdout


def run_tests(folder: Path, *args: str) -> str:
    """Run pytest in a copy of the project; return its output, or fail with its last lines."""
    return run_program(folder, "-m", "pytest", "-v", "-p", "no:cacheprovider", *args)

"""Rules of the whole repository that no tool checks: each module has a layer, no text is machine-specific."""

import os
import re
import tomllib
from pathlib import Path

import pytest

from tests import mutations

ROOT = Path(__file__).resolve().parent.parent
# names of folders that are not searched
SKIPPED = {".venv", ".git", "build", "dist", "__pycache__", "bench-results", ".hypothesis", "corpus"}
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
TEXT = {".py", ".md", ".toml", ".c", ".h", ".cpp", ".ino", ".sh", ".qss", ".svg", ""}
# the patterns are split, so that this file does not match them
NOT_IN_ANY_FILE = {
    "a path of one machine": r"/(wo" r"rk|ro" r"ot|ho" r"me)/\w",
    "a registry's host": r"(py" r"pi|debi" r"an|anac" r"onda)\.(org|com|net)",
    "a note to oneself": r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b",
    "a ticket": r"\b(iss" r"ue|tick" r"et) #?\d",
}


def files(*suffixes):
    """Return the repository's own files, sorted; all text files by default."""
    found = []
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in SKIPPED and not name.endswith("_cache")]
        found += [Path(folder, name) for name in names]
    return sorted(path for path in found if path.suffix in (suffixes or TEXT) and path.is_file())


def lines(path):
    return path.read_text(encoding="utf-8").splitlines()


@pytest.mark.slow
@pytest.mark.parametrize("what", NOT_IN_ANY_FILE)
def test_no_machine_specific_text(what):
    pattern = re.compile(NOT_IN_ANY_FILE[what])
    hits = [
        f"{path.relative_to(ROOT)}:{number}"
        for path in files()
        for number, line in enumerate(lines(path), 1)
        if pattern.search(line)
    ]
    assert hits == []


def test_every_module_has_its_layer():
    layers = PROJECT["tool"]["importlinter"]["contracts"][0]["layers"]
    named = {name.strip().split(".")[-1] for layer in layers for name in layer.split("|")}
    package = ROOT / "hapkit_studio"
    modules = {path.stem for path in package.glob("*.py")} | {
        path.name for path in package.iterdir() if path.is_dir() and any(path.glob("*.py"))
    }
    assert modules - {"__init__"} <= named


def test_ci_runs_the_readmes_command_and_the_slow_tests():
    script = [line for line in lines(ROOT / ".ci" / "run") if line and not line.startswith("#")]
    assert script == ["set -euo pipefail", 'cd "$(dirname "${BASH_SOURCE[0]}")/.."', "exec make test-all"]
    assert os.access(ROOT / ".ci" / "run", os.X_OK)
    assert "test-all: test" in lines(ROOT / "Makefile")  # test-all starts with the command in the README
    first_screen = "\n".join(lines(ROOT / "README.md")[:40])
    assert "make run" in first_screen
    assert "make test" in first_screen


def test_defective_pyside_is_excluded_below_python_3_12():
    pins = [text for text in PROJECT["project"]["dependencies"] if text.startswith("PySide6")]
    below = [text for text in pins if "python_version < '3.12'" in text]
    assert len(below) == 1
    assert "<6.12;" in below[0]


def test_virtual_board_carries_its_own_licence():
    sources = files(".c", ".h")
    board = [path for path in sources if path.is_relative_to(ROOT / "firmware" / "virtual_board")]
    assert board
    assert [p.name for p in board if "GPL-3.0-or-later" not in "\n".join(lines(p)[:5])] == []


def test_every_mutation_of_the_list_can_still_be_made():
    """A changed line, or a moved test file, would make a mutation useless."""
    for mutation in mutations.listed():
        assert mutations.placed(mutation, ROOT)[1]
        assert [test for test in mutation.tests if not (ROOT / test.partition("::")[0]).is_file()] == []

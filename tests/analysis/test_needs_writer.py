"""Writing needs into a scene's file: one line, the same twice, as the formatter would have it."""

import ast
import difflib
import subprocess
import sys
from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.analysis import needs_writer
from hapkit_studio.analysis.needs_writer import edited
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.errors import ParameterError
from hapkit_studio.laws import law

LIBRARY = environments.discover()


def source(key):
    return needs_writer.file_of(LIBRARY[key]).read_text(encoding="utf-8")


def declared(text):
    """Return what the text's ENVIRONMENT says it needs."""
    call = next(n.value for n in ast.parse(text).body if isinstance(n, ast.Assign) and "ENV" in ast.dump(n))
    return next(ast.literal_eval(k.value) for k in call.keywords if k.arg == "needs")


@pytest.mark.parametrize("key", LIBRARY)
@pytest.mark.parametrize("needs", [(), ("mass",), tuple(TERMS)])
def test_one_line_changes_and_says_what_is_needed(key, needs):
    before = source(key)
    after = edited(before, needs)
    assert declared(after) == needs
    assert edited(after, needs) == after
    lines = [d for d in difflib.ndiff(before.split("\n"), after.split("\n")) if d[0] in "+-"]
    assert all("needs=" in line for line in lines)
    assert len(lines) <= 2


def test_the_longest_line_is_as_the_formatter_writes_it(tmp_path):
    for needs in ((), ("coulomb",), tuple(TERMS)):
        file = tmp_path / f"with_{len(needs)}.py"
        file.write_text(edited(source("wall"), needs), encoding="utf-8")
    command = [sys.executable, "-m", "ruff", "format", "--check", "--line-length", "110", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (
            'ENVIRONMENT = Environment("a", force)\n',
            'ENVIRONMENT = Environment("a", force, needs=("mass",))\n',
        ),
        (
            'ENVIRONMENT = Environment(\r\n    key="ä",\r\n    needs=(),\r\n)\r\n',
            'ENVIRONMENT = Environment(\r\n    key="ä",\r\n    needs=("mass",),\r\n)\r\n',
        ),
        (
            'ENVIRONMENT = Environment(\r\n    key="a",\r\n    order=1,\r\n)\r\n',
            'ENVIRONMENT = Environment(\r\n    key="a",\r\n    needs=("mass",),\r\n    order=1,\r\n)\r\n',
        ),
        (
            'ENVIRONMENT = Environment(key="ä", needs=(\n    "delay",\n), order=1)',
            'ENVIRONMENT = Environment(key="ä", needs=("mass",), order=1)',
        ),
        (
            'ENVIRONMENT = Environment(\n    key="a",\n)\n',
            'ENVIRONMENT = Environment(\n    key="a",\n    needs=("mass",),\n)\n',
        ),
    ],
)
def test_every_way_to_write_a_declaration(text, wanted):
    assert edited(text, ("mass",)) == wanted


def test_a_copy_is_written_once(tmp_path, monkeypatch):
    file = tmp_path / "copy.py"
    file.write_bytes(needs_writer.file_of(LIBRARY["wall"]).read_bytes())
    monkeypatch.setattr(needs_writer, "file_of", lambda environment: file)
    assert needs_writer.write(LIBRARY["wall"], ("mass", "delay")) is True
    assert declared(file.read_text(encoding="utf-8")) == ("mass", "delay")
    assert needs_writer.write(LIBRARY["wall"], ("mass", "delay")) is False


def test_where_there_is_nothing_to_write_into():
    @law
    def nowhere(p, s, x, v, dt):
        return 0.0

    with pytest.raises(ParameterError, match=r"does not say ENVIRONMENT = Environment\("):
        edited("x = 1\n", ("mass",))
    with pytest.raises(ParameterError, match="Wall has no file of its own"):
        needs_writer.file_of(replace(LIBRARY["wall"], force=nowhere))

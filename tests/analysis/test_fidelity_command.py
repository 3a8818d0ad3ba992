"""The fidelity command: a table, one object, a picture, the files."""

import ast
import difflib
import json
import subprocess
import sys
from dataclasses import replace

import pytest

from hapkit_studio import environments
from hapkit_studio.analysis import fidelity
from hapkit_studio.analysis.fidelity import with_needs
from hapkit_studio.charts import fidelity as charts
from hapkit_studio.cli import main
from hapkit_studio.devices.simulated import TERMS
from hapkit_studio.errors import ParameterError
from hapkit_studio.laws import law


def run(capsys, *words):
    code = main(("fidelity", *words))
    out, err = capsys.readouterr()
    return code, out, err


def test_the_table_names_scene_term_outcome_and_hand(capsys):
    code, out, err = run(capsys, "free", "wall")
    assert (code, err) == (0, "")
    for term in TERMS:
        assert term in out
    assert "free needs mass, viscous, coulomb;" in out
    lines = [line for line in out.split("\n") if line.strip().startswith("saturation")]
    assert len(lines) == 2
    assert all("*" not in line for line in lines)
    assert "under released" in out


def test_one_object_with_a_row_a_cell(capsys):
    code, out, err = run(capsys, "free", "--json")
    assert (code, err) == (0, "")
    found = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} is not JSON"))
    rows = found["rows"]
    assert [row["term"] for row in rows] == [*TERMS, "together"]
    assert set(rows[0]) == {
        "scene", "term", "change", "outcome", "hand", "needed",
        "ns_per_simulated_s_with", "ns_per_simulated_s_without",
    }  # fmt: skip
    assert [row["term"] for row in rows if row["needed"]] == found["needs"]["free"]


def test_a_picture_of_all_that_was_asked(capsys, tmp_path):
    path = tmp_path / "table.png"
    code, out, _ = run(capsys, "free", "damping", "--plot", str(path))
    assert code == 0
    assert f"wrote {path}" in out
    assert path.read_bytes().startswith(b"\x89PNG")
    assert path.stat().st_size > 20_000


def test_a_picture_in_no_known_format_is_one_line(capsys, tmp_path):
    code, out, err = run(capsys, "free", "--plot", str(tmp_path / "table.wall"))
    assert (code, out) == (2, "")
    assert "A picture is one of" in err
    assert err.count("\n") == 1


def test_an_unknown_scene_is_one_line(capsys):
    code, out, err = run(capsys, "fre")
    assert (code, out) == (2, "")
    assert err.startswith("hapkit-studio: There is no environment 'fre'")


def test_the_file_gets_what_was_computed(capsys, tmp_path, monkeypatch):
    file = tmp_path / "free.py"
    file.write_text("ENVIRONMENT = Environment(\n    key='free',\n)\n", encoding="utf-8")
    monkeypatch.setattr(fidelity, "file_of", lambda environment: file)
    assert f"wrote {file}" in run(capsys, "free", "--write")[1]
    assert '    needs=("mass", "viscous", "coulomb"),\n' in file.read_text(encoding="utf-8")
    assert "wrote" not in run(capsys, "free", "--write")[1]


OWN = """from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    return -p.stiffness * x


ENVIRONMENT = Environment(
    "mine", "Mine", "A spring", (Parameter("stiffness", "Stiffness", "N/m", 100.0, 0.0, 500.0),), force
)
"""


@pytest.mark.slow
def test_a_persons_own_file_is_judged_and_written(capsys, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(OWN, encoding="utf-8")
    code, out, err = run(capsys, str(file), "--trust", "--write")
    assert (code, err) == (0, "")
    assert f"wrote {file}" in out
    assert '    needs=("mass", "viscous", "coulomb"' in file.read_text(encoding="utf-8")
    assert "wrote" not in run(capsys, str(file), "--trust", "--write")[1]


@pytest.mark.parametrize(
    ("change", "words"),
    [(None, "–"), (0.0004, "0 %"), (0.0206, "2.1 %"), (0.0996, "10 %"), (9.99, "999 %"), (1e6, "> 999 %")],
)
def test_shares_in_words(change, words):
    assert charts.percent(change) == words


LIBRARY = environments.discover()


def source(key):
    return fidelity.file_of(LIBRARY[key]).read_text(encoding="utf-8")


def declared(text):
    """Return what the text's ENVIRONMENT says it needs."""
    call = next(n.value for n in ast.parse(text).body if isinstance(n, ast.Assign) and "ENV" in ast.dump(n))
    return next(ast.literal_eval(k.value) for k in call.keywords if k.arg == "needs")


@pytest.mark.parametrize("key", LIBRARY)
@pytest.mark.parametrize("needs", [(), ("mass",), tuple(TERMS)])
def test_one_line_changes_and_says_what_is_needed(key, needs):
    before = source(key)
    after = with_needs(before, needs)
    assert declared(after) == needs
    assert with_needs(after, needs) == after
    lines = [d for d in difflib.ndiff(before.split("\n"), after.split("\n")) if d[0] in "+-"]
    assert all("needs=" in line for line in lines)
    assert len(lines) <= 2


def test_the_longest_line_is_as_the_formatter_writes_it(tmp_path):
    for needs in ((), ("coulomb",), tuple(TERMS)):
        file = tmp_path / f"with_{len(needs)}.py"
        file.write_text(with_needs(source("wall"), needs), encoding="utf-8")
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
    assert with_needs(text, ("mass",)) == wanted


def test_a_copy_is_written_once(tmp_path, monkeypatch):
    file = tmp_path / "copy.py"
    file.write_bytes(fidelity.file_of(LIBRARY["wall"]).read_bytes())
    monkeypatch.setattr(fidelity, "file_of", lambda environment: file)
    assert fidelity.write_needs(LIBRARY["wall"], ("mass", "delay")) is True
    assert declared(file.read_text(encoding="utf-8")) == ("mass", "delay")
    assert fidelity.write_needs(LIBRARY["wall"], ("mass", "delay")) is False


def test_where_there_is_nothing_to_write_into():
    @law
    def nowhere(p, s, x, v, dt):
        return 0.0

    with pytest.raises(ParameterError, match=r"does not say ENVIRONMENT = Environment\("):
        with_needs("x = 1\n", ("mass",))
    with pytest.raises(ParameterError, match="Wall has no file of its own"):
        fidelity.file_of(replace(LIBRARY["wall"], force=nowhere))

"""A student's file works in the command line, in a notebook, and in an installed package."""

import json
import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest

from hapkit_studio.cli import main
from hapkit_studio.workshop import folder
from hapkit_studio.workshop.source import is_trusted, read
from tests.workshop.student import END, line_of, text, write

PACKAGE = {
    "my_walls/__init__.py": "",
    "my_walls-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: my-walls\nVersion: 1.0\n",
    "my_walls-1.0.dist-info/entry_points.txt": """
        [hapkit_studio.environments]
        mine = my_walls.mine:ENVIRONMENT
        broken = my_walls.broken:ENVIRONMENT
        """,
    "my_walls/broken.py": "1 / 0\n",
}


def run(capsys, *args):
    """Return (exit code, stdout, stderr) of `hapkit-studio run` with these arguments."""
    code = main(("run", *args))
    return code, *capsys.readouterr()


@pytest.mark.slow
def test_a_file_runs_like_a_built_in_environment(tmp_path, capsys):
    write(tmp_path, folder.templates()[0].text, "my_env.py")
    csv = tmp_path / "run.csv"
    given = ("--trust", "-p", "stiffness=200", "-p", "damping=0", "--hand", "press", "--csv", str(csv))
    code, out, err = run(capsys, "my_env.py", *given, "--json")
    assert (code, err) == (0, "")
    mine = json.loads(out)
    assert (mine["environment"], mine["parameters"]["stiffness"]) == ("my_spring", 200.0)
    assert mine["samples"] == 2000
    names, *rows = [x for x in csv.read_text(encoding="utf-8").splitlines() if not x.startswith("#")]
    table, names = np.loadtxt(rows, delimiter=","), names.split(",")
    force, position = (table[:, names.index(name)] for name in ("force_asked_N", "position_m"))
    assert np.abs(position).max() > 1e-3
    assert np.allclose(force, -200.0 * position)


def test_a_mistake_is_one_line_with_file_and_line(tmp_path, capsys):
    whole = text("return x / p.mass")
    write(tmp_path, whole, "my env.py")
    code, out, err = run(capsys, str(tmp_path / "my env.py"), "--trust")
    assert (code, out) == (2, "")
    message = "a division by zero at x = 0 mm, v = 0 m/s, mass = 0 kg: test the"
    assert err.startswith(f"hapkit-studio: my env.py, line {line_of(whole, '/ p.mass')}: {message}")
    assert err.count("\n") == 1


# --- only trusted files are executed


def leaving_a_mark(folder):
    """Return the text of a law that creates a file when it is executed."""
    return text(beside=f"import pathlib\npathlib.Path({str(folder / 'mark')!r}).touch()\n")


def test_an_untrusted_file_is_not_executed(tmp_path, capsys):
    write(tmp_path, leaving_a_mark(tmp_path))
    code, out, err = run(capsys, "mine.py")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("hapkit-studio: mine.py: not executed")
    assert "--trust" in err
    assert not (tmp_path / "mark").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("run", "--seconds", "0.1", "--device", "simulated"),
        pytest.param(("export", "-o", "sketch"), marks=pytest.mark.slow),
    ],
)
def test_an_endless_check_is_named_in_one_line_and_the_command_continues(tmp_path, capsys, command):
    beside = """
        def check(p):
            if 123 < p["stiffness"] < 124:
                for i in range(10**12):
                    pass
            return ""
        """
    write(tmp_path, text(beside=beside, end=END.replace("force=force,", "force=force, check=check,")))
    name, *more = command
    assert main((name, "mine.py", "--trust", "-p", "stiffness=123.5", *more)) == 0
    out = capsys.readouterr().out
    assert out.count("`check` of mine.py took more than 1 s") == 1


def test_a_trusted_file_runs_until_it_changes(tmp_path, capsys):
    path = write(tmp_path, leaving_a_mark(tmp_path))
    short = ("mine.py", "--seconds", "0.01")
    assert run(capsys, *short, "--trust")[0] == 0
    assert (tmp_path / "mark").exists()
    assert run(capsys, *short)[0] == 0
    path.write_text(path.read_text(encoding="utf-8") + "\n# more\n", encoding="utf-8")
    (tmp_path / "mark").unlink()
    assert run(capsys, *short)[0] == 2
    assert not (tmp_path / "mark").exists()


@pytest.mark.slow
@pytest.mark.parametrize(("answer", "code"), [pytest.param("y", 0, marks=pytest.mark.slow), ("", 2)])
def test_at_a_terminal_the_source_is_shown_before_consent(tmp_path, answer, code):
    hidden = leaving_a_mark(tmp_path).replace("A law of mine", "A law \x1b[8mof\u202e mine")
    write(tmp_path, hidden)
    ours, theirs = pytest.importorskip("pty").openpty()
    command = [sys.executable, "-m", "hapkit_studio", "run", "mine.py", "--seconds", "0.01", "--json"]
    process = subprocess.Popen(command, stdin=theirs, stderr=theirs, stdout=subprocess.PIPE)
    os.close(theirs)
    shown = b""
    while b"[y/N] " not in shown:
        shown += os.read(ours, 65536)
    assert not (tmp_path / "mark").exists()
    os.write(ours, answer.encode() + b"\n")
    out = process.communicate(timeout=60)[0]
    os.close(ours)
    assert process.returncode == code
    assert (tmp_path / "mark").exists() == (code == 0)
    assert (json.loads(out)["environment"] == "mine") if code == 0 else out == b""
    assert is_trusted(read(tmp_path / "mine.py")) == (code == 0)
    output = shown.decode().replace("\r\n", "\n")
    assert "pathlib.Path(" in output
    assert "A law \\u001b[8mof\\u202e mine" in output
    assert "\x1b" not in output


# --- own environments as a package


def install(folder, **more):
    """Write the files of an installed package into a folder, as pip would."""
    for name, source in {**PACKAGE, **more}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(textwrap.dedent(source).lstrip("\n"), encoding="utf-8")


@pytest.mark.slow
def test_the_same_file_installs_as_a_package(tmp_path):
    site = tmp_path / "site"
    install(site)
    write(site / "my_walls", text(), "mine.py")
    program = """
        import warnings
        import hapkit_studio as hs

        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            library = hs.environments()
        run = hs.simulate("mine", {"stiffness": 100.0}, hand="press", seconds=0.3)
        print(library["mine"].title, "wall" in library, "broken" in library)
        print(max(abs(run.force + 100.0 * run.position)) < 1e-12, max(run.position) > 1e-3)
        print([str(w.message) for w in said])
        """
    paths = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=True,
    )
    first, second, message = done.stdout.splitlines()
    assert (first, second) == ("Mine True False", "True True")
    assert message.count("cannot be loaded") == 1
    assert "'broken'" in message

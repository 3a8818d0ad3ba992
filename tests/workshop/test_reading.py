"""Reading a file: always its present text, as an environment of one's own."""

import math
import os
import sys

import numpy as np
import pytest

import hapkit_studio as hs
from hapkit_studio import environments, workshop
from hapkit_studio.errors import LawError
from hapkit_studio.workshop import reading
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.source import read
from tests.workshop.student import END, text, write


def force_at(made, x):
    return made.curve(made.values(), np.array([x]))[0]


def test_a_file_becomes_an_environment_of_ones_own(tmp_path):
    path = write(tmp_path, text())
    made = workshop.load(path)
    assert isinstance(made, OwnEnvironment)
    assert (made.key, made.title, made.source) == ("mine", "Mine", read(path))
    assert [p.key for p in made.parameters] == ["stiffness", "mass", "side"]
    assert force_at(made, 0.01) == pytest.approx(-2.0)
    assert not any(isinstance(e, OwnEnvironment) for e in environments.discover().values())


def test_it_is_there_for_notebooks(tmp_path, monkeypatch):
    write(tmp_path, text())
    monkeypatch.chdir(tmp_path)
    run = hs.simulate(hs.load_environment("mine.py"), {"stiffness": 100.0}, hand="press", seconds=0.5)
    assert np.allclose(run.force, -100.0 * run.position)
    assert run.settings["environment"] == "mine"


def test_an_edited_file_is_read_afresh(tmp_path):
    """Even within one clock tick of the file system, and of the same length."""
    path = write(tmp_path, text("return -1.0 * x"))
    before = os.stat(path)
    first = reading.load(path)
    write(tmp_path, text("return -2.0 * x"))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    second = reading.load(path)
    assert (force_at(first, 1.0), force_at(second, 1.0)) == (-1.0, -2.0)


def test_nothing_is_left_of_a_file_that_was_read(tmp_path):
    path = write(tmp_path, text())
    reading.load(path)
    path.unlink()
    with pytest.raises(LawError, match=r"there is no file mine\.py"):
        reading.load(path)
    assert not [name for name in sys.modules if name.startswith("own_environment")]
    assert not list(tmp_path.rglob("*.pyc"))


def test_a_file_may_go_while_its_environment_is_used(tmp_path):
    path = write(tmp_path, text("return -helped(x)", beside="def helped(a):\n    return 3.0 * a\n"))
    made = reading.load(path)
    path.unlink()
    assert force_at(made, 1.0) == -3.0
    made.force.bind(made.parameters[:1])  # others than before: the law is translated again
    assert force_at(made, 1.0) == -3.0


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace("\n", "\r\n").encode(),
        lambda t: t.replace("\n", "\r").encode(),
        lambda t: b"\xef\xbb\xbf" + t.encode(),
        lambda t: t.replace("    ", "\t").encode(),
        lambda t: t.rstrip("\n").encode(),
        lambda t: t.replace('"Mine"', '"Größe 弹簧 \\N{GREEK SMALL LETTER MU}"').encode(),
        lambda t: t.replace("return", "größe = 1.0\n    return größe *").encode(),
        lambda t: t.replace("A file of mine.", "A file\x0cof\u2028mine\x1c.").encode(),
        lambda t: b"# coding: latin-1\n" + t.encode(),
    ],
    ids=["windows", "old mac", "bom", "tabs", "no last newline", "title", "names", "odd line ends", "coding"],
)
def test_files_of_every_editor(tmp_path, change):
    path = tmp_path / "mine.py"
    path.write_bytes(change(text()))
    assert force_at(reading.load(path), 0.01) == pytest.approx(-2.0)


def test_a_file_of_5000_lines(tmp_path):
    long = "".join(f"A_{n} = {n}.0\n" for n in range(5000))
    made = reading.load(write(tmp_path, text("return A_4999 * x", beside=long)))
    assert force_at(made, 1.0) == 4999.0


def test_own_functions_that_raise_or_lie_disturb_nobody(tmp_path):
    wrong = END.replace(
        "    force=force,\n",
        "    force=force,\n    impedance=lambda p: None,\n    check=lambda p: 1 / 0,\n"
        "    warnings=lambda p, c: (1 / 0 for i in range(3)),\n"
        "    unused=lambda p: {1 / 0: 2},\n"
        "    over_position=lambda p, x: nothing,\n    over_velocity=lambda p, v: 'text',\n"
        "    shortcut='2',\n",
    )
    made = reading.load(write(tmp_path, text(end=wrong)))
    values = made.values({"stiffness": 100.0})
    assert values["stiffness"] == 100.0
    assert made.impedance(values) == (0.0, 0.0)
    assert made.warnings(values, None) == ()
    assert made.unused(values) == {}
    for curve in (made.over_position, made.over_velocity):
        assert np.isnan(curve(values, np.zeros(3))).tolist() == [True] * 3
    assert made.shortcut == ""


def test_a_law_without_end_does_not_hold_up_its_curve(tmp_path):
    body = "for i in range(2000000000):\n    a = i\nreturn 1.0"
    assert math.isnan(force_at(reading.load(write(tmp_path, text(body))), 0.0))

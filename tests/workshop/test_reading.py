"""A file is always read with its current text, and becomes one of the user's own environments."""

import math
import os
import re
from pathlib import Path

import numpy as np
import pytest

from hapkit_studio import environments, workshop
from hapkit_studio.errors import LawError
from hapkit_studio.workshop import folder, reading
from hapkit_studio.workshop.own import OwnEnvironment
from hapkit_studio.workshop.source import read, typed
from tests.workshop.student import END, text, write


def force_at(made, x):
    return made.curve(made.values(), np.array([x]))[0]


def test_a_file_becomes_a_users_own_environment(tmp_path):
    path = write(tmp_path, text())
    made = workshop.load(path)
    assert isinstance(made, OwnEnvironment)
    assert (made.key, made.title, made.source) == ("mine", "Mine", read(path))
    assert [p.key for p in made.parameters] == ["stiffness", "mass", "side"]
    assert force_at(made, 0.01) == pytest.approx(-2.0)
    assert not any(isinstance(e, OwnEnvironment) for e in environments.discover().values())


def test_an_edited_file_is_read_again(tmp_path):
    """The edit is detected even if the file's time stamp and length are unchanged."""
    path = write(tmp_path, text("return -1.0 * x"))
    before = os.stat(path)
    first = reading.load(path)
    write(tmp_path, text("return -2.0 * x"))
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    second = reading.load(path)
    assert (force_at(first, 1.0), force_at(second, 1.0)) == (-1.0, -2.0)


def test_a_file_may_be_deleted_while_in_use(tmp_path):
    path = write(tmp_path, text("return -helped(x)", beside="def helped(a):\n    return 3.0 * a\n"))
    made = reading.load(path)
    path.unlink()
    assert force_at(made, 1.0) == -3.0
    made.force.bind(made.parameters[:1])  # with other parameters the law is translated again
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
def test_files_of_every_editor_are_read(tmp_path, change):
    path = tmp_path / "mine.py"
    path.write_bytes(change(text()))
    assert force_at(reading.load(path), 0.01) == pytest.approx(-2.0)


def test_failing_functions_fall_back_to_defaults(tmp_path):
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


def test_an_endless_law_does_not_block_its_curve(tmp_path):
    body = "for i in range(2000000000):\n    a = i\nreturn 1.0"
    assert math.isnan(force_at(reading.load(write(tmp_path, text(body))), 0.0))


WHOLE = text()
LAW = "def force(p, s, x, v, dt):"


def wrong(folder, whole):
    """Return the error that a file's text causes."""
    with pytest.raises(LawError) as caught:
        reading.load(write(folder, whole))
    return caught.value


# columns: old text, new text, content of the line with the error, message
MISTAKES = [
    (LAW, LAW[:-1], "def force", "a colon is missing at the end of this line"),
    ("return -p", "  return (-p", "return (-p", "'(' was never closed"),
    ("return -p", "a = 1\n      return -p", "      return", "indent this line by 4 spaces; it has 6"),
    (LAW, f"{LAW}\n    if x > 0.0:", "    return -p", "indent this line by 8 spaces; it has 4"),
    (
        "return -p",
        "a = 1\n  return -p",
        "  return",
        "has 2 spaces before it: indent it as far as a line above",
    ),
    ("return -p", "a = 1\n\treturn -p", "\treturn", "spaces only: tabs and spaces are mixed"),
    ("return -p", "return −p", "return −p", "invalid character '−' (U+2212)"),
    ("return -p", "return p.stifness + -p", "stifness", "'p.stifness' is not a parameter; available: stiff"),
    ("return -p.stiffness", "return -stifness", "-stifness", "'stifness' is not defined"),
    ("return -p", "while x > 0:\n        pass\n    return -p", "while", "use `for i in range(10)`"),
    ("import math\n", "import math\n\nA = B + 1\n", "A = B", "'B' is not defined"),
    ("import math\n", "import math\n\nA = 1 / 0\n", "A = 1 / 0", "a division by zero"),
    ("import math\n", "import sys\n\nsys.exit(3)\n", "sys.exit", "must not end the program"),
    ("import math\n", "raise ValueError('my\\nown')\n", "raise Val", "my own (ValueError)"),
    (
        'Choice("side", "Side", ("right", "left"))',
        '"side"',
        "ENVIRONMENT = Env",
        "must contain only Parameter(…) and",
    ),
    ("@law\n", "", "ENVIRONMENT = Env", "not a law: write `@law` above"),
    ("0.0, 2000.0)", "0.0)", '"stiffness"', "Parameter also needs 'high'"),
    ("200.0, 0.0, 2000", "200.0, 0.0, 20", '"stiffness"', "must be from 0 to 20 N/m, not 200 N/m"),
    (
        "200.0, 0.0, 2000",
        '"200", 0.0, 2000',
        '"stiffness"',
        "'stiffness': its default must be a number, not '200'",
    ),
    ("0.0, 2000.0)", "0.0, math.inf)", '"stiffness"', "its high must be a number, not inf"),
    (
        '"mass", "Mass"',
        '"stiffness", "Mass"',
        '"stiffness", "Mass"',
        "two parameters have the same name 'stiffness'",
    ),
    ('("right", "left")', '("left", "left")', '"side"', "two of its options have the same name"),
    ('key="mine"', 'key="wall"', 'key="wall"', 'the key "wall" is already used by the program'),
    ('key="mine"', 'key="My Wall"', "My Wall", "`key` must consist of a–z, 0–9 and _"),
    ('title="Mine"', 'title=""', 'title=""', "must not be empty"),
    ("force=force,", "force=force, impedance=(1.0, 0.0),", "impedance=", "`impedance` must be a function"),
    ("ENVIRONMENT = Env", "environment = Env", ")", "end it with `ENVIRONMENT = Environment(…)`"),
    (END, "\nENVIRONMENT = force\n", "ENVIRONMENT = force", "ENVIRONMENT is a law: write"),
]


@pytest.mark.parametrize(("old", "new", "where", "message"), MISTAKES)
def test_a_mistake_is_reported_with_its_line(tmp_path, old, new, where, message):
    assert old in WHOLE
    whole = WHOLE.replace(old, new, 1)
    error = wrong(tmp_path, whole)
    assert message in str(error)
    assert "\n" not in str(error)
    lines = [n for n, line in enumerate(whole.split("\n"), 1) if where in line]
    assert error.line == (lines[-1] if where == ")" else lines[0])


@pytest.mark.parametrize(
    ("data", "message", "line"),
    [
        (b"", "end it with `ENVIRONMENT", 1),
        (b"\n\n\n", "end it with `ENVIRONMENT", 3),
        (b"a = 1\nb = '\xff'\n", "not text in UTF-8", 2),
        ("a = 1\n".encode("utf-16"), "not text in UTF-8", 1),
        (b"a = 1\nb = 2\0\n", "the file is not text", 1),
        (b"#" * 1_000_001, "has 1,000,001 bytes; the limit is 1,000,000", 0),
        (b"a = " + b"(" * 500, "nested", 1),
        (b"a = " + b"-" * 100_000 + b"1\n", "", 0),
        (b"a = " + b"9" * 5000 + b"\n", "", 1),
    ],
    ids=["empty", "blank", "latin", "utf-16", "null", "huge", "brackets", "signs", "digits"],
)
def test_files_without_an_environment_are_reported(tmp_path, data, message, line):
    path = tmp_path / "mine.py"
    path.write_bytes(data)
    with pytest.raises(LawError) as caught:
        reading.load(path)
    assert message in str(caught.value)
    assert line in (0, caught.value.line)
    assert len(str(caught.value)) < 400


def changed(whole, old, new):
    assert whole.count(old) == 1, old
    return whole.replace(old, new)


TEMPLATE = {template.key: template.text for template in folder.templates()}
LINE = "return -p.stiffness * (x - p.center) - p.damping * v"


@pytest.mark.parametrize("key", TEMPLATE)
def test_a_templates_formula_is_shown_as_long_as_its_law_is_unchanged(key):
    """A different title, comment, limit or docstring leaves the law unchanged."""
    whole = TEMPLATE[key]
    before = of_text(whole).formula
    assert before in whole
    whole = whole.replace("# name in the law, label,", "# my own words, label,")
    whole = changed(
        whole, "from hapkit_studio.laws import law\n", "from hapkit_studio.laws import law\nimport math\n"
    )
    assert of_text(folder.fill_template(folder.Template(key, key, whole), "Mine", "mine")).formula == before


def of_text(whole):
    return reading.load_source(typed(Path("mine.py"), whole))


@pytest.mark.parametrize(
    ("key", "old", "new"),
    [
        ("spring", LINE, "return -p.stiffness * math.sin(x)"),
        ("spring", LINE, LINE + " ** 3"),
        ("two_walls", "max(rate, 0.0)", "rate"),  # the change is in a helper function of the law
        ("wall", "push += p.damping * rate", "push += p.damping * rate * rate"),
        ("mass_on_a_spring", '"object": 0.0', '"object": 0.01'),
    ],
)
def test_a_different_law_does_not_show_its_templates_formula(key, old, new):
    whole = changed(TEMPLATE[key], old, new).replace("from hapkit", "import math\n\nfrom hapkit", 1)
    assert of_text(whole).formula == ""
    formula = re.search(r'formula="(.*)"', whole)[1]
    assert of_text(whole.replace(formula, "<i>F</i>")).formula == "<i>F</i>"
    assert of_text(whole.replace(f'    formula="{formula}",\n', "")).formula == ""


def test_a_law_copied_from_the_library_keeps_its_formula_until_it_is_changed():
    library = Path(environments.__file__).parent / "detents.py"
    whole = library.read_text(encoding="utf-8").replace('key="detents"', 'key="mine"')
    assert of_text(whole).explained_formula == environments.named("detents").explained_formula
    copied = of_text(changed(whole, "return -p.stiffness * away", "return p.stiffness * away"))
    assert copied.explained_formula == ""

"""What is wrong in a file is said with its line, in words a student understands."""

import pytest

from hapkit_studio.errors import LawError
from hapkit_studio.workshop import reading
from tests.workshop.student import END, line_of, text, write

WHOLE = text()
LAW = "def force(p, s, x, v, dt):"


def wrong(folder, whole):
    """Return the error of a file's text."""
    with pytest.raises(LawError) as caught:
        reading.load(write(folder, whole))
    return caught.value


# (what is replaced, by what, what the line with the error holds, what is said)
MISTAKES = [
    (LAW, LAW[:-1], "def force", "Python cannot read this line: expected ':'"),
    ("return -p", "  return (-p", "return (-p", "'(' was never closed"),
    ("return -p", "a = 1\n      return -p", "      return", "unexpected indent"),
    ("return -p", "return −p", "return −p", "invalid character '−' (U+2212)"),
    (
        "return -p",
        "return p.stifness + -p",
        "stifness",
        "'p.stifness' is not a parameter; there is: stiffness",
    ),
    ("return -p.stiffness", "return -stifness", "-stifness", "'stifness' is not defined"),
    ("return -p", "while x > 0:\n        pass\n    return -p", "while", "use `for i in range(10)`"),
    ("import math\n", "import maths\n", "import maths", "there is no module 'maths'"),
    ("import math\n", "import math\n\nA = B + 1\n", "A = B", "'B' is not defined"),
    ("import math\n", "import math\n\nA = 1 / 0\n", "A = 1 / 0", "a division by zero"),
    ("import math\n", "import sys\n\nsys.exit(3)\n", "sys.exit", "may not end the program"),
    ("import math\n", "def f():\n    return f()\n\n\nf()\n", "return f()", "calls itself without end"),
    ("import math\n", "raise ValueError('my\\nown')\n", "raise Val", "my own (ValueError)"),
    ("import math\n", "exec('a b')\n", "exec(", "invalid syntax"),
    (
        "import Choice",
        "import Choices, Choice",
        "import Choices",
        "there is no 'Choices' in hapkit_studio.par",
    ),
    ('Choice("side", "Side", ("right", "left"))', '"side"', "ENVIRONMENT = Env", "holds Parameter(…) and Ch"),
    ("import math\n", "A = {}['b']\n", "A = {}", "there is no 'b'"),
    ("@law\n", "", "ENVIRONMENT = Env", "not a law: write `@law` above"),
    ("0.0, 2000.0)", "0.0)", '"stiffness"', "Parameter also needs 'high'"),
    ("0.0, 2000.0)", "lowest=0.0)", '"stiffness"', "Parameter has nothing named 'lowest'"),
    ("0.0, 2000.0)", "2000.0, 0.0)", '"stiffness"', "'stiffness' goes from 2000 to 0 N/m: the lower limit"),
    ("200.0, 0.0, 2000", "200.0, 0.0, 20", '"stiffness"', "goes from 0 to 20 N/m, its default is 200 N/m"),
    (
        "200.0, 0.0, 2000.0",
        '"200", 0.0, 2000.0',
        '"stiffness"',
        "'stiffness': its default is a number, not '200'",
    ),
    ("0.0, 2000.0)", "0.0, math.inf)", '"stiffness"', "its high is a number, not inf"),
    ('"mass", "Mass"', '"stiffness", "Mass"', '"stiffness", "Mass"', "there are two parameters 'stiffness'"),
    ('"mass", "Mass"', '"the mass", "Mass"', "the mass", "a parameter's first value is its name"),
    ('"Mass", "kg"', '"Mass", 5', '"Mass", 5', "'mass': its unit is text in quotation marks, not 5"),
    ('("right", "left")', '("right")', '"side"', "its options are names in brackets"),
    ('("right", "left")', '("left", "left")', '"side"', "two of its options have the same name"),
    ('("right", "left")', '("right", "left"), "up"', '"side"', "its default is one of right, left, not 'up'"),
    ('key="mine"', 'key="wall"', 'key="wall"', 'the key "wall" is taken by the studio'),
    ('key="mine"', 'key="My Wall"', "My Wall", "`key` is made of a–z, 0–9 and _"),
    ('title="Mine"', 'title=""', 'title=""', "may not be empty"),
    ('summary="A law of mine"', "summary=5", "summary=5", "`summary` is text"),
    ("force=force,", "force=force, impedance=(1.0, 0.0),", "impedance=", "`impedance` is a function"),
    ("ENVIRONMENT = Env", "environment = Env", ")", "end it with `ENVIRONMENT = Environment(…)`"),
    ("ENVIRONMENT = Environment(", "ENVIRONMENT = dict(", "ENVIRONMENT = dict(", "ENVIRONMENT is 'dict'"),
    (
        'Parameter("mass"',
        'type("P", (Parameter,), {})("mass"',
        "parameters=(",
        "holds Parameter(…) and Choice(…) only",
    ),
    (END, "\nENVIRONMENT = force\n", "ENVIRONMENT = force", "ENVIRONMENT is a law: write"),
]


@pytest.mark.parametrize(("old", "new", "where", "said"), MISTAKES)
def test_a_mistake_is_said_at_its_line(tmp_path, old, new, where, said):
    assert old in WHOLE
    whole = WHOLE.replace(old, new, 1)
    error = wrong(tmp_path, whole)
    assert said in str(error)
    assert "\n" not in str(error)
    lines = [n for n, line in enumerate(whole.split("\n"), 1) if where in line]
    assert error.line == (lines[-1] if where == ")" else lines[0])


def test_one_parameter_without_its_comma(tmp_path):
    one = END[: END.index("    parameters")] + '    parameters=(Parameter("k", "K", "", 1.0, 0.0, 2.0)),\n'
    whole = text("return -p.k * x", end=one + "    force=force,\n)\n")
    error = wrong(tmp_path, whole)
    assert "ends with a comma" in str(error)
    assert error.line == line_of(whole, "ENVIRONMENT =")


@pytest.mark.parametrize(
    ("data", "said", "line"),
    [
        (b"", "end it with `ENVIRONMENT", 1),
        (b"\n\n\n", "end it with `ENVIRONMENT", 3),
        (b"a = 1\nb = '\xff'\n", "not text in UTF-8", 2),
        ("a = 1\n".encode("utf-16"), "not text in UTF-8", 1),
        (b"a = 1\nb = 2\0\n", "the file is not text", 1),
        (b"#" * 1_000_001, "larger than 1 MB", 0),
        (b"a = " + b"(" * 500, "nested", 1),
        (b"a = " + b"-" * 100_000 + b"1\n", "", 0),
        (b"a = " + b"9" * 5000 + b"\n", "", 1),
    ],
    ids=["empty", "blank", "latin", "utf-16", "null", "huge", "brackets", "signs", "digits"],
)
def test_what_is_no_environment_at_all(tmp_path, data, said, line):
    path = tmp_path / "mine.py"
    path.write_bytes(data)
    with pytest.raises(LawError) as caught:
        reading.load(path)
    assert said in str(caught.value)
    assert line in (0, caught.value.line)
    assert len(str(caught.value)) < 400


def test_a_folder_and_a_file_that_may_not_be_read(tmp_path):
    with pytest.raises(LawError, match="cannot be read"):
        reading.load(tmp_path)


def test_a_law_nested_too_deep(tmp_path):
    error = wrong(tmp_path, text("return " + " + ".join(["x"] * 5000)))
    assert "nested too deep" in str(error)


@pytest.mark.parametrize("count", [32, 33])
def test_up_to_32_parameters(tmp_path, count):
    lines = "".join(f'        Parameter("k{n}", "K", "", 1.0, 0.0, 2.0),\n' for n in range(count))
    end = END[: END.index("        Parameter")] + lines + END[END.index("    ),\n    force") :]
    if count == 32:
        assert len(reading.load(write(tmp_path, text("return 0.0", end=end))).parameters) == 32
    else:
        assert "up to 32 parameters, not 33" in str(wrong(tmp_path, text("return 0.0", end=end)))

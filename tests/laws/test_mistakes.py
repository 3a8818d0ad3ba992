"""Each frequent mistake, and each variant of it, gets its message and line."""

import pytest

from hapkit_studio.errors import LawError
from hapkit_studio.laws.mistakes import MISTAKES
from hapkit_studio.workshop import reading
from hapkit_studio.workshop.source import typed

FILE = """import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter

FORCES = (0.0, 1.0, 2.0)


def half(a):
    return 0.5 * a


@law(state={{"last": 0.0}})
def force(p, s, x, v, dt):
    before = 1.0
    {line}
    return 0.0


ENVIRONMENT = Environment(
    key="mistake", title="Mistake", summary="", force=force,
    parameters=(Parameter("stiffness", "Stiffness", "N/m", 100.0, 0.0, 500.0),),
)
"""
LINE = FILE.splitlines().index("    {line}") + 1
VARIANTS = [
    ("a = sgn(x)", "`sgn` is not in the law language: write `math.copysign(1.0, a)`"),
    ("a = math.round(x)", "`round` is not in the law language: write `math.floor(a + 0.5)`"),
    ("a = 1.0 + round(2.0 * x, 1)", "`round` is not in the law language: write `math.floor(a + 0.5)`"),
    ("a = math.sign(x)", "`sign` is not in the law language: write `math.copysign(1.0, a)`"),
    ("a = log10(x)", "`log10` belongs to the module math: write `math.log10(a)`"),
    ("a = radians(x)", "`radians` belongs to the module math: write `math.radians(a)`"),
    ("a = atan2(x, v)", "`atan2` belongs to the module math: write `math.atan2(a, b)`"),
    ("a = numpy.sign(x)", "`numpy` is not in the law language: write `math.sin(a)`"),
    ("a = np.pi", "`np` is not in the law language"),
    ("a = math.PI", "'math.PI' is not defined: write `math.pi`"),
    ("a = max(print(x), 1.0)", "a law cannot print"),
    ("if(x > 0.0 && v > 0.0 || v < 1.0): a = 1.0", "`&&` is C: write `and`"),
    ("if x > 0.0 and !(v > 0.0): a = 1.0", "`!` is C: write `not`"),
    ("s.last++;", "`++` is C: write `+= 1`"),
    ("elseif x > 0.0:", "`else if` is C: write `elif`"),
    ("} else if (x > 0.0) {", "`else if` is C: write `elif`"),
    ("} else {", "`{` and `}` are C"),
    ("const float a = x;", "a type belongs to C"),
    ("a = x; // the wall", "`//` is a comment in C: write `#`"),
    ("a = stiffness * x", "'stiffness' is not defined: write `p.stiffness`"),
    ("a = last", "'last' is not defined: write `s.last`"),
    ("s.count += 1", 'Add it above the law: `@law(state={"count": 0.0})`'),
    ("a = half(x, p)", "the arguments of a helper function must be numbers"),
    ("a = half(FORCES)", "use the table `FORCES[i]` in the helper"),
]


def refused(line, folder):
    with pytest.raises(LawError) as error:
        reading.load_source(typed(folder / "mistake.py", FILE.format(line=line)))
    return error.value


def test_at_least_thirty_mistakes_are_known():
    assert len(MISTAKES) >= 30
    assert len({m.wrong for m in MISTAKES}) == len(MISTAKES)


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda m: m.wrong)
def test_each_mistake_has_its_message_and_line(mistake, tmp_path):
    error = refused(mistake.wrong, tmp_path)
    assert str(error) == f"Line {LINE}: {mistake.example}"


@pytest.mark.parametrize(("line", "text"), VARIANTS, ids=[line for line, _ in VARIANTS])
def test_variants_have_the_same_message(line, text, tmp_path):
    error = refused(line, tmp_path)
    assert text in str(error)
    assert error.line == LINE


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("a = (x", "'(' was never closed"),
        ("a = 'what? && {", "unterminated string"),
        ("a = x +", "invalid syntax"),
        ("a = {1: 2", "'{' was never closed"),
    ],
)
def test_other_syntax_errors_have_pythons_message(line, text, tmp_path):
    assert f"Python cannot read this line: {text}" in str(refused(line, tmp_path))


@pytest.mark.parametrize(
    "line",
    [
        "a = x--v",
        "a = 7 // 2",
        "a = x if x != 0.0 else -v",
        "a = math.radians(90) + math.degrees(v)",
        "a = x; b = v;",
    ],
)
def test_correct_lines_similar_to_mistakes_are_accepted(line, tmp_path):
    reading.load_source(typed(tmp_path / "fine.py", FILE.format(line=line)))


def test_names_defined_in_a_law_are_not_mistakes(tmp_path):
    text = FILE.format(line="time = x\n    pos = time + PI\n    round = pos").replace(
        "FORCES =", "PI = math.pi\nFORCES ="
    )
    reading.load_source(typed(tmp_path / "fine.py", text))

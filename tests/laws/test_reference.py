"""The reference page agrees with the checker's tables, and every example on it compiles."""

import ast
import re

import pytest

from hapkit_studio.laws import reference, subset
from hapkit_studio.laws.board import compile as compile_for_board
from hapkit_studio.laws.law import MAX_STATE
from hapkit_studio.laws.mistakes import MISTAKES
from hapkit_studio.laws.translate import Rewriter
from hapkit_studio.parameters import Choice, Parameter
from hapkit_studio.workshop import reading, trying
from hapkit_studio.workshop.source import typed
from tests.laws.law_files import module

PARAMETERS = (
    Parameter("stiffness", "Stiffness", "N/m", 200.0, 0.0, 1e4),
    Parameter("damping", "Damping", "N·s/m", 2.0, 0.0, 50.0),
    Parameter("frequency", "Frequency", "Hz", 40.0, 1.0, 400.0),
    Choice("side", "Side", ("right", "left")),
)
BESIDE = """
GAIN, TURNS = 2.5, 3
FORCES = (0.0, -0.2, -0.6)

def half(a):
    return 0.5 * a

def both(a):
    return a, -a


@law(state={"calls": 0, "last": 0.0, "ring": (0.0, 0.0, 0.0)})
def force(p, s, x, v, dt):
    push, i = 0.0, 1
"""
LINES = [
    *(example for *_, example in [*reference.GIVEN, *reference.STATEMENTS, *reference.DIFFERENCES]),
    *(one.example for one in [*subset.MATH.values(), *subset.BUILTINS.values()]),
    *(f"push = x {sign} 2.0" for sign, _ in subset.OPERATORS.values()),
    *(f"push = 1.0 if x {sign} 0.0 else 2.0" for sign in subset.COMPARISONS.values()),
    *(f"push = math.{name}" for name in subset.MATH_CONSTANTS),
]


@pytest.fixture(scope="module")
def page():
    return reference.page()


def test_the_page_in_the_documentation_is_up_to_date(page):
    assert reference.PAGE.read_text(encoding="utf-8") == page, "python -m hapkit_studio.laws.reference"


def test_every_function_constant_operator_and_mistake_is_on_the_page(page):
    for name, one in subset.MATH.items():
        assert re.search(rf"^\| `math\.{name}` \| .+ \| .+ \| `{re.escape(one.example)}` \|$", page, re.M)
        assert f"math.{name}(" in one.example
    for name, one in subset.BUILTINS.items():
        assert f"| `{name}` | " in page
        assert f"{name}(" in one.example
    for name in subset.MATH_CONSTANTS:
        assert f"`math.{name}`" in page
    for sign, _ in subset.OPERATORS.values():
        assert f"| `{sign}` | " in page
    cells = page.replace("\\|", "|")
    for mistake in MISTAKES:
        assert f"| `{mistake.wrong}` | {mistake.example} |" in cells
    assert f"| values in the state | {MAX_STATE} |" in page


@pytest.mark.parametrize("line", LINES)
def test_every_example_of_a_line_compiles(line, tmp_path):
    law = module(tmp_path, BESIDE + f"    {line}\n    return push\n").force
    law.bind(PARAMETERS)
    compile_for_board(law, {p.key: p.default for p in PARAMETERS}, 1e-3)


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```$", page, re.M | re.S)


def test_every_example_of_a_law_compiles_for_loop_and_board_and_none_drifts(page, tmp_path):
    file, *laws = blocks(page)
    assert len(laws) == 5
    for text in laws:
        law = module(tmp_path, text).force
        law.bind(PARAMETERS)
        law.compiled()
        compile_for_board(law, {p.key: p.default for p in PARAMETERS}, 1e-3)
        assert law.remarks == ()
    verdict = trying.try_out(typed(tmp_path / "clicking_wall.py", file))
    assert verdict.problems == verdict.warnings == verdict.remarks == ()


def test_every_accepted_node_type_has_an_example(page):
    trees = [ast.parse(text) for text in blocks(page)]
    trees += [ast.parse(f"def f():\n for n in m:\n  {line}") for line in LINES]
    shown = {type(node).__name__ for tree in trees for node in ast.walk(tree)}
    taken = {name.removeprefix("visit_") for name in vars(Rewriter) if name.startswith("visit_")}
    assert taken <= shown


def test_the_pages_example_file_can_be_read(page, tmp_path):
    made = reading.load_source(typed(tmp_path / "clicking_wall.py", blocks(page)[0]))
    assert [p.key for p in made.parameters] == ["stiffness", "side"]

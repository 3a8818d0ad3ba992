"""What a law sets once for what is written by hand for the board, and what in every tick."""

import ast
import re

import pytest

from hapkit_studio.laws.cpp import CppLaw
from hapkit_studio.laws.cpp_taken import taken_over
from hapkit_studio.parameters import Choice, Parameter
from tests.laws.law_files import environment

PARAMETERS = (
    Parameter("mass", "Mass", "kg", 0.5, 0.05, 5.0),
    Parameter("other", "Other mass", "kg", 1.5, 0.05, 5.0),
    Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 2000.0),
    Parameter("rest", "Rest position", "m", 0.01, -0.04, 0.04),
    Parameter("contact", "Contact", "N/m", 500.0, 50.0, 5000.0),
    Choice("method", "Method", ("euler", "lecture", "semi_implicit", "verlet"), "semi_implicit"),
)
BESIDE = """
from hapkit_studio.dynamics.integrators import step
from hapkit_studio.dynamics.moving_mass import FAR, reaction
"""
STATE = {"x": 0.01, "v": 0.0, "a": 0.0, "hand": 0.0, "speed": 0.0}
ARGUMENTS = {
    "method": "p.method", "x": "s.x", "v": "s.v", "before": "s.a", "h": "dt", "friction": "0.0",
    "m": "p.mass", "b": "1.0", "k": "p.stiffness", "f": "p.stiffness * p.rest", "touch": "s.hand",
    "side": "1.0", "speed": "s.speed", "contact": "p.contact", "pad": "0.0", "reach": "FAR", "wall": "0.0",
}  # fmt: skip
"""A call of step; the same names are those of reaction's arguments."""
PUSH = ("x", "v", "touch", "side", "speed", "contact", "pad")
MOVING = {"x", "v", "before", "h", "touch", "speed"}
"""What moves from tick to tick in that call."""


def moved(state="s.x, s.v, s.a", **changed):
    """Return a statement that moves a mass, some arguments changed."""
    return f"{state} = step({', '.join((ARGUMENTS | changed).values())})"


def push(**changed):
    """Return the words of the push on the handle where it is now."""
    given = ARGUMENTS | {"touch": "x", "speed": "v"} | changed
    return f"reaction({', '.join(given[name] for name in PUSH)})"


def text(*body, state=STATE, beside=BESIDE):
    """Return the file of a law that begins with these statements."""
    lines = [beside, f"@law(state={state})", "def force(p, s, x, v, dt):", *(f"    {line}" for line in body)]
    return "\n".join(lines) + "\n"


def one_mass(*before, **changed):
    """Return the file of a law of one mass."""
    return text(*before, moved(**changed), "s.hand = x", "s.speed = v", f"return -{push()}")


def taken(folder, words):
    """Return what is taken over in the law of a file: each argument's name and the words of its value."""
    made = CppLaw(environment(folder, words, PARAMETERS).force, "own")
    helpers = made.program.helpers
    found = taken_over(made.program.law, helpers, made.alone.kept)
    return {name: ast.unparse(value) for name, value in found.items()}


def test_what_the_parameters_alone_decide_is_taken_over(tmp_path):
    found = taken(tmp_path, one_mass())
    assert set(found) == set(ARGUMENTS) - MOVING
    places = {p.key: f"p[{n}]" for n, p in enumerate(PARAMETERS)}
    assert found["m"] == places["mass"]
    assert found["f"] == f"{places['stiffness']} * {places['rest']}"
    assert found["b"] == "1.0"


@pytest.mark.parametrize(
    "words", ["-p.stiffness", "p.stiffness + p.contact", "2.0 - p.rest * p.contact", "-3.0"]
)
def test_sums_products_and_signs_of_parameters_are_taken_over(tmp_path, words):
    assert "f" in taken(tmp_path, one_mass(f=words))


@pytest.mark.parametrize(
    "words",
    ["p.stiffness * s.x", "x", "-v", "p.rest + dt", "p.stiffness / p.mass", "pull", "abs(p.rest)",
     "p.rest if x > 0.0 else p.mass"],
)  # fmt: skip
def test_what_else_a_value_is_made_of_is_set_in_every_tick(tmp_path, words):
    found = taken(tmp_path, one_mass("pull = p.stiffness", f=words))
    assert set(found) == set(ARGUMENTS) - MOVING - {"f"}


def test_what_two_calls_set_differently_is_set_in_every_tick(tmp_path):
    two = text(moved(), moved(m="p.other", side="-1.0"), f"return -{push(pad='2.0')}")
    assert set(taken(tmp_path, two)) == set(ARGUMENTS) - MOVING - {"m", "side", "pad"}


def test_a_law_whose_own_function_moves_the_mass_takes_nothing_over(tmp_path):
    beside = f"{BESIDE}\n\ndef pushed(x, v, rest):\n    return reaction(x, v, rest, 1.0, 0.0, 500.0, 0.0)\n"
    law = text(moved(), "return -pushed(s.x, s.v, x)", beside=beside)
    assert taken(tmp_path, law) == {}


def test_a_law_that_moves_no_mass_takes_nothing_over(tmp_path):
    assert taken(tmp_path, text("return -p.stiffness * x")) == {}


def test_what_is_taken_over_is_written_once_where_parameters_may_have_changed(tmp_path):
    made = CppLaw(environment(tmp_path, one_mass(), PARAMETERS).force, "own")
    words = made.text(made.alone)
    once = words.split("if (!laws::current) {")[1].split("  }\n")[0]
    for name in ARGUMENTS:
        inside, everywhere = (len(re.findall(rf"with_{name} =", t)) for t in (once, words))
        assert (inside, everywhere > inside) == ((0, True) if name in MOVING else (1, False)), name

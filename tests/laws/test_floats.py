"""Conversions that a generated law does without: only of what is a float on every path."""

import ast

import pytest

from hapkit_studio.laws.expressions import without_conversions
from tests.laws.law_files import environment, held, law_text

SURE = ["x", "1.0", "-x", "x * flag", "flag / x", "1.0 if flag else x", "abs(x)", "_math.sqrt(flag)", "p[2]"]
SURE += ["_float(flag)", "-1.0", "min(x, 2.0)", "both", "turned"]
UNSURE = ["flag", "x > 0.0", "flag + flag", "1.0 if flag else flag", "abs(flag)", "min(x, flag)", "helper(x)"]
UNSURE += ["not x", "n", "late", "once", "1", "True", "first"]
TEXT = """
def law(p, s, x, v, dt, _fault):
    flag = x > 0.0
    both = x
    both = both + flag
    once, turned = flag, v
    late, first = turned, once
    late = late > x
    first = 2.0
    for n in range(3):
        turned, both = both, turned
    return helper(_float({}))
"""


def generated(expression):
    """Return the expression that is handed over at the end, as it is left."""
    tree = without_conversions(ast.parse(TEXT.format(expression)).body[0])
    return ast.unparse(tree.body[-1].value.args[0])


@pytest.mark.parametrize("expression", SURE)
def test_a_float_is_not_converted(expression):
    assert generated(expression) == ast.unparse(ast.parse(expression))


@pytest.mark.parametrize("expression", UNSURE)
def test_what_may_be_no_float_is_converted(expression):
    assert generated(expression) == f"_float({expression})"


def test_constants_are_left_to_the_compiled_law():
    assert generated("_float(-1.0) ** _float(0.5)") == "_float(-1.0) ** _float(0.5)"
    assert generated("_float(x) ** _float(0.5)") == "x ** 0.5"


HELPERS = """
def half(a):
    a = a / 2
    return a


def several(a):
    b = a > 0
    return b, half(b)
"""


def test_a_truth_value_arrives_in_a_helper_as_a_number(tmp_path):
    body = "a, b = several(x > 0)\nc = half(x < 0)\nreturn a + 10 * b + 100 * c + half(x > 0)"
    assert set(held(environment(tmp_path, law_text(body, beside=HELPERS))).force) == {1.0 + 5.0 + 0.0 + 0.5}

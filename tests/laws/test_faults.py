"""A fault inside a law raises no exception and does not hang.

It is latched with its line, and the force is zero.
"""

import textwrap
from functools import cache

import numpy as np
import pytest

from hapkit_studio import simulate
from hapkit_studio.dynamics.hand import Prescribed
from tests.laws.law_files import HEAD, environment, held, law_text, line_of
from tests.wide import wide

WRONG_INDEX = ("3", "-1", "x * 1e9", "-0.5", "1e300", "math.log(0.0)", "math.sqrt(-x)")
USES = ("return 5.0 + s.ring[{}]", "s.ring[{}] = 7.0\nreturn 5.0", "s.ring[{}] += 7.0\nreturn 5.0")
NEVER_ENDS = [
    "for i in range(1000000000):\n    a = i",
    "for i in range(-1000000000, 2000000000):\n    pass",
    "for i in range(19000):\n    for j in range(1000000000):\n        pass",
    "for i in range(3):\n    for j in range(100000):\n        if j > 30000:\n            break",
    "for i in range(15000):\n    a = slow(x)",
    "a = doubled_5(x)",
    "for i in range(19000):\n    for j in range(19000):\n        for k in range(19000):\n            pass",
]
NAN = ("math.sqrt(-x)", "(-1.0) ** 0.5", "int(math.sqrt(-x))")
INFINITY = (
    *("math.log(0.0)", "math.exp(1e9)", "1e300 * 1e300", "10.0 ** 1000.0", "0.0 ** -1"),
    "(x < 0) ** -(x > 0)",
)
BY_ZERO = ("1.0 / (x - x)", "0.0 / (x - x)", "x // 0.0", "x % 0.0", "math.fmod(x, 0.0)", "(x > 0) // (x < 0)")
BEYOND = "line {} of the law uses an index outside the state"
# columns: a body, the message (its {} is the line number), and words of the faulty line
CASES = [
    *[(USES[0].format(i), BEYOND, "s.ring") for i in WRONG_INDEX],
    *[(use.format("int(-math.log(0.0))"), BEYOND, "s.ring") for use in USES[1:]],
    *[(f"{loop}\nreturn 5.0", "of the law does not end", "") for loop in NEVER_ENDS],
    *[(f"return {value}", "the law returned NaN (not a number) at x = 10.00 mm", "") for value in NAN],
    *[(f"return {value}", "the law returned infinity at x = 10.00 mm", "") for value in INFINITY],
    # these faults latch even if later code would hide them
    *[
        (f"b = {value}\nreturn 1.0", "line {} of the law divides by zero at x = ", "b = ")
        for value in (*BY_ZERO, "min(1.0, 1.0 / (x - x))")
    ],
    ("b = quotient(x - x)\nreturn 1.0", "line {} of the law divides by zero at x = ", "return 1.0 / a"),
    # the reported line has the first non-finite value, not the return statement
    ("a = 1.0\nb = math.sqrt(-a)\nreturn b + 1.0", "(line {})", "b = "),
    ("a = 1e300\nb = a * a\nreturn b", "(line {})", "return b"),
]
# doubled_5() causes 4 ** 5 calls, each with a loop, although every function alone is below the limits
BESIDE = (
    "def quotient(a):\n    return 1.0 / a\n"
    "def slow(a):\n    for i in range(15000):\n        a = a + 1.0\n    return a\n"
    "def doubled_0(a):\n    for i in range(15000):\n        a = a + 1.0\n    return a\n"
) + "".join(
    f"def doubled_{n}(a):\n    return " + " + ".join([f"doubled_{n - 1}(a)"] * 4) + "\n" for n in range(1, 6)
)
# quick tests use the first case of each message
FIRST = sorted({message: n for n, (_, message, _) in reversed(list(enumerate(CASES)))}.values())


def text_of(cases):
    """Return one law for several cases, to save compile time; the damping's value selects the case."""
    branches = [f"if p.damping == {n}.0:\n" + textwrap.indent(CASES[n][0], "    ") for n in cases]
    return law_text(
        "\n".join(branches) + "\nreturn 1.0 / (1.0 + math.exp(1e5 * x))",
        "{'ring': (0.0, 0.0, 0.0), 'last': 0.0}",
        BESIDE,
    )


@pytest.fixture(scope="module")
def laws(tmp_path_factory):
    @cache
    def made(quick):
        text = text_of(FIRST if quick else range(len(CASES)))
        return environment(tmp_path_factory.mktemp("faults"), text), text

    return made


@pytest.mark.parametrize(
    "case",
    wide(range(len(CASES)), FIRST.__contains__),
    ids=[body for body, *_ in CASES],
)
def test_a_fault_at_the_first_sample_latches_without_force(laws, case, capfd):
    _, message, where = CASES[case]
    law, text = laws(case in FIRST)
    lines = (HEAD + text).splitlines()
    (fault,) = (run := held(law, damping=float(case))).faults
    start = lines.index(f"    if p.damping == {case}.0:")
    line = next((n for n, code in enumerate(lines, 1) if n > start and where in code), line_of(text, where))
    assert message.format(line) in fault
    if "does not end" in message:
        assert lines[int(fault.split("line ")[1].split()[0]) - 1].strip().startswith(("for ", "def "))
    assert not run.applied_force.any()
    assert not run.force[1:].any()
    assert capfd.readouterr() == ("", "")


def test_non_finite_intermediate_values_are_not_a_fault(laws):
    assert held(laws(True)[0], damping=-1.0).faults == ()


def test_a_fault_during_a_run_ends_the_force_there(tmp_path):
    text = law_text("return math.log(x < 0.02) + 1.0")
    run = simulate(environment(tmp_path, text), hand=Prescribed(lambda t: 0.1 * t), seconds=0.4)
    first = int(np.flatnonzero(run.position >= 0.02)[0])
    assert np.all(run.applied_force[:first] == 1.0)
    assert not run.applied_force[first:].any()
    assert "infinity at x = 20." in run.faults[0]

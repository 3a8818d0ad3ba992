"""What goes wrong inside a law raises nothing and hangs nothing: it latches, with its line, and no force."""

import numpy as np
import pytest

from hapkit_studio import simulate
from hapkit_studio.dynamics.hand import Prescribed
from tests.laws.law_files import HEAD, environment, held, law_text, line_of

RING = "{'ring': (0.0, 0.0, 0.0), 'last': 0.0}"
WRONG_INDEX = ["3", "-1", "x * 1e9", "-0.5", "1e300", "math.log(0.0)", "math.sqrt(-x)"]
USES = ["return 5.0 + s.ring[{}]", "s.ring[{}] = 7.0\nreturn 5.0", "s.ring[{}] += 7.0\nreturn 5.0"]
NEVER_ENDS = [
    "for i in range(1000000000):\n    a = i",
    "for i in range(-1000000000, 2000000000):\n    pass",
    "for i in range(19000):\n    for j in range(1000000000):\n        pass",
    "for i in range(3):\n    for j in range(100000):\n        if j > 30000:\n            break",
    "for i in range(15000):\n    a = slow(x)",
    "a = doubled_5(x)",
    "for i in range(19000):\n    for j in range(19000):\n        for k in range(19000):\n            pass",
]
# 4 ** 5 calls, and loops called from loops, each of which alone stays below any limit
FAN = "def doubled_0(a):\n    for i in range(15000):\n        a = a + 1.0\n    return a\n" + "".join(
    f"def doubled_{n}(a):\n    return " + " + ".join([f"doubled_{n - 1}(a)"] * 4) + "\n" for n in range(1, 6)
)
SLOW = "def slow(a):\n    for i in range(15000):\n        a = a + 1.0\n    return a\n"


def assert_faulted(run, words):
    """The first sample latches, in words; no force leaves it, then or later."""
    assert len(run.faults) == 1
    assert words in run.faults[0]
    assert not run.applied_force.any()
    assert not run.force[1:].any()


@pytest.mark.parametrize(
    ("index", "use"), [(i, USES[0]) for i in WRONG_INDEX] + [("int(-math.log(0.0))", use) for use in USES[1:]]
)
def test_an_index_out_of_range_faults_on_its_line(tmp_path, index, use):
    text = law_text("a = 1.0\n" + use.format(index), RING)
    run = held(environment(tmp_path, text))
    assert_faulted(run, f"line {line_of(text, 's.ring')} of the law reaches beyond its state")


@pytest.mark.parametrize("loop", NEVER_ENDS)
def test_a_loop_without_end_faults_on_its_line(tmp_path, loop):
    text = law_text(loop + "\nreturn 5.0", RING, SLOW + FAN)
    made = environment(tmp_path, text)
    run = held(made)
    assert_faulted(run, "of the law does not come to an end")
    line = int(run.faults[0].split("line ")[1].split()[0])
    assert (HEAD + text).splitlines()[line - 1].strip().startswith(("for ", "def "))


NOT_FINITE = {
    "NaN": ("math.sqrt(-x)", "(-1.0) ** 0.5", "int(math.sqrt(-x))"),
    "infinity": (
        *("math.log(0.0)", "math.exp(1e9)", "1e300 * 1e300", "10.0 ** 1000.0", "0.0 ** -1"),
        "(x < 0) ** -(x > 0)",
    ),
}


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in NOT_FINITE.items() for v in values])
def test_what_is_not_finite_raises_nothing_and_latches(tmp_path, value, name, capfd):
    made = environment(tmp_path, law_text(f"return {value}"))
    run = held(made)
    assert name in run.faults[0]
    assert "at x = 10." in run.faults[0] or "at x = 9.9" in run.faults[0]
    assert_faulted(run, "the law returned")
    assert capfd.readouterr() == ("", "")


BY_ZERO = ("1.0 / (x - x)", "0.0 / (x - x)", "x // 0.0", "x % 0.0", "math.fmod(x, 0.0)", "(x > 0) // (x < 0)")


@pytest.mark.parametrize("value", [*BY_ZERO, "quotient(x - x)", "min(1.0, 1.0 / (x - x))"])
def test_a_division_by_zero_faults_on_its_line(tmp_path, value):
    """Even where what comes after would hide it."""
    text = law_text(f"a = 1.0\nb = {value}\nreturn 1.0", beside="def quotient(a):\n    return 1.0 / a\n")
    line = line_of(text, "return 1.0 / a" if "quotient" in value else "b = ")
    assert_faulted(held(environment(tmp_path, text)), f"line {line} of the law divides by zero at x = ")


def test_a_number_that_is_lost_on_the_way_is_told_with_its_line(tmp_path):
    """The first value that was not finite, not the line that returns it; a harmless one is no fault."""
    text = law_text("a = 1.0\nb = math.sqrt(-a)\nreturn b + 1.0")
    assert f"(line {line_of(text, 'b = ')})" in held(environment(tmp_path, text)).faults[0]
    text = law_text("a = 1e300\nb = a * a\nreturn b")
    assert f"(line {line_of(text, 'return b')})" in held(environment(tmp_path, text)).faults[0]
    text = law_text("return 1.0 / (1.0 + math.exp(1e5 * x))")
    assert held(environment(tmp_path, text)).faults == ()


def test_a_fault_in_the_middle_ends_the_force_there(tmp_path):
    text = law_text("return math.log(x < 0.02) + 1.0")
    run = simulate(environment(tmp_path, text), hand=Prescribed(lambda t: 0.1 * t), seconds=0.4)
    first = int(np.flatnonzero(run.position >= 0.02)[0])
    assert np.all(run.applied_force[:first] == 1.0)
    assert not run.applied_force[first:].any()
    assert "infinity at x = 20." in run.faults[0]

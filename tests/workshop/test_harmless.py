"""A file is harmless only where nothing but the listed can happen; every known way round is refused."""

import sys

import pytest

from hapkit_studio.workshop.reading import is_harmless
from tests.workshop.refused import BODY, TOP
from tests.workshop.student import END, HEAD, text

CLAMP = """
LOW = -1.0
HIGH = 2 * -LOW + math.pi


def clamp(a, low, high):
    'Keep within.'
    return min(max(a, low), high)
"""
CHECK = """
def check(values):
    if values["mass"] == 0.0:
        return "no mass"
    return ""


ENVIRONMENT"""
RING = "s.a += v * dt\nfor i in range(3):\n    s.r[i] = s.a\nreturn s.r[0]"
# what a beginner may write, and is let through
PLAIN = [
    text(),
    text("return -math.sin(math.pi * x) * p.stiffness"),
    text("a, b = 1.0, 2.0\nreturn a * b"),
    text(RING, '{"a": 0.0, "r": (0.0, 1, -2)}'),
    text("return abs(x) ** 2 if p.side == 'right' else clamp(x, LOW, HIGH)", "", CLAMP),
    text("return later(x)") + "\n\ndef later(a):\n    return a\n",
    text().replace("force=force", "force=force, impedance=lambda p: (p['stiffness'], 0.0)"),
    text().replace("force=force", "force=force, check=check").replace("ENVIRONMENT", CHECK),
    text(beside="from hapkit_studio.dynamics.friction import tether\n"),
]


@pytest.mark.parametrize("whole", PLAIN)
def test_plain_files_are_harmless(whole):
    assert is_harmless(whole)


@pytest.mark.parametrize("line", TOP)
def test_nothing_else_at_top_level(line):
    assert is_harmless(text(beside="A_1 = 1\n"))
    assert not is_harmless(text(beside=line + "\n"))


CHECKING = END.replace("force=force", "force=force, check=f")
START = "def f(a):\n    b = 0.0\n    if a:\n        b = a['x'] + a.y\n    return b + math.sin(1) + abs(2)\n"


@pytest.mark.parametrize("body", BODY)
def test_nothing_else_in_a_function(body):
    assert is_harmless(text(beside=START, end=CHECKING))
    assert not is_harmless(text(beside=f"def f(a):\n    {body}\n", end=CHECKING))
    through = CHECKING.replace("check=f", "impedance=lambda p: g(p)")
    between = "def g(a):\n    return f(a)\n"
    assert is_harmless(text(beside=START + between, end=through))
    assert not is_harmless(text(beside=f"def f(a):\n    {body}\n" + between, end=through))


@pytest.mark.parametrize("body", BODY)
def test_a_law_and_what_only_laws_call_is_never_executed_as_python(body):
    """What it may not hold is said by the law language, with its line."""
    assert is_harmless(text(body.replace("\n    ", "\n")))
    assert is_harmless(text("return f(x)", beside=f"def f(a):\n    {body}\n"))


@pytest.mark.skipif(sys.version_info < (3, 12), reason="types of functions are younger")
def test_no_types_of_functions():
    assert not is_harmless(text(beside="def f[T: open('a')](a):\n    return a\n"))


FAILING = [
    "A = LATER\nLATER = 1",
    "A = Environment(key='b')",
    "A = undefined * 3",
    "A = Parameter()",
    "A = 1 / 0",
]


@pytest.mark.parametrize("line", FAILING)
def test_what_can_only_fail_is_harmless(line):
    assert is_harmless(text(beside=line + "\n"))


@pytest.mark.parametrize("whole", ["", HEAD, "x = (", "\0", "(" * 300, "return 1", "open('a')\nx = 1 +"])
def test_what_is_nothing_or_cannot_be_read_is_harmless(whole):
    assert is_harmless(whole)


@pytest.mark.parametrize("whole", [f"x = {'-' * 500}1", text() * 2, "x = " + " + ".join("1" * 5000)])
def test_what_is_nested_too_deep_or_said_twice_is_not(whole):
    assert not is_harmless(whole)

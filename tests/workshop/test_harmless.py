"""A file is harmless only where nothing but the listed can happen; every known way round is refused."""

import pytest

from hapkit_studio.workshop.reading import is_harmless
from tests.workshop.student import HEAD, text

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


# a file's first lines, or what stands at its top level
TOP = [
    "import os",
    "import math, os",
    "import math as law",
    "from os import system",
    "from os import *",
    "from math import *",
    "from hapkit_studio.laws import *",
    "from hapkit_studio import devices",
    "from hapkit_studio.laws import native",
    "from hapkit_studio.laws import law as Parameter",
    "from hapkit_studio.dynamics import jit",
    "from hapkit_studio.dynamics.jit import shutil",
    "from hapkit_studio.dynamics.jit import find_cache",
    "from hapkit_studio.dynamics.friction import math",
    "from hapkit_studio.dynamics.hand import np",
    "from hapkit_studio.dynamics..hand import press",
    "from .os import path",
    "from . import evil",
    "import hapkit_studio.__main__",
    "print('hello')",
    "open('a', 'w')",
    "eval('1')",
    "__import__('os')",
    "A = __import__('os')",
    "A = __builtins__",
    "A = open",
    "A = math.factorial(100000)",
    "A = math.__loader__",
    "A = math.inf.__class__",
    "A = 'a' * 10**10",
    "A = 9 ** 9 ** 9",
    "A = 1 << 100",
    "A = 'x'\nB = A * 3",
    "A = (1,)\nB = A * 3",
    "A = [x for x in range(3)]",
    "A = {1: 2}",
    "A = f'{1}'",
    "A = lambda x=open('a'): x",
    "A = lambda *a: a",
    "A = lambda: open('a')",
    "A = lambda p: p.__class__",
    "A = (B := 3)",
    "A: int = 3",
    "A: open('a') = 3",
    "A = B = 3",
    "A, B = 1, 2",
    "math.pi = 3",
    "law = 3",
    "math = 3",
    "abs = 3",
    "__name__ = 'x'",
    "A += 1",
    "del math",
    "assert open('a')",
    "raise SystemExit",
    "if True:\n    import os",
    "for i in range(3):\n    pass",
    "while True:\n    pass",
    "with open('a') as f:\n    pass",
    "try:\n    import os\nexcept ImportError:\n    pass",
    "class A:\n    import os",
    "async def f():\n    pass",
    "global A",
    "def f(a=open('a')):\n    return a",
    "def f(*, a=open('a')):\n    return a",
    "def f(*a):\n    return a",
    "def f(**a):\n    return a",
    "def f(a, /):\n    return a",
    "def f(a: open('a')):\n    return a",
    "def f(a) -> open('a'):\n    return a",
    "def law(f):\n    return f",
    "def abs(a):\n    return a",
    "def Parameter(a):\n    return a",
    "def __getattr__(name):\n    return name",
    "@open\ndef f(a):\n    return a",
    "@law(open('a'))\ndef f(a):\n    return a",
    "@law(state=open('a'))\ndef f(a):\n    return a",
    "@law(state={'a': open('a')})\ndef f(a):\n    return a",
    "@law(state={**open('a')})\ndef f(a):\n    return a",
    "@law(state=dict(a=1))\ndef f(a):\n    return a",
    "@law\n@open\ndef f(a):\n    return a",
    "@(lambda f: f)\ndef f(a):\n    return a",
    "@law.x\ndef f(a):\n    return a",
    "A = Parameter(*open('a'))",
    "A = Parameter(**open('a'))",
    "A = Parameter(open('a'))",
    "A = Parameter(key=open('a'))",
    "A = Parameter(__class__=1)",
    "A = Parameter('a').check",
    "A = Environment(key='b')",
    "ENVIRONMENT = Environment(key='b')",
    "A = law(open)",
    "A = LATER\nLATER = 1",
]


@pytest.mark.parametrize("line", TOP)
def test_nothing_else_at_top_level(line):
    assert is_harmless(text(beside="A_1 = 1\n"))
    assert not is_harmless(text(beside=line + "\n"))


# what stands in a function that the studio calls
BODY = [
    "return open('a')",
    "return open",
    "return eval('1')",
    "return __import__('os')",
    "return a.__class__",
    "return a._private",
    "return a.b.c",
    "return a.read()",
    "return a['b'].c",
    "return a[0](1)",
    "return a(1)",
    "return f.__globals__",
    "return f(1).x",
    "return (lambda: 1)()",
    "return max(a, key=open)",
    "return max(*a)",
    "return print(1)",
    "return getattr(a, 'b')",
    "return math.factorial(99999)",
    "return math.__loader__",
    "return a ** a",
    "return 9 ** 9 ** 9",
    "return [1]",
    "return {1}",
    "return {1: 2}",
    "return f'{a}'",
    "return [b for b in a]",
    "return sum(b for b in a)",
    "return a[1:2]",
    "return (b := 1)",
    "return undefined",
    "return Environment(a)",
    "return law(a)",
    "return int.from_bytes(a)",
    "a.b = 1\n    return 1",
    "a.b += 1\n    return 1",
    "math.pi = 3\n    return 1",
    "f.x = 3\n    return 1",
    "a **= 99999\n    return 1",
    "abs = a\n    return abs(1)",
    "f = a\n    return f(1)",
    "__x = 1\n    return 1",
    "b: open('a') = 1\n    return 1",
    "global math\n    math = 1\n    return 1",
    "import os\n    return 1",
    "while True:\n        pass",
    "for b in a:\n        pass\n    return 1",
    "for b in range(a):\n        pass\n    return 1",
    "for f in range(3):\n        pass\n    return f(1)",
    "for a.b in range(3):\n        pass\n    return 1",
    "for b in range(3):\n        pass\n    else:\n        open('a')\n    return 1",
    "if open('a'):\n        return 1\n    return 2",
    "if a:\n        return 1\n    elif open('a'):\n        return 2\n    return 3",
    "with open('a') as b:\n        return 1",
    "try:\n        return 1\n    except open('a'):\n        return 2",
    "raise SystemExit",
    "assert open('a')\n    return 1",
    "del a\n    return 1",
    "yield a",
    "def g():\n        return 1\n    return g()",
    "class G:\n        pass\n    return 1",
    "return lambda: 1",
]


@pytest.mark.parametrize("body", BODY)
def test_nothing_else_in_a_function(body):
    start = (
        "def f(a):\n    b = 0.0\n    if a:\n        b = a['x'] + a.y\n    return b + math.sin(1) + abs(2)\n"
    )
    assert is_harmless(text(beside=start))
    assert not is_harmless(text(beside=f"def f(a):\n    {body}\n"))


@pytest.mark.parametrize(
    "whole",
    [
        "",
        HEAD,
        "x = (",
        "\0",
        "(" * 300,
        "x = " + "-" * 5000 + "1",
        text() + "\nENVIRONMENT = 1\n",
        text() * 2,
    ],
    ids=["empty", "no environment", "unreadable", "null", "brackets", "deep", "twice", "doubled"],
)
def test_what_cannot_be_judged_is_not_harmless(whole):
    assert not is_harmless(whole)

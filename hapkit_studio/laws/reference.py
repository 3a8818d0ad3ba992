"""The reference page of the law language, generated from the tables of the checker.

``python -m hapkit_studio.laws.reference`` writes the page to the documentation; the editor shows it with F1.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path
from string import Template

from hapkit_studio.laws import machine, subset
from hapkit_studio.laws.law import MAX_PARAMETERS, MAX_STATE
from hapkit_studio.laws.mistakes import MISTAKES
from hapkit_studio.laws.translate import FUEL

PAGE = Path(__file__).resolve().parents[2] / "assets" / "docs" / "law-language.md"

FILE = '''\
"""A wall that clicks: this text is for readers."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

CLICK = (0.0, 0.3, 0.5, 0.3, 0.0)  # a table: force in N, every 0.5 mm


@law(state={"touches": 0, "inside": False})
def force(p, s, x, v, dt):
    depth = x - 0.005 if p.side == "right" else -x - 0.005
    if depth > 0.0 and not s.inside:
        s.touches += 1
    s.inside = depth > 0.0
    if depth <= 0.0:
        return 0.0
    place = min(int(depth / 0.0005), len(CLICK) - 1)
    push = p.stiffness * depth + CLICK[place]
    return -push if p.side == "right" else push


ENVIRONMENT = Environment(
    key="clicking_wall",
    title="Clicking wall",
    summary="A wall with a click",
    parameters=(
        # name in the law, label, unit, default, lowest, highest
        Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 2000.0),
        Choice("side", "Side", ("right", "left")),
    ),
    force=force,
)
'''
GIVEN = (
    ("`x`", "position of the handle in m, positive to the right", "depth = x - 0.005"),
    ("`v`", "velocity of the handle in m/s", "push = -p.damping * v"),
    ("`dt`", "time in s from one call of the law to the next", "step = v * dt"),
    ("`p.name`", "a parameter, set by its slider", "push = -p.stiffness * x"),
    (
        "`p.name`",
        "a choice, which is compared with the name of an option",
        'side = 1.0 if p.side == "right" else -1.0',
    ),
    ("`s.name`", "a value of the state, which the law remembers until its next call", "s.calls += 1"),
    ("`s.name[i]`", "one value of a state with several values", "s.ring[i] = x"),
    ("`NAME`", "a number at the top of the file", "push = GAIN * x"),
    ("`NAME[i]`", "a number of a table at the top of the file", "push = FORCES[i]"),
)
STATEMENTS = (
    ("set a name", "push = 1.0"),
    ("set several names", "push, rate = 1.0, v"),
    ("change a name", "push *= 2.0"),
    ("branch", "if x > 0.0: push = 1.0"),
    ("choose a value", "push = 1.0 if x > 0.0 else 2.0"),
    ("combine tests: `and`, `or`, `not`", "inside = x > 0.0 and not v > 1.0"),
    ("compare with two limits", "inside = 0.0 < x < 0.005"),
    ("loop over a constant range", "for k in range(TURNS): push += 0.1"),
    ("leave a loop", "for k in range(len(FORCES) - 1): break"),
    ("continue with the next iteration", "for k in range(3): continue"),
    ("call a helper: a function above the law", "push = half(x)"),
    ("use several results of a helper", "push, rate = both(x)"),
    ("do nothing", "pass"),
    ("end the law with its force in N", "return -p.stiffness * x"),
)
STATE = """\
@law(state={"calls": 0, "ring": (0.0, 0.0, 0.0)})  # 4 numbers
def force(p, s, x, v, dt):
    s.calls += 1
    s.ring[s.calls % len(s.ring)] = x
    return -p.stiffness * (s.ring[0] + s.ring[1] + s.ring[2]) / 3
"""
TABLE = """\
FORCES = (0.0, -0.2, -0.6, -1.1, -0.9, -0.4)  # N, every 2 mm from 0


@law
def force(p, s, x, v, dt):
    place = x / 0.002
    if place < 0.0 or place >= len(FORCES) - 1:
        return 0.0
    i = math.floor(place)
    share = place - i
    return FORCES[i] * (1.0 - share) + FORCES[i + 1] * share
"""
HELPER = """\
def wall(depth, stiffness, damping=0.0, rate=0.0):
    if depth <= 0.0:
        return 0.0
    return stiffness * depth + damping * max(rate, 0.0)


@law
def force(p, s, x, v, dt):
    return wall(-x - 0.01, p.stiffness) - wall(x - 0.01, p.stiffness, p.damping, v)
"""
CLOCK = """\
@law(state={"calls": 0, "touched": -1e6, "inside": False})
def force(p, s, x, v, dt):
    s.calls += 1
    contact = x >= 0.015
    if contact and not s.inside:
        s.touched = s.calls
    s.inside = contact
    since = (s.calls - s.touched) * dt  # subtract first: whole numbers are exact
    if contact and since < 0.1:
        return 0.5 * math.sin(2 * math.pi * 40 * since)
    return 0.0
"""
VIBRATION = """\
@law(state={"calls": 0})
def force(p, s, x, v, dt):
    period = math.floor(1.0 / (p.frequency * dt) + 0.5)  # a whole number of calls
    s.calls = (s.calls + 1) % period
    return 0.3 * math.sin(2 * math.pi * s.calls / period)
"""
DIFFERENCES = (
    ("all numbers are floating-point numbers; `True` is 1.0", "push = 7 // 2 + (x > 0.0)"),
    ("an index must be between 0 and the size minus 1; its fraction is cut off", "push = FORCES[1.7]"),
    (
        "a division by zero is a fault: the force is 0, and the message names the line",
        "push = 1.0 / (abs(x) + 0.001)",
    ),
    (
        "other functions raise no error: `math.sqrt(-1.0)` is NaN (not a number); a force of NaN is a fault",
        "push = math.sqrt(max(0.0, x))",
    ),
    ("a name must have a value in every case before it is used", "push = x if x > 0.0 else 0.0"),
    ("names lose their values after each call, but the state keeps its values", "s.last = x"),
    ("arguments must be given in order, without names", "push = half(x)"),
    ("text can only be compared with a choice", 'push = 1.0 if p.side == "left" else 0.0'),
    ("the board and a sketch compute with 7 digits, the computer with 16", "push = p.stiffness * x"),
)


_TEXT = Template("""\
# The law language

A force law is a Python function that returns the force on the handle in N, positive to the right. The studio
calls this function once in each period of the loop. It compiles the law three times: for the loop, for the
board and for an Arduino sketch. Therefore a law may use only a part of Python. If a line contains something
else, the editor says what is not allowed and what to write instead.

$file

## What a law knows

$given

## Statements

$statements

## Operators

$operators

Comparisons are $comparisons.

## Functions

$functions

Numbers of the module math: $constants. Write `import math` at the top of the file.

## State

The state `s` contains values that the law remembers from one call to the next. Declare the state above the
law with its start values, up to $states numbers in all. The window plots and records these values.

$state

## Tables

A table is a tuple or list at the top of the file, with 1 to $numbers numbers that never change. The index of
the first number is 0, the index of the last number is the size minus 1. Any other index is a fault: the force
is 0, and the message names the line. The board has $arena bytes for a whole law, and each number of a table
needs 4 bytes. If a law needs more bytes, it is refused, and the message states its size. In a sketch, a table
is a `const` array in the program's memory.

$table

## Helpers

A helper is a function in the same file. It can use its arguments, the numbers and tables at the top of the
file, and `math`. If it needs a parameter or a value of the state, pass this value as an argument. A helper
may have default values, return several numbers (`return a, b`) and call other helpers, but not itself.

$helper

## Time

To measure a time, count calls of the law. Do not add up `dt`: the board and the sketch compute with single
precision, so a sum of `dt` is wrong by 3 ms after 10 s, and by seconds after 10 minutes. A count of calls is
exact up to 2²⁴, which is 70 minutes at 4 kHz. Subtract the counts first, then multiply by `dt`:

$clock

The sine of a very long time is inaccurate, too. Therefore let the count start again at 0 after one period:

$vibration

## Limits

$limits

## Differences from Python

$differences

## What to write instead

$mistakes
""")


def page() -> str:
    """Return the page as Markdown."""
    functions = [
        (f"`{prefix}{name}`", _count(one), one.returns, _code(one.example))
        for prefix, known in (("math.", subset.MATH), ("", subset.BUILTINS))
        for name, one in known.items()
    ]
    return _TEXT.substitute(
        file=_block(FILE),
        given=_table(("name", "what it is", "example"), [(a, b, _code(c)) for a, b, c in GIVEN]),
        statements=_table(("to", "example"), [(what, _code(line)) for what, line in STATEMENTS]),
        operators=_table(
            ("operator", "result"), [(f"`{sign}`", what) for sign, what in subset.OPERATORS.values()]
        ),
        comparisons=", ".join(f"`{sign}`" for sign in subset.COMPARISONS.values()),
        functions=_table(("function", "arguments", "returns", "example"), functions),
        constants=", ".join(f"`math.{name}` ({what})" for name, what in subset.MATH_CONSTANTS.items()),
        states=MAX_STATE,
        state=_block(STATE),
        numbers=subset.MOST_IN_TABLE,
        arena=machine.ARENA,
        table=_block(TABLE),
        helper=_block(HELPER),
        clock=_block(CLOCK),
        vibration=_block(VIBRATION),
        limits=_table(("what", "limit"), _limits()),
        differences=_table(("in a law", "example"), [(what, _code(line)) for what, line in DIFFERENCES]),
        mistakes=_table(("written", "message"), [(_code(m.wrong), _escaped(m.example)) for m in MISTAKES]),
    )


def _limits() -> list[tuple[str, str]]:
    return [
        ("parameters", f"{MAX_PARAMETERS}"),
        ("values in the state", f"{MAX_STATE}"),
        ("numbers in a table", f"{subset.MOST_IN_TABLE}, each up to {subset.LARGEST_IN_TABLE:g}"),
        ("iterations of all loops plus calls of helpers, in one call of the law", f"{FUEL:,}"),
        ("`min` and `max`", f"{subset.BUILTINS['min'].most} numbers"),
        ("on the board: values, tables and code", f"{machine.ARENA} bytes"),
        ("on the board: iterations of one loop", f"{0xFFFF:,}"),
        ("on the board: loops inside one another", f"{machine.MOST_COUNTERS}"),
        (
            "on the board: processor cycles in one call, at 4,000 and at 1,000 Hz",
            f"{_cycles(4000):,} and {_cycles(1000):,}; {machine.ESTIMATE} fewer if the law uses `v`",
        ),
    ]


def _cycles(rate: int) -> int:
    """Return the available cycles per call at a rate in Hz, for a load of 80 % of the board's processor."""
    return int((0.8 * 16e6 - 1000 * machine.FRAME) / rate - machine.REST)


def _count(function: subset.Function) -> str:
    fewest, most = function.fewest, function.most
    return f"{fewest}" if fewest == most else f"{fewest} to {most}"


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")


def _code(line: str) -> str:
    return f"`{_escaped(line)}`"


def _block(code: str) -> str:
    return f"```python\n{code}```"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")

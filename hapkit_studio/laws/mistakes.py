"""Frequent mistakes in laws, each with a message that states the correct form.

They are habits from other Python code, from C and from the Arduino IDE. The reference page lists them, and a
test writes each of them into a law.
"""

import re
from dataclasses import dataclass

from hapkit_studio.laws.subset import MATH


@dataclass(frozen=True)
class Mistake:
    """A mistake: an example line and the message.

    ``names`` are undefined names or functions of ``math`` that get this message, in which the name replaces
    ``{}``. ``pattern`` is a regular expression for lines with a syntax error. If both are empty, the checks
    of the language give the message.
    """

    wrong: str
    message: str
    names: tuple[str, ...] = ()
    pattern: str = ""

    @property
    def example(self) -> str:
        return self.message.format(self.names[0]) if self.names else self.message


NOT_CONSTANT = (
    "a loop must count to a constant: `for i in range(10)`, or `range(N)` with `N = 10` above the law"
)

MISTAKES = (
    # functions of ordinary Python
    Mistake("a = round(x)", "`{}` is not in the law language: write `math.floor(a + 0.5)`", ("round",)),
    Mistake(
        "a = sign(x)",
        "`{}` is not in the law language: write `math.copysign(1.0, a)`",
        ("sign", "sgn", "signum"),
    ),
    Mistake("a = bool(x)", "`{}` is not in the law language: write `a != 0.0`", ("bool",)),
    Mistake(
        "print(x)",
        "a law cannot print: store the value in the state, `s.seen = a`, then you see it in a plot",
        ("print",),
    ),
    Mistake("a = sum(x, v)", "a law cannot use `{}`: add the values with `a + b`, or in a loop", ("sum",)),
    Mistake(
        "a = constrain(x, -1.0, 1.0)",
        "`{}` is not in the law language: write `max(low, min(high, a))`",
        ("constrain", "clip", "clamp"),
    ),
    Mistake("a = sq(x)", "`{}` is not in the law language: write `a * a`", ("sq", "square")),
    Mistake(
        "a = sin(x)",
        "`{0}` belongs to the module math: write `math.{0}(a)`",
        ("sin", *(name for name, function in MATH.items() if function.most == 1)),
    ),
    Mistake(
        "a = pow(x, 2)",
        "`{0}` belongs to the module math: write `math.{0}(a, b)`",
        ("pow", *(name for name, function in MATH.items() if function.most == 2)),
    ),
    Mistake(
        "a = math.max(x, v)",
        "`{0}` is not in the law language: write the name without `math.`, as in `max(a, b)`",
        ("math.max", "math.min", "math.abs", "math.int", "math.float"),
    ),
    Mistake(
        "a = np.sin(x)",
        "`{}` is not in the law language: write `math.sin(a)`; instead of an array, write a table above the "
        "law",
        ("np", "numpy"),
    ),
    Mistake(
        "a = random.random()",
        "a law has no random numbers: write a pattern that depends on the position, such as "
        "`math.sin(9000.0 * x)`",
        ("random", "rand"),
    ),
    Mistake(
        "a = time.time()",
        "a law has no clock: count its calls, `s.calls += 1`; the time is `s.calls * dt`",
        ("time", "millis", "micros"),
    ),
    Mistake("a = PI * x", "'{}' is not defined: write `math.pi`", ("PI", "pi", "M_PI", "math.PI")),
    Mistake("a = true", "'{}' is not defined: write `True`", ("true", "TRUE")),
    Mistake("a = false", "'{}' is not defined: write `False`", ("false", "FALSE")),
    Mistake(
        "a = self.last",
        "'{}' is not defined: write `p.name` for a parameter, `s.name` for a value of the state",
        ("self", "this"),
    ),
    Mistake(
        "a = position",
        "'{}' is not defined: write `x` for the position in m, `v` for the velocity in m/s",
        ("position", "velocity", "pos", "vel"),
    ),
    # C and the Arduino IDE
    Mistake("if x > 0.0 && v > 0.0:", "`&&` is C: write `and`", pattern=r"&&"),
    Mistake("if x > 0.0 || v > 0.0:", "`||` is C: write `or`", pattern=r"\|\|"),
    Mistake("if !(x > 0.0):", "`!` is C: write `not`", pattern=r"!(?!=)"),
    Mistake("else if x > 0.0:", "`else if` is C: write `elif`", pattern=r"\belse\s+if\b|\belseif\b"),
    Mistake("s.last++", "`++` is C: write `+= 1`", pattern=r"\w\s*\+\+\s*;?\s*$"),
    Mistake("s.last--", "`--` is C: write `-= 1`", pattern=r"\w\s*--\s*;?\s*$"),
    Mistake("a = x > 0.0 ? 1.0 : 2.0", "`? :` is C: write `a if test else b`", pattern=r"\?"),
    Mistake(
        "if (x > 0.0) {",
        "`{` and `}` are C: write a colon and indent the lines after it",
        pattern=r"\)\s*\{\s*$|\belse\s*\{\s*$|^\s*\}",
    ),
    Mistake(
        "float a = x",
        "a type belongs to C: write only the name, `a = 0.0`",
        pattern=r"^\s*(const\s+)?(unsigned\s+)?(float|double|int|long|bool|byte|u?int\d+_t)\s+\w+\s*=",
    ),
    Mistake("// the wall", "`//` is a comment in C: write `#`", pattern=r"^\s*//|;\s*//"),
    Mistake("a = x ^ 2", "`^` is not a power in Python: write `**`, as in `x ** 2`"),
    # the law language itself
    Mistake("if x = 0.0:", "`=` assigns a value: compare with `==`", pattern=r"^\s*(el)?if\b.*[^=!<>]=[^=]"),
    Mistake(
        "if x > 0.0",
        "a colon is missing at the end of this line",
        pattern=r"^\s*(if|elif|else|for|while|def)\b[^:]*$",
    ),
    Mistake(
        "f = lambda a: 2.0 * a",
        "`lambda` is not allowed in a law: write a function above it, `def f(a):` and `return …`",
    ),
    Mistake(
        "a = half(p)",
        "the arguments of a helper function must be numbers: pass single values instead of `p`, "
        "as in `half(p.stiffness)`",
    ),
    Mistake(
        "a = half(s)",
        "the arguments of a helper function must be numbers: pass single values instead of `s`, "
        "as in `half(s.last)`",
    ),
    Mistake("while x > 0.0: a = 1.0", "`while` is not allowed in a law: use `for i in range(10)`"),
    Mistake(
        "a = [0.0, 1.0]",
        "a list is not allowed in a law: write a table above it, `TABLE = (0.0, 1.0)`, or use the state `s`",
    ),
    Mistake(
        "for a in FORCES: pass",
        "a loop must count: write `for i in range(len(FORCES))`, and `FORCES[i]` in it",
    ),
    Mistake(
        "FORCES[0] = x",
        "`FORCES` is a table and cannot change: store changing values in the state `s`",
    ),
    Mistake("a = FORCES", "`FORCES` is a table: use one of its numbers, `FORCES[i]`"),
    Mistake(
        "a = FORCES[-1]",
        "`FORCES` has 3 numbers: the index must be between 0 and 2; the last is `FORCES[len(FORCES) - 1]`",
    ),
    Mistake("for i in range(x): pass", NOT_CONSTANT),
)

_BY_NAME = {name: one for one in MISTAKES for name in one.names}
_QUOTED = re.compile(r"\"[^\"]*(\"|$)|'[^']*('|$)|#.*")


def instead_of(name: str) -> str | None:
    """Return the message on an undefined name or a function of ``math``; None for other names."""
    for known in (name, name.removeprefix("math.")):
        if known in _BY_NAME:
            return _BY_NAME[known].message.format(known)
    return None


def in_unreadable(line: str) -> str | None:
    """Return the message on a line with a syntax error; None if no known mistake matches."""
    code = _QUOTED.sub("", line)
    return next((m.message for m in MISTAKES if m.pattern and re.search(m.pattern, code)), None)

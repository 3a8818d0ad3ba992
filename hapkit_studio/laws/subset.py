"""The law language: the subset of Python that a force law may use, and messages for everything else.

The language contains arithmetic, comparisons, ``if``, ``for`` over a constant ``range``, the functions of
``MATH`` and ``BUILTINS``, parameters ``p.name``, state ``s.name`` or ``s.name[i]``, tables ``NAME[i]`` and
helper functions of the same file.
"""

import ast
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from hapkit_studio.errors import LawError

ARGUMENTS = ("p", "s", "x", "v", "dt")


class Function(NamedTuple):
    """A function of the law language: number of arguments, return value, an example."""

    fewest: int
    most: int
    returns: str
    example: str


MATH = {
    "sqrt": Function(1, 1, "square root", "rate = math.sqrt(p.stiffness / 0.044)"),
    "sin": Function(1, 1, "sine of an angle in rad", "bump = math.sin(2 * math.pi * x / 0.004)"),
    "cos": Function(1, 1, "cosine of an angle in rad", "slope = math.cos(2 * math.pi * x / 0.004)"),
    "tan": Function(1, 1, "tangent of an angle in rad", "side = x * math.tan(0.3)"),
    "asin": Function(
        1, 1, "arc sine in rad, for a between -1 and 1", "angle = math.asin(min(1.0, abs(x) / 0.05))"
    ),
    "acos": Function(
        1, 1, "arc cosine in rad, for a between -1 and 1", "angle = math.acos(min(1.0, abs(x) / 0.05))"
    ),
    "atan": Function(1, 1, "arc tangent in rad", "angle = math.atan(x / 0.05)"),
    "exp": Function(1, 1, "e to a power", "share = math.exp(-abs(x) / 0.01)"),
    "expm1": Function(1, 1, "exp(a) - 1, exact for small a", "push = math.expm1(abs(x) / 0.01)"),
    "log": Function(1, 1, "natural logarithm", "push = math.log(1.0 + abs(x) / 0.01)"),
    "log1p": Function(1, 1, "log(1 + a), exact for small a", "push = math.log1p(abs(x) / 0.01)"),
    "log10": Function(1, 1, "logarithm to base 10", "level = math.log10(1e-6 + abs(v))"),
    "floor": Function(1, 1, "a rounded down to a whole number", "notch = math.floor(x / 0.004)"),
    "ceil": Function(1, 1, "a rounded up to a whole number", "notch = math.ceil(x / 0.004)"),
    "trunc": Function(1, 1, "a without its fraction, as a whole number", "notch = math.trunc(x / 0.004)"),
    "fabs": Function(1, 1, "absolute value of a, as `abs`", "speed = math.fabs(v)"),
    "sinh": Function(1, 1, "hyperbolic sine", "push = math.sinh(x / 0.02)"),
    "cosh": Function(1, 1, "hyperbolic cosine", "push = math.cosh(x / 0.02)"),
    "tanh": Function(1, 1, "hyperbolic tangent, between -1 and 1", "drag = -0.4 * math.tanh(v / 0.01)"),
    "radians": Function(1, 1, "an angle in degrees, converted to rad", "angle = math.radians(30)"),
    "degrees": Function(1, 1, "an angle in rad, converted to degrees", "turned = math.degrees(x / 0.07)"),
    "atan2": Function(2, 2, "angle of (b, a) in rad, for `atan2(a, b)`", "angle = math.atan2(x, 0.05)"),
    "hypot": Function(2, 2, "square root of a² + b²", "distance = math.hypot(x, 0.01)"),
    "copysign": Function(2, 2, "absolute value of a with the sign of b", "drag = -math.copysign(0.4, v)"),
    "pow": Function(2, 2, "a to the power b, as `a ** b`", "push = math.pow(abs(x) / 0.01, 1.5)"),
    "fmod": Function(
        2, 2, "remainder with the sign of a; with `%`, it has the sign of b", "rest = math.fmod(x, 0.004)"
    ),
}
"""Functions of the module `math`."""
BUILTINS = {
    "abs": Function(1, 1, "absolute value", "depth = abs(x) - 0.01"),
    "min": Function(2, 8, "smallest of 2 to 8 numbers", "push = min(3.0, p.stiffness * abs(x))"),
    "max": Function(2, 8, "largest of 2 to 8 numbers", "depth = max(0.0, x - 0.005)"),
    "int": Function(1, 1, "a without its fraction, as a whole number", "notch = int(x / 0.004)"),
    "float": Function(1, 1, "the number itself; 1.0 or 0.0 for a comparison", "inside = float(x > 0.005)"),
    "len": Function(
        1, 1, "number of values in a table, or in a state with several values", "last = len(FORCES) - 1"
    ),
}
MATH_CONSTANTS = {"pi": "3.14159…", "tau": "2 π", "e": "2.71828…", "inf": "infinity"}
MOST_TURNS = 2**31
MOST_IN_TABLE = 256
LARGEST_IN_TABLE = 3e38
"""Largest table entry, within the range of single precision."""

OPERATORS: Mapping[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "sum"),
    ast.Sub: ("-", "difference"),
    ast.Mult: ("*", "product"),
    ast.Div: ("/", "quotient; a division by 0 is a fault"),
    ast.FloorDiv: ("//", "quotient rounded down; a division by 0 is a fault"),
    ast.Mod: ("%", "remainder with the sign of the divisor; a division by 0 is a fault"),
    ast.Pow: ("**", "power"),
}
COMPARISONS: Mapping[type[ast.cmpop], str] = {
    ast.Eq: "==", ast.NotEq: "!=", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
}  # fmt: skip

# messages by node type; all other types are named as in Python's grammar
_INSTEAD: dict[Any, str] = {
    ast.While: "`while` is not allowed in a law: use `for i in range(10)`",
    ast.Try: "`try` is not allowed in a law, because a law cannot raise an error",
    (ast.Import, ast.ImportFrom): "write `import` at the top of the file, not in a law",
    ast.Lambda: ("`lambda` is not allowed in a law: write a function above it, `def f(a):` and `return …`"),
    ast.FunctionDef: "a function inside a law is not allowed: write it outside the law",
    (ast.List, ast.ListComp): (
        "a list is not allowed in a law: write a table above it, `TABLE = (0.0, 1.0)`, or use the state `s`"
    ),
    (ast.Dict, ast.DictComp): "a dictionary is not allowed in a law: use numbers and the state `s`",
    (ast.Set, ast.SetComp): "a set is not allowed in a law: use numbers and the state `s`",
    ast.Tuple: "several values at once are allowed only in `a, b = ...` and in `return a, b` of a helper",
    (
        ast.Global,
        ast.Nonlocal,
    ): "`{}` is not allowed in a law: store values for the next call in the state `s`",
    ast.JoinedStr: "text in quotes is not allowed in a law",
    ast.Delete: "`del` is not allowed in a law",
    ast.Match: "`match` is not allowed in a law: use `if`",
    ast.NamedExpr: "`:=` is not allowed in a law: assign with `=` on a line of its own",
    ast.AnnAssign: "a type is not allowed in a law: write `name = value`",
    ast.Starred: "`*` before a name is not allowed in a law",
    ast.ClassDef: "a class is not allowed in a law",
    ast.GeneratorExp: "a generator is not allowed in a law: use `for i in range(10)`",
    ast.Yield: "`yield` is not allowed in a law: end it with `return`",
    ast.AST: "`{}` is not allowed in a law",
}


def fail(node: ast.AST, message: str) -> LawError:
    """Return the error for a node, with its line."""
    return LawError(message, getattr(node, "lineno", 0))


def check_loop(node: ast.For, numbers: Sequence[int]) -> None:
    """Raise LawError unless a loop has one counter over ``range`` of these numbers."""
    if any(abs(n) > MOST_TURNS for n in numbers) or (len(numbers) == 3 and numbers[2] == 0):
        raise fail(
            node, "the numbers of a loop's range must be at most 2147483648, and its step must not be 0"
        )
    if not isinstance(node.target, ast.Name):
        raise fail(node, "a loop must count with one name: `for i in range(10)`")
    if node.orelse:
        raise fail(node, "`else` after a loop is not allowed in a law")


def check_arguments(tree: ast.FunctionDef, is_law: bool) -> None:
    """Raise LawError unless a law takes its five arguments, and a helper only positional arguments."""
    found = tree.args
    names = [a.arg for a in found.args]
    more = found.posonlyargs or found.kwonlyargs or found.vararg or found.kwarg
    if is_law and (more or found.defaults or tuple(names) != ARGUMENTS):
        raise fail(tree, "the arguments of a law must be (p, s, x, v, dt), without default values")
    if more or any(n.startswith("_") for n in names):
        raise fail(tree, "the arguments of a law's function must be plain names, without `*`")


def check_count(node: ast.Call, name: str, fewest: int, most: int) -> None:
    """Raise LawError unless a call has a valid number of arguments."""
    if not fewest <= len(node.args) <= most:
        wanted = f"{fewest}" if fewest == most else f"{fewest} to {most}"
        raise fail(node, f"`{name}` must have {wanted} argument{'s' * (most != 1)}, not {len(node.args)}")


def check_operator(node: ast.BinOp | ast.AugAssign) -> None:
    """Raise LawError if an operator is not arithmetic."""
    if isinstance(node.op, ast.BitXor):
        raise fail(node, "`^` is not a power in Python: write `**`, as in `x ** 2`")
    if type(node.op) not in OPERATORS:
        signs = " ".join(sign for sign, _ in OPERATORS.values())
        raise fail(node, f"this operator is not allowed in a law: use {signs}")


def check_comparison(node: ast.Compare) -> None:
    """Raise LawError for `in`, `is` and similar comparisons."""
    if not all(type(op) in COMPARISONS for op in node.ops):
        raise fail(node, f"this comparison is not allowed in a law: use {' '.join(COMPARISONS.values())}")


def refuse(node: ast.AST) -> LawError:
    """Return the error for a node type outside the law language."""
    message = next(text for kind, text in _INSTEAD.items() if isinstance(node, kind))
    return fail(node, message.format(type(node).__name__.lower()))

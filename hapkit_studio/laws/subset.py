"""The law language: which Python a force law may use, said in a student's words where it does not.

Allowed are arithmetic, comparisons, ``if``, ``for`` over a constant ``range``, the functions of ``MATH``,
parameters ``p.name``, state ``s.name`` or ``s.name[i]``, and helper functions of the same file.
"""

import ast
from typing import Any

from hapkit_studio.errors import LawError

ARGUMENTS = ("p", "s", "x", "v", "dt")
# how many arguments each function takes, from least to most
MATH = dict.fromkeys(
    ("sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "expm1", "log", "log1p"), (1, 1)
)
MATH |= dict.fromkeys(("floor", "ceil", "fabs", "sinh", "cosh", "tanh"), (1, 1))
MATH |= dict.fromkeys(("atan2", "hypot", "copysign", "pow", "fmod"), (2, 2))
MATH_CONSTANTS = frozenset(("pi", "e", "tau", "inf"))
BUILTINS = {"abs": (1, 1), "min": (2, 8), "max": (2, 8), "int": (1, 1), "float": (1, 1)}
MOST_TURNS = 2**31

# what else no law may contain is named as Python names it
_INSTEAD: dict[Any, str] = {
    ast.While: "`while` is not allowed in a law: use `for i in range(10)`",
    ast.Try: "`try` is not allowed in a law: nothing in it can raise an error",
    (ast.Import, ast.ImportFrom): "`import` stands at the top of the file, not in a law",
    ast.Lambda: "`lambda` is not allowed in a law: write a function beside it",
    ast.FunctionDef: "a function inside a law is not allowed: write it beside the law",
    (ast.List, ast.ListComp): "a list is not allowed in a law: use numbers and the state `s`",
    (ast.Dict, ast.DictComp): "a dictionary is not allowed in a law: use numbers and the state `s`",
    (ast.Set, ast.SetComp): "a set is not allowed in a law: use numbers and the state `s`",
    ast.Tuple: "several values at once stand only in `a, b = ...` and in a helper's `return a, b`",
    (ast.Global, ast.Nonlocal): "`{}` is not allowed in a law: keep memory in the state `s`",
    ast.JoinedStr: "text is not allowed in a law",
    ast.Delete: "`del` is not allowed in a law",
    ast.Match: "`match` is not allowed in a law: use `if`",
    ast.NamedExpr: "`:=` is not allowed in a law: write one line for it",
    ast.AnnAssign: "a type is not allowed in a law: write `name = value`",
    ast.Starred: "`*` before a name is not allowed in a law",
    ast.ClassDef: "a class is not allowed in a law",
    ast.GeneratorExp: "a generator is not allowed in a law: use `for i in range(10)`",
    ast.Yield: "`yield` is not allowed in a law: end it with `return`",
    ast.AST: "`{}` is not allowed in a law",
}
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)
_COMPARISONS = (ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE)


def fail(node: ast.AST, message: str) -> LawError:
    """Return the error for a node, with its line."""
    return LawError(message, getattr(node, "lineno", 0))


def check_range(node: ast.For) -> None:
    """Raise LawError unless the loop runs over ``range`` of whole constants."""
    match node.iter:
        case ast.Call(ast.Name("range"), [_] | [_, _] | [_, _, _] as args, []) if all(map(_is_whole, args)):
            numbers = [ast.literal_eval(a) for a in args]
        case _:
            raise fail(node, "a loop runs over a constant range: `for i in range(10)`")
    if any(abs(n) > MOST_TURNS for n in numbers) or (len(numbers) == 3 and numbers[2] == 0):
        raise fail(node, "a loop's range goes up to 2147483648, in steps other than 0")
    if not isinstance(node.target, ast.Name):
        raise fail(node, "a loop counts with one name: `for i in range(10)`")
    if node.orelse:
        raise fail(node, "`else` after a loop is not allowed in a law")


def _is_whole(node: ast.expr) -> bool:
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node = node.operand
    return isinstance(node, ast.Constant) and type(node.value) is int


def check_arguments(tree: ast.FunctionDef, is_law: bool) -> None:
    """Raise LawError unless a law takes its five arguments and a helper plain ones."""
    found = tree.args
    names = [a.arg for a in found.args]
    more = found.posonlyargs or found.kwonlyargs or found.vararg or found.kwarg
    if is_law and (more or tuple(names) != ARGUMENTS):
        raise fail(tree, "a law takes exactly (p, s, x, v, dt)")
    if more or found.defaults or any(n.startswith("_") for n in names):
        raise fail(tree, "the arguments of a law's function are plain names, without `*` and default values")


def check_count(node: ast.Call, name: str, bounds: tuple[int, int]) -> None:
    """Raise LawError unless a call has as many arguments as the function takes."""
    low, high = bounds
    if not low <= len(node.args) <= high:
        wanted = f"{low}" if low == high else f"{low} to {high}"
        raise fail(node, f"`{name}` takes {wanted} argument{'s' * (high != 1)}, not {len(node.args)}")


def check_operator(node: ast.BinOp | ast.AugAssign) -> None:
    """Raise LawError for an operator outside arithmetic."""
    if not isinstance(node.op, _OPERATORS):
        raise fail(node, "this operator is not allowed in a law: use + - * / // % **")


def check_comparison(node: ast.Compare) -> None:
    """Raise LawError for `in`, `is` and their like."""
    if not all(isinstance(op, _COMPARISONS) for op in node.ops):
        raise fail(node, "this comparison is not allowed in a law: use == != < <= > >=")


def refuse(node: ast.AST) -> LawError:
    """Return the error for a kind of node that no law may contain."""
    message = next(words for kind, words in _INSTEAD.items() if isinstance(node, kind))
    return fail(node, message.format(type(node).__name__.lower()))

"""What a file may hold that is harmless by construction: names, statements, expressions."""

import ast
import builtins
from collections.abc import Set
from pathlib import Path

from hapkit_studio import dynamics

PARTS = {
    "hapkit_studio.environments.base": {"Environment"},
    "hapkit_studio.laws": {"law"},
    "hapkit_studio.parameters": {"Choice", "Parameter"},
}
MAKERS = {"Environment", "Choice", "Parameter"}
BUILTINS = {"abs", "bool", "float", "int", "max", "min", "round"}
RESERVED = MAKERS | BUILTINS | {"law", "math", "range"}
DYNAMICS = "hapkit_studio.dynamics."
SIMPLE = (ast.Return, ast.Pass, ast.Break, ast.Continue, ast.Assign, ast.AugAssign, ast.Expr)
EXPRESSIONS = (
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Constant, ast.Name),
    *(ast.Attribute, ast.Subscript, ast.Tuple, ast.Call),
)
_NO_PHYSICS = {"jit"}
_WITHOUT_END = {"factorial", "comb", "perm"}
_MOST_EXPONENT = 16


class Refused(Exception):
    """The file holds something that is not on the list."""


def need(condition: object) -> None:
    """Raise Refused unless a condition holds."""
    if not condition:
        raise Refused


def plain_name(name: str) -> bool:
    """Say whether a name is none of Python's own, like ``__class__``."""
    return not name.startswith("__")


def is_number(node: ast.AST) -> bool:
    """Say whether a node is a constant number."""
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    )


def is_small(node: ast.expr) -> bool:
    """Say whether an exponent is a small constant: a power of large numbers takes for ever."""
    return isinstance(node, ast.Constant) and is_number(node) and abs(node.value) <= _MOST_EXPONENT  # type: ignore[arg-type]


def is_range(node: ast.expr) -> bool:
    """Say whether a loop runs over ``range`` of constants."""
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "range"
        and not node.keywords
        and all(is_number(a) for a in node.args)
    )


def maker(node: ast.expr) -> str:
    """Return which of MAKERS a call calls, "" for none."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in MAKERS:
        return node.func.id
    return ""


def of_math(node: ast.expr) -> bool:
    """Say whether a node is a name of ``math`` that is read."""
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "math"
        and isinstance(node.ctx, ast.Load)
        and not node.attr.startswith("_")
        and node.attr not in _WITHOUT_END
    )


def stored(tree: ast.AST) -> set[str]:
    """Return the names that are assigned anywhere in a tree."""
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def loaded(tree: ast.AST) -> set[str]:
    """Return the names that are read anywhere in a tree."""
    return {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}


def is_free(name: str, known: Set[str]) -> bool:
    """Say whether a name stands for something known, or for nothing at all."""
    return name in known | RESERVED or (plain_name(name) and not hasattr(builtins, name))


def physics(module: str) -> set[str]:
    """Return the functions and constants that stand in one file of the studio's dynamics."""
    file = Path(next(iter(dynamics.__path__))) / f"{module}.py"
    need(module.isidentifier() and module not in _NO_PHYSICS and file.is_file())
    found: set[str] = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign) and is_number(node.value):
            found |= {t.id for t in node.targets if isinstance(t, ast.Name)}
    return found

"""The functions a law calls: of its own file, or of another, each translated once."""

import ast
import inspect
import textwrap
from collections.abc import Callable
from types import FunctionType

from hapkit_studio.errors import LawError
from hapkit_studio.laws.subset import fail

# Generated names begin with an underscore, a law's own never do.
PREFIX = "_of_"
# The studio's own numbers are proven to end and to have a value wherever a law may call them.
_PROVEN = "hapkit_studio.dynamics."


class Helpers:
    """The functions one law calls, by the names they have in its generated file."""

    def __init__(self) -> None:
        self.names: dict[FunctionType, str] = {}

    def name(self, function: FunctionType) -> str:
        """Return a function's name in the generated file; two of the same name differ there."""
        if function not in self.names:
            wanted = PREFIX + function.__name__
            while wanted in self.names.values():
                wanted += "_"
            self.names[function] = wanted
        return self.names[function]


def is_proven(function: FunctionType) -> bool:
    """Return whether a function is the studio's own: it needs no fuel, its divisions no check."""
    return (function.__module__ or "").startswith(_PROVEN)


def function_tree(function: Callable) -> ast.FunctionDef:
    """Return a function's syntax tree with the line numbers of its file."""
    if not isinstance(function, FunctionType):
        raise LawError(f"A law is a function (p, s, x, v, dt), not {function!r}.")
    try:
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, SyntaxError):
        raise LawError(f"The source of {function.__name__!r} cannot be read; write it in a file.") from None
    ast.increment_lineno(tree, first - 1)
    node = tree.body[0]
    if not isinstance(node, ast.FunctionDef):
        raise fail(node, "a law is a function")
    for name in function.__code__.co_freevars:
        raise fail(node, f"'{name}' belongs to the function around the law: write it at the file's top level")
    return node


def values_returned(tree: ast.FunctionDef) -> int:
    """Return how many numbers a function returns at once; raise LawError where that differs."""
    found = sorted((n for n in ast.walk(tree) if isinstance(n, ast.Return)), key=lambda n: n.lineno)
    sizes = [len(n.value.elts) if isinstance(n.value, ast.Tuple) else 1 for n in found]
    for node, size in zip(found, sizes, strict=True):
        if size != sizes[0]:
            raise fail(node, f"`{tree.name}` returns {sizes[0]} values before and {size} here")
    return sizes[0] if sizes else 1

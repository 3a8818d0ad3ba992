"""Turn a law and its helpers into bare source for numba."""

import ast
import inspect
import textwrap
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType

from hapkit_studio.errors import LawError
from hapkit_studio.laws import subset
from hapkit_studio.laws.body import BURN, HELPER, Body
from hapkit_studio.laws.names import Names
from hapkit_studio.laws.subset import fail
from hapkit_studio.parameters import AnyParameter

FUEL = 20_000

HEADER = '''\
"""Generated from a force law; edit the law, not this file."""

import math as _math

import numpy as _np
from numba import cfunc, njit, types

_VALUES = types.CPointer(types.float64)
_FAULT = types.CPointer(types.int64)
_SIGNATURE = types.float64(
    _VALUES, _VALUES, types.float64, types.float64, types.float64, _FAULT
)


@njit(cache=True, error_model="numpy")
def _float(a):
    return a * 1.0


@njit(cache=True, error_model="numpy")
def _index(i, size, line, fault):
    if 0 <= i < size:
        return int(i)
    if fault[0] == 0:
        fault[0] = 2
        fault[1] = line
    return 0


@njit(cache=True, error_model="numpy")
def _spent(line, fault):
    if fault[0] == 0:
        fault[1] -= 1
        if fault[1] < 0:
            fault[0] = 3
            fault[1] = line
    return fault[0] != 0
'''
# A law's two fault words: the code, and the line; without a fault the second one holds the fuel left.
LAW_START = f"if _fault[0] != 0:\n    return _math.nan\n_fault[1] = {FUEL}"


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


def _returns(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _returns(last.body) and _returns(last.orelse)
    return isinstance(last, ast.Return)


def _translate_one(tree: ast.FunctionDef, names: Names, is_law: bool) -> tuple[str, list[str]]:
    """Return a function's bare source and the helpers it calls."""
    subset.check_arguments(tree, is_law)
    if not _returns(tree.body):
        what = "a law must return a force" if is_law else f"`{tree.name}` must return a number"
        raise fail(tree.body[-1], f"{what} on every path: end it with `return 0.0`")
    body = Body(names, tree, is_law)
    statements = ast.parse(LAW_START if is_law else BURN.format(line=tree.lineno)).body + body.block(
        tree.body
    )
    arguments = [ast.arg(a.arg) for a in (*tree.args.args, ast.arg("_fault"))]
    signature = ast.arguments([], arguments, None, [], [], None, [])
    new = ast.FunctionDef("law" if is_law else HELPER + tree.name, signature, statements, [], None)
    return ast.unparse(ast.fix_missing_locations(new)), body.helpers


def translate(function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]) -> str:
    """Return the bare source of a law and its helpers; raise LawError with the line of what is wrong."""
    tree = function_tree(function)
    names = Names(parameters, state, function.__globals__)  # type: ignore[attr-defined]
    source, wanted = _translate_one(tree, names, is_law=True)
    helpers: dict[str, str] = {}
    _add_helpers(wanted, names, helpers, ())
    options = 'cache=True, error_model="numpy"'
    parts = [HEADER]
    parts += [f"@njit({options})\n{helper}" for helper in helpers.values()]
    parts.append(f"@cfunc(_SIGNATURE, {options})\n{source}")
    return "\n\n".join(parts) + "\n"


def _add_helpers(wanted: list[str], names: Names, done: dict[str, str], callers: tuple[str, ...]) -> None:
    for name in wanted:
        tree = function_tree(names.globals[name])
        if name in callers:
            raise fail(tree, f"`{name}` calls itself; a law's functions may not")
        if name in done:
            continue
        source, inner = _translate_one(tree, names, is_law=False)
        _add_helpers(inner, names, done, (*callers, name))
        done[name] = source

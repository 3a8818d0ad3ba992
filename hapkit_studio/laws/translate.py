"""Turn a law and its helpers into bare source for numba."""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType

from hapkit_studio.laws import subset
from hapkit_studio.laws.body import Body
from hapkit_studio.laws.floats import without_conversions
from hapkit_studio.laws.helpers import Helpers, function_tree, values_returned
from hapkit_studio.laws.names import Names
from hapkit_studio.laws.native import LAW_DIVISION, LAW_FUEL, LAW_INDEX, NOT_A_NUMBER
from hapkit_studio.laws.subset import fail
from hapkit_studio.parameters import AnyParameter

FUEL = 20_000

HEADER = f'''\
"""Generated from a force law; edit the law, not this file."""

import math as _math

import numpy as _np
from numba import cfunc, njit, types

_VALUES = types.CPointer(types.float64)
_FAULT = types.CPointer(types.int64)
_SIGNATURE = types.float64(
    _VALUES, _VALUES, types.float64, types.float64, types.float64, _FAULT
)
# Only the law is called from outside, and nothing allocates: ways in and reference counts cost compiling.
_helper = njit(
    cache=True, error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
)


@_helper
def _float(a):
    return a * 1.0


@_helper
def _index(i, size, line, fault):
    if 0 <= i < size:
        return int(i)
    if fault[0] == 0:
        fault[0] = {LAW_INDEX}
        fault[1] = line
    return 0


@_helper
def _spent(line, fault):
    if fault[0] == 0:
        fault[1] -= 1
        if fault[1] < 0:
            fault[0] = {LAW_FUEL}
            fault[1] = line
    return fault[0] != 0


@_helper
def _divisor(a, line, fault):
    if a == 0.0 and fault[0] == 0:
        fault[0] = {LAW_DIVISION}
        fault[1] = line
    return a * 1.0


@_helper
def _noted(a, line, fault):
    if fault[2] == 0 and not _math.isfinite(a):
        fault[2] = line
    return a * 1.0


@_helper
def _force(a, line, fault):
    if fault[0] == 0 and not _math.isfinite(a):
        fault[0] = {NOT_A_NUMBER}
        fault[1] = fault[2] if fault[2] else line
    return a * 1.0
'''
LAW_START = f"""\
if _fault[0] != 0:
    return _math.nan
_fault[1] = {FUEL}
_fault[2] = 0"""


def _returns(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _returns(last.body) and _returns(last.orelse)
    return isinstance(last, ast.Return)


def rewritten(
    function: FunctionType, names: Names, helpers: Helpers, is_law: bool
) -> tuple[ast.FunctionDef, list[FunctionType]]:
    """Return a checked function's tree, names replaced and faults watched, and the helpers it calls."""
    tree = function_tree(function)
    subset.check_arguments(tree, is_law)
    if not is_law and not all(map(names.is_compiling, tree.decorator_list)):
        raise fail(tree, f"`{tree.name}` is called by a law: it may not have a decorator")
    body = Body(names, tree, function, helpers, is_law)
    body.size = 1 if is_law else values_returned(tree)
    start = ast.parse(LAW_START).body if is_law else body.burn(tree)
    statements = start + body.block(tree.body)
    if not _returns(tree.body):  # what is not allowed at all was named before
        what = "a law must return a force" if is_law else f"`{tree.name}` must return a number"
        raise fail(tree.body[-1], f"{what} on every path: end it with `return 0.0`")
    arguments = [ast.arg(a.arg) for a in (*tree.args.args, ast.arg("_fault"))]
    signature = ast.arguments([], arguments, None, [], [], None, [])
    name = "law" if is_law else helpers.name(function)
    return ast.FunctionDef(name, signature, statements, [], None), body.called


def _translate_one(
    function: FunctionType, names: Names, helpers: Helpers, is_law: bool
) -> tuple[str, list[FunctionType]]:
    """Return a function's bare source and the helpers it calls."""
    new, called = rewritten(function, names, helpers, is_law)
    return ast.unparse(ast.fix_missing_locations(without_conversions(new))), called


@dataclass(frozen=True)
class CheckedLaw:
    """A law and the functions that it calls as checked trees: p, s and helpers by their numbers and names.

    own: names of the functions that stand in the law's own file; documents: the functions' docstrings.
    """

    tree: ast.FunctionDef
    helpers: dict[str, ast.FunctionDef]
    own: frozenset[str]
    documents: dict[str, str]


def checked(
    function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]
) -> CheckedLaw:
    """Return a law's trees; raise LawError with the line of what is wrong."""
    function_tree(function)
    assert isinstance(function, FunctionType)
    helpers = Helpers()
    names = Names(parameters, state, function.__globals__)
    tree, wanted = rewritten(function, names, helpers, is_law=True)
    tree.body = tree.body[len(ast.parse(LAW_START).body) :]
    trees: dict[str, ast.FunctionDef] = {}
    while wanted:
        one = wanted.pop()
        if helpers.name(one) not in trees:
            trees[helpers.name(one)], more = rewritten(one, Names((), {}, one.__globals__), helpers, False)
            wanted += more
    same = function.__code__.co_filename
    own = frozenset(name for f, name in helpers.names.items() if f.__code__.co_filename == same)
    documents = {name: f.__doc__ or "" for f, name in helpers.names.items()}
    return CheckedLaw(tree, trees, own, documents)


def translate(function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]) -> str:
    """Return the bare source of a law and its helpers; raise LawError with the line of what is wrong."""
    function_tree(function)
    assert isinstance(function, FunctionType)
    helpers = Helpers()
    names = Names(parameters, state, function.__globals__)
    source, wanted = _translate_one(function, names, helpers, is_law=True)
    sources: dict[FunctionType, str] = {}
    _add_helpers(wanted, helpers, sources, ())
    parts = [HEADER]
    parts += [f"@_helper\n{helper}" for helper in sources.values()]
    parts.append(f'@cfunc(_SIGNATURE, cache=True, error_model="numpy", _nrt=False)\n{source}')
    return "\n\n".join(parts) + "\n"


def _add_helpers(
    wanted: list[FunctionType],
    helpers: Helpers,
    done: dict[FunctionType, str],
    callers: tuple[FunctionType, ...],
) -> None:
    for function in wanted:
        if function in callers:
            tree = function_tree(function)
            raise fail(tree, f"`{function.__name__}` calls itself; a law's functions may not")
        if function in done:
            continue
        names = Names((), {}, function.__globals__)
        source, inner = _translate_one(function, names, helpers, is_law=False)
        _add_helpers(inner, helpers, done, (*callers, function))
        done[function] = source

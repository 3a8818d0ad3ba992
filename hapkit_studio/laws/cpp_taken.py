"""Which arguments a law need not set in every tick: those that its parameters alone decide.

What is written by hand for the board keeps its arguments from call to call. A law sets such a one only when
its parameters may have changed.
"""

import ast
from collections.abc import Iterator, Mapping

from hapkit_studio.laws.cpp_kept import Kept, arguments
from hapkit_studio.laws.cpp_program import Routine

Taken = dict[str, ast.expr]


def taken_over(routine: Routine, routines: Mapping[str, Routine], kept: Kept) -> Taken:
    """Return the value of each argument that all the calls of a law set to the same, by its name."""
    others = (r for r in routines.values() if not r.by_hand)
    if not routine.is_law or any(routines[name].by_hand for r in others for name in r.calls):
        return {}
    given: dict[str, dict[str, ast.expr]] = {}
    for name, value in _settings(routine, routines, kept):
        given.setdefault(name, {})[ast.dump(value)] = value
    values = {name: next(iter(found.values())) for name, found in given.items() if len(found) == 1}
    return {name: value for name, value in values.items() if _is_tuned(value)}


def _settings(
    routine: Routine, routines: Mapping[str, Routine], kept: Kept
) -> Iterator[tuple[str, ast.expr]]:
    """Yield every kept argument of what is written by hand, and what a call sets it to."""
    for node in ast.walk(routine.tree):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
            continue
        called = routines.get(node.func.id)
        if called and called.by_hand:
            for name, actual in zip(arguments(called), node.args, strict=False):
                if name in kept.get(called.name, ()):
                    yield name, actual


def _is_tuned(node: ast.expr) -> bool:
    """Return whether an expression has nothing but parameters and numbers in it."""
    match node:
        case ast.Constant():
            return True
        case ast.Subscript(value=ast.Name(id="p"), slice=ast.Constant()):
            return True
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            return _is_tuned(inner)
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult(), right=right):
            return _is_tuned(left) and _is_tuned(right)
    return False

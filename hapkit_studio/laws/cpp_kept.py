"""Which arguments of the studio's numbers the board keeps in one place instead of handing them on.

A dozen numbers describe a moving mass, and every function hands them to the next unchanged: at four bytes
each that is half of the board's program. A law runs to its end before another begins, so they may wait in
variables that whoever calls first sets.
"""

import ast
from collections.abc import Iterator, Mapping

from hapkit_studio.laws import cpp_kinds as kinds
from hapkit_studio.laws.cpp_program import Routine

_FEW = 6
Kept = dict[str, set[str]]


def kept(routines: Mapping[str, Routine]) -> Kept:
    """Return the arguments that are kept, by the routine's name in the trees.

    A call either hands on what its caller keeps under the same name, or sets it: then nobody above may still
    need what was there.
    """
    shared = {name: r for name, r in routines.items() if r.shared}
    found: Kept = {name: _candidates(r) for name, r in shared.items()}
    above = _above(shared)
    changed = True
    while changed:
        changed = False
        for caller, routine in shared.items():
            for called, argument, actual in _handed(routine, shared):
                handed_on = is_name(actual, argument) and argument in found[caller]
                needed = any(argument in found[other] for other in above[caller] | {caller})
                if argument in found[called] and needed and not handed_on:
                    found[called].discard(argument)
                    changed = True
    return _handed_on(found, shared)


def _handed_on(found: Kept, shared: Mapping[str, Routine]) -> Kept:
    """Return only what some function hands on, or is handed so."""
    used: Kept = {name: found[name] if shared[name].by_hand else set() for name in found}
    for caller, routine in shared.items():
        for called, argument, actual in _handed(routine, shared):
            if is_name(actual, argument) and argument in found[caller] & found[called]:
                used[caller].add(argument)
                used[called].add(argument)
    return used


def _candidates(routine: Routine) -> set[str]:
    names = arguments(routine)
    if routine.by_hand:
        return set(names)
    return kinds.unchanged(routine.tree) & set(names) if len(names) > _FEW else set()


def arguments(routine: Routine) -> list[str]:
    """Return the names of a routine's own arguments."""
    return [a.arg for a in routine.tree.args.args if a.arg != "_fault"]


def _handed(routine: Routine, routines: Mapping[str, Routine]) -> Iterator[tuple[str, str, ast.expr]]:
    """Yield (called, argument, what it is given) of every call of a helper."""
    for node in ast.walk(routine.tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in routines:
            if routine.by_hand:
                return
            for argument, actual in zip(arguments(routines[node.func.id]), node.args, strict=False):
                yield node.func.id, argument, actual


def _above(routines: Mapping[str, Routine]) -> dict[str, set[str]]:
    """Return who calls each routine, directly or not."""
    found: dict[str, set[str]] = {name: set() for name in routines}
    for _ in routines:
        for caller, routine in routines.items():
            for called in routine.calls:
                found[called] |= {caller} | found[caller]
    return found


def is_name(node: ast.expr, name: str) -> bool:
    """Return whether an expression is just this name."""
    return isinstance(node, ast.Name) and node.id == name

"""Which names of a law depend on its parameters and the period alone: they seldom change from tick to tick.

A division by such a number is a product with an inverse that is kept. Keeping it is right for any number,
and pays only for these.
"""

import ast
from collections.abc import Iterable, Iterator, Mapping

from hapkit_studio.laws.cpp_program import Program, Routine
from hapkit_studio.laws.helpers import PREFIX

Steady = dict[str, set[str]]


def steady(program: Program) -> Steady:
    """Return the steady names of a law and of every helper, as this law calls it."""
    routines = {r.name: r for r in [program.law, *program.helpers.values()] if not r.by_hand}
    found = {name: _all_names(r) for name, r in routines.items()}
    before = ""
    while before != (now := str({name: sorted(names) for name, names in found.items()})):
        before = now
        for routine in routines.values():
            for owner, name, value in _given(routine, routines):
                if not is_steady(value, found[routine.name]):
                    found[owner].discard(name)
    return found


def common(programs: Iterable[Program]) -> Steady:
    """Return the names of the studio's numbers that are steady in every law."""
    found: Steady = {}
    for program in programs:
        for name, names in steady(program).items():
            if name.startswith(PREFIX):
                found[name] = found.get(name, names) & names
    return found


def is_steady(node: ast.expr, names: set[str]) -> bool:
    """Return whether an expression changes only with a parameter or the period."""
    match node:
        case ast.Constant():
            return True
        case ast.Name():
            return node.id in names
        case ast.Subscript(value=ast.Name(id=array)):
            return array == "p"
        case ast.Call():
            return all(is_steady(a, names) or _is_fault(a) for a in node.args)
    parts = [n for n in ast.iter_child_nodes(node) if isinstance(n, ast.expr)]
    return all(is_steady(n, names) for n in parts)


def _is_fault(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id == "_fault"


def _all_names(routine: Routine) -> set[str]:
    stored = {
        n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    }
    given = {a.arg for a in routine.tree.args.args}
    return (stored | given) - ({"p", "s", "x", "v"} if routine.is_law else set())


def _given(routine: Routine, routines: Mapping[str, Routine]) -> Iterator[tuple[str, str, ast.expr]]:
    """Yield (routine, name, value) of everything that a routine assigns, or hands to another."""
    for node in ast.walk(routine.tree):
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
            yield routine.name, node.target.id, ast.Name("")
        elif isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            targets = target.elts if isinstance(target, ast.Tuple) else [target]
            values = value.elts if isinstance(value, ast.Tuple) else [value] * len(targets)
            for one, given in zip(targets, values, strict=True):
                if isinstance(one, ast.Name):
                    yield routine.name, one.id, given
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in routines:
            arguments = routines[node.func.id].tree.args.args
            for argument, actual in zip(arguments, node.args, strict=False):
                yield node.func.id, argument.arg, actual

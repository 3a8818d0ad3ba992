"""Which names, arguments and results hold small whole numbers only: the board keeps them in a byte.

Flags, options and event codes are numbers in the law language; as floats each comparison of one would be a
call with eight bytes of operands.
"""

import ast
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from hapkit_studio.laws.cpp_kept import Kept
from hapkit_studio.laws.cpp_program import Program, Routine
from hapkit_studio.laws.cpp_steady import Steady, common, steady
from hapkit_studio.laws.helpers import PREFIX
from hapkit_studio.parameters import Choice

_MOST = 100.0


@dataclass
class Small:
    """What is small: names of each routine, and each place of what it returns."""

    names: dict[str, set[str]] = field(default_factory=dict)
    results: dict[str, list[bool]] = field(default_factory=dict)
    choices: frozenset[int] = frozenset()
    kept: Kept = field(default_factory=dict)
    steady: Steady = field(default_factory=dict)

    def holds(self, node: ast.expr, routine: Routine) -> bool:
        """Return whether an expression of a routine is a small whole number."""
        match node:
            case ast.Constant():
                value = node.value
                return isinstance(value, float) and value == int(value) and abs(value) <= _MOST
            case ast.Name():
                return node.id in self.names.get(routine.name, ())
            case ast.UnaryOp(op=ast.USub()):
                return self.holds(node.operand, routine)
            case ast.IfExp():
                return self.holds(node.body, routine) and self.holds(node.orelse, routine)
            case ast.Call(func=ast.Name(id=name)) if name.startswith(PREFIX):
                return self.results.get(name) == [True]
            case ast.Subscript(value=ast.Name(id="p"), slice=ast.Constant(value=place)):
                return routine.is_law and place in self.choices
        return False


def small(program: Program, shared: "Small | None" = None, choices: Iterable[int] = ()) -> Small:
    """Return what is small in a law and its own helpers; shared says it of the studio's numbers."""
    routines = {r.name: r for r in [program.law, *program.helpers.values()] if not r.shared}
    found = Small(choices=frozenset(choices), steady=steady(program))
    if shared:
        found.names |= shared.names
        found.results |= shared.results
        found.kept = shared.kept
    _reduce(found, routines, routines)
    return found


def small_numbers(programs: Iterable[Program], choices: Iterable[Iterable[int]], kept: Kept) -> Small:
    """Return what is small in the studio's numbers, as all laws of these programs call them."""
    programs = list(programs)
    found, callers = Small(kept=kept, steady=common(programs)), []
    shared: dict[str, Routine] = {}
    for program, places in zip(programs, choices, strict=True):
        shared |= {name: r for name, r in program.helpers.items() if r.shared}
        callers.append((program, frozenset(places)))
    _reduce(found, shared, shared)
    changed = True
    while changed:
        before = str(found.names)
        for program, places in callers:
            own = small(program, found, places)
            routines = [program.law, *program.helpers.values()]
            for routine in (r for r in routines if not r.shared):
                _drop_arguments(own, routine, shared, found.names)
        _reduce(found, shared, shared)
        changed = before != str(found.names)
    return found


def _reduce(found: Small, routines: Mapping[str, Routine], called: Mapping[str, Routine]) -> None:
    """Take all of these routines' names for small, and drop those that are not."""
    for name, routine in routines.items():
        if name not in found.names:
            names = set() if routine.by_hand else _all_names(routine)
            found.names[name] = names - found.kept.get(name, set())
            found.results[name] = [not routine.by_hand] * routine.values
    before = ""
    while before != (now := f"{found.names} {found.results}"):
        before = now
        for routine in routines.values():
            if not routine.by_hand:
                _drop_names(found, routine)
                _drop_arguments(found, routine, called, found.names)
                _drop_results(found, routine)


def _all_names(routine: Routine) -> set[str]:
    stored = {
        n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
    }
    given = set() if routine.is_law else {a.arg for a in routine.tree.args.args}
    return (stored | given) - {"_fault", "_"}


def _drop_names(found: Small, routine: Routine) -> None:
    for target, small_value in _assigned(found, routine):
        if not small_value:
            found.names[routine.name].discard(target)


def _assigned(found: Small, routine: Routine) -> Iterator[tuple[str, bool]]:
    """Yield every name that is assigned, and whether what it gets is small."""
    for node in ast.walk(routine.tree):
        if isinstance(node, ast.For) and isinstance(node.target, ast.Name):
            yield node.target.id, False
        if not isinstance(node, ast.Assign):
            continue
        target, value = node.targets[0], node.value
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        if isinstance(value, ast.Tuple):
            kinds = [found.holds(v, routine) for v in value.elts]
        elif isinstance(target, ast.Tuple):
            assert isinstance(value, ast.Call)
            assert isinstance(value.func, ast.Name)
            kinds = found.results.get(value.func.id, [False] * len(targets))
        else:
            kinds = [found.holds(value, routine)]
        for one, kind in zip(targets, kinds, strict=True):
            if isinstance(one, ast.Name):
                yield one.id, kind


def _drop_arguments(
    found: Small, routine: Routine, called: Mapping[str, Routine], names: dict[str, set[str]]
) -> None:
    for node in ast.walk(routine.tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in called:
            arguments = called[node.func.id].tree.args.args
            for argument, actual in zip(arguments, node.args, strict=True):
                if not found.holds(actual, routine):
                    names[node.func.id].discard(argument.arg)


def _drop_results(found: Small, routine: Routine) -> None:
    for node in ast.walk(routine.tree):
        if isinstance(node, ast.Return) and node.value is not None:
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            for i, value in enumerate(values):
                if not found.holds(value, routine):
                    found.results[routine.name][i] = False


def choice_places(parameters: Iterable[object]) -> list[int]:
    """Return which parameters are one of a few options."""
    return [i for i, p in enumerate(parameters) if isinstance(p, Choice)]

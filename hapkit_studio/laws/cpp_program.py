"""Everything that a law runs, as checked trees: the law, and the helpers it calls, each once."""

import ast
from collections.abc import Set
from dataclasses import dataclass
from types import FunctionType

from hapkit_studio.laws.cpp_words import mangled
from hapkit_studio.laws.folding import folded
from hapkit_studio.laws.helpers import PREFIX, Helpers, is_proven
from hapkit_studio.laws.law import Law
from hapkit_studio.laws.names import Names
from hapkit_studio.laws.translate import LAW_START, rewritten
from hapkit_studio.parameters import Parameter

# What a translation would be too slow for; the differential tests hold it to the original.
BY_HAND = {
    "hapkit_studio.dynamics.integrators.step": "moving.h",
    "hapkit_studio.dynamics.moving_mass.reaction": "contact.h",
    "hapkit_studio.dynamics.grains.sandpaper": "grains.h",
}
# Where the place of the last push is kept, which is reckoned once for the handle and for the mass. In the
# studio's laws it is one push; a person's law may move a mass by another one, and must not find it.
REMEMBERED = {"moving.h": "numbers::mass::at_x"}
_SHARED = PREFIX + "shared__"
_START = len(ast.parse(LAW_START).body)


class _Names(Helpers):
    """Names the studio's own functions alike in every law."""

    def name(self, function: FunctionType) -> str:
        if is_proven(function) and function not in self.names:
            self.names[function] = _SHARED + mangled(function.__name__.lstrip("_"))
        return super().name(function)


@dataclass(frozen=True)
class Routine:
    """One function: its name in the trees, what it is in Python, its rewritten tree, how much it returns."""

    name: str
    function: FunctionType
    tree: ast.FunctionDef
    values: int

    @property
    def by_hand(self) -> str:
        """Return the header that has it written for the board, "" for all that are translated."""
        return BY_HAND.get(f"{self.function.__module__}.{self.function.__name__}", "")

    @property
    def is_law(self) -> bool:
        """Return whether it is the law itself."""
        return self.name == "law"

    @property
    def word(self) -> str:
        """Return its name in C++."""
        own = mangled(self.function.__name__)
        return f"numbers::{self.name.removeprefix(_SHARED)}" if self.shared else own

    def called(self) -> list[str]:
        """Return the helper of each call that is left in the tree."""
        found = (n.func for n in ast.walk(self.tree) if isinstance(n, ast.Call))
        return [f.id for f in found if isinstance(f, ast.Name) and f.id.startswith(PREFIX)]

    @property
    def calls(self) -> tuple[str, ...]:
        """Return the helpers that its translation calls, each once."""
        return () if self.by_hand else tuple(dict.fromkeys(self.called()))

    @property
    def persons(self) -> bool:
        """Return whether it is not the studio's."""
        return not (self.function.__module__ or "").startswith("hapkit_studio.")

    @property
    def shared(self) -> bool:
        """Return whether it is the studio's own, which all laws share."""
        return is_proven(self.function)


@dataclass(frozen=True)
class Program:
    """A law and its helpers by the names they have in the trees, each after those that it calls."""

    law: Routine
    helpers: dict[str, Routine]

    @property
    def outside(self) -> list[Routine]:
        """Return the law and the helpers of its own file."""
        return [self.law, *(r for r in self.helpers.values() if not r.shared)]


def collect(law: Law) -> Program:
    """Return a bound law's program; raise LawError as ``bind`` does."""
    function = law.function
    assert isinstance(function, FunctionType)
    names, helpers = Names(law.parameters, law.state, function.__globals__), _Names()
    done: dict[str, Routine] = {}
    nonzero = {i for i, p in enumerate(law.parameters) if isinstance(p, Parameter) and p.low * p.high > 0.0}
    routine = _routine(function, names, helpers, True, nonzero)
    for called in routine[1]:
        _add(called, helpers, done)
    wanted = _reached(routine[0], done)
    return Program(routine[0], {name: r for name, r in done.items() if name in wanted})


def _reached(routine: Routine, routines: dict[str, Routine]) -> set[str]:
    found = set(routine.calls)
    return found.union(*(_reached(routines[name], routines) for name in found))


def _routine(
    function: FunctionType,
    names: Names,
    helpers: Helpers,
    is_law: bool,
    nonzero: Set[object] = frozenset(),
) -> tuple[Routine, list[FunctionType]]:
    tree, called = rewritten(function, names, helpers, is_law)
    if is_law:  # the board looks for an earlier fault by itself
        tree.body = tree.body[_START:]
    values = max((len(n.value.elts) for n in ast.walk(tree) if _gives_several(n)), default=1)  # type: ignore
    known = {helpers.name(f): f for f in called}
    tree = folded(tree, known, nonzero)
    routine = Routine(tree.name, function, tree, values)
    return routine, [] if routine.by_hand else called


def _gives_several(node: ast.AST) -> bool:
    return isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple)


def _add(function: FunctionType, helpers: Helpers, done: dict[str, Routine]) -> None:
    if helpers.name(function) in done:
        return
    routine, called = _routine(function, Names((), {}, function.__globals__), helpers, False)
    for inner in called:
        _add(inner, helpers, done)
    done[routine.name] = routine

"""What the words of one law stand for."""

import ast
import math
from collections.abc import Mapping, Sequence
from types import FunctionType

from hapkit_studio.dynamics import jit
from hapkit_studio.laws.helpers import is_proven
from hapkit_studio.laws.subset import MATH, fail
from hapkit_studio.parameters import AnyParameter, Choice


class Names:
    """The parameters, the state values and the globals of a law's file."""

    def __init__(self, parameters: Sequence[AnyParameter], state: Mapping[str, object], scope: dict):
        self.parameters: dict[str, tuple[int, AnyParameter | None]] = {
            p.key: (i, p) for i, p in enumerate(parameters)
        }
        self.globals = scope
        self.places: dict[str, tuple[int, int]] = {}
        start = 0
        for key, value in state.items():
            size = len(value) if isinstance(value, tuple) else 0
            self.places[key] = (start, size)
            start += size or 1

    def function(self, name: str) -> FunctionType | None:
        """Return the function of a name that a law may call: of its own file, or of the studio's numbers."""
        found = self.globals.get(name)
        found = getattr(found, "py_func", found)
        if not isinstance(found, FunctionType):
            return None
        return found if found.__globals__ is self.globals or is_proven(found) else None

    def math_function(self, name: str) -> bool:
        """Return whether a name is one of `math`'s functions, imported by itself."""
        return name in MATH and self.globals.get(name) is getattr(math, name)

    def is_compiling(self, decorator: ast.expr) -> bool:
        """Return whether a decorator only says how numba compiles the function."""
        known = (jit.compiled, jit.internal, jit.inlined)
        return isinstance(decorator, ast.Name) and self.globals.get(decorator.id) in known

    def parameter(self, node: ast.Attribute) -> int:
        if node.attr not in self.parameters:
            raise fail(node, f"'p.{node.attr}' is not a parameter; there is: {', '.join(self.parameters)}")
        return self.parameters[node.attr][0]

    def choice(self, node: ast.expr) -> Choice | None:
        if not (
            isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "p"
        ):
            return None
        _, found = self.parameters.get(node.attr, (0, None))
        return found if isinstance(found, Choice) else None

    def state(self, node: ast.Attribute) -> tuple[int, int]:
        if node.attr not in self.places:
            known = ", ".join(self.places) or "none"
            raise fail(node, f"'s.{node.attr}' is not a state of this law; there is: {known}")
        return self.places[node.attr]

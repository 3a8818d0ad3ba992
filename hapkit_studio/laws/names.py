"""What the words of one law stand for."""

import ast
from collections.abc import Mapping, Sequence

from hapkit_studio.laws.subset import fail
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

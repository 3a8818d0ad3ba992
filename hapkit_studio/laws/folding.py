"""Reckons out what a law's tree says in constants alone, in double precision, before it becomes C++."""

import ast
import math
import operator
from collections.abc import Callable, Mapping, Set
from types import FunctionType

_OPERATORS: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
# What these give is what they are given.
_TRANSPARENT = frozenset(("_float", "_noted", "_force"))


class _Folder(ast.NodeTransformer):
    def __init__(self, helpers: Mapping[str, FunctionType], nonzero: Set[object]):
        self.helpers, self.nonzero = helpers, nonzero

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        left, right = _number(node.left), _number(node.right)
        if right is not None and left is None and isinstance(node.op, ast.Mult | ast.Div):
            return _with_one_factor(node, right)
        if left is None or right is None:
            return node
        return _reckoned(_OPERATORS[type(node.op)], (left, right), node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        self.generic_visit(node)
        value = _number(node.operand)
        if value is None or isinstance(node.op, ast.Not):
            return node
        return ast.Constant(-value if isinstance(node.op, ast.USub) else value)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name in _TRANSPARENT or (name == "_divisor" and self._never_zero(node.args[0])):
            return node.args[0]
        given = [_number(a) for a in node.args if not _is_fault(a)]
        function = self._function(node.func)
        if function is None or not given or None in given:
            return node
        return _reckoned(function, given, node)

    def _never_zero(self, node: ast.expr) -> bool:
        match node:
            case ast.Subscript(value=ast.Name(id="p"), slice=ast.Constant(value=place)):
                return place in self.nonzero
        return bool(_number(node))

    def _function(self, node: ast.expr) -> Callable | None:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "_math":
            return getattr(math, node.attr)
        return self.helpers.get(node.id) if isinstance(node, ast.Name) else None


def _with_one_factor(node: ast.BinOp, last: float) -> ast.BinOp:
    """Return a product by a constant, or a quotient, as a product whose only constant comes first."""
    if last == 0.0 or not math.isfinite(1.0 / last):
        return node
    factor = last if isinstance(node.op, ast.Mult) else 1.0 / last
    rest = node.left
    if isinstance(rest, ast.BinOp) and isinstance(rest.op, ast.Mult):
        first = _number(rest.left)
        if first is not None:
            return ast.BinOp(ast.Constant(first * factor), ast.Mult(), rest.right)
    return ast.BinOp(ast.Constant(factor), ast.Mult(), rest)


def _is_fault(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id == "_fault"


def _number(node: ast.expr) -> float | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, float):
        return node.value
    return None


def _reckoned(function: Callable, values, node: ast.expr) -> ast.expr:
    """Return the value as a constant, or the node itself where there is no single finite one."""
    try:
        found = function(*values)
    except (ArithmeticError, ValueError):
        return node
    return ast.Constant(found) if isinstance(found, float) and math.isfinite(found) else node


def folded(
    tree: ast.FunctionDef, helpers: Mapping[str, FunctionType], nonzero: Set[object] = frozenset()
) -> ast.FunctionDef:
    """Return a rewritten function whose constant parts are numbers; helpers by their names in the tree.

    nonzero are the places of the parameters that are never zero: dividing by one is no fault.
    """
    return _Folder(helpers, nonzero).visit(tree)

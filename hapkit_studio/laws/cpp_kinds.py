"""What is known of a function's names before it is written in C++: truth values, and those that are ±1."""

import ast
import math
from collections.abc import Callable


def truths(tree: ast.FunctionDef) -> set[str]:
    """Return the names that hold nothing but truth values."""
    return _lasting(tree, is_truth)


def signs(tree: ast.FunctionDef) -> set[str]:
    """Return the names that hold nothing but 1.0 and -1.0."""
    return _lasting(tree, is_sign)


def is_truth(node: ast.expr, names: set[str]) -> bool:
    """Return whether an expression is a truth value."""
    match node:
        case ast.Compare() | ast.UnaryOp(op=ast.Not()):
            return True
        case ast.Constant():
            return isinstance(node.value, bool)
        case ast.Name():
            return node.id in names
        case ast.BoolOp():
            return all(is_truth(v, names) for v in node.values)
        case ast.IfExp():
            return is_truth(node.body, names) and is_truth(node.orelse, names)
    return False


def is_sign(node: ast.expr, names: set[str]) -> bool:
    """Return whether an expression is 1.0 or -1.0."""
    match node:
        case ast.Constant():
            return node.value in (1.0, -1.0)
        case ast.Name():
            return node.id in names
        case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
            return is_sign(node.operand, names)
        case ast.IfExp():
            return is_sign(node.body, names) and is_sign(node.orelse, names)
    return False


def _lasting(tree: ast.FunctionDef, is_kind: Callable[[ast.expr, set[str]], bool]) -> set[str]:
    """Return the names whose every value is of a kind, taken that they themselves are."""
    values = _values(tree)
    names = set(values) - {a.arg for a in tree.args.args}
    before = -1
    while before != len(names):
        before = len(names)
        names = {n for n in names if all(v is not None and is_kind(v, names) for v in values[n])}
    return names


def _values(tree: ast.FunctionDef) -> dict[str, list[ast.expr | None]]:
    """Return what is assigned to each name, None where that is a part of what a call returns."""
    found: dict[str, list[ast.expr | None]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            targets = target.elts if isinstance(target, ast.Tuple) else [target]
            values = value.elts if isinstance(value, ast.Tuple) else [value]
            several = len(values) == len(targets)
            for i, one in enumerate(targets):
                if isinstance(one, ast.Name):
                    found.setdefault(one.id, []).append(values[i] if several else None)
    return found


def unchanged(tree: ast.FunctionDef) -> set[str]:
    """Return the arguments that are never assigned."""
    return {a.arg for a in tree.args.args} - set(_values(tree))


def power_of_two(value: float) -> int | None:
    """Return n where the value is 2**n or -2**n, else None."""
    if value == 0.0 or not math.isfinite(value):
        return None
    part, exponent = math.frexp(value)
    return exponent - 1 if abs(part) == 0.5 else None


def without_turn(node: ast.expr) -> ast.expr | None:
    """Return a product without its first factor 2 pi, None where it begins with another."""
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult | ast.Div)):
        return None
    first = node.left
    if isinstance(first, ast.Constant) and isinstance(first.value, float) and isinstance(node.op, ast.Mult):
        return node.right if math.isclose(first.value, math.tau, rel_tol=1e-15) else None
    rest = without_turn(first)
    return None if rest is None else ast.BinOp(rest, node.op, node.right)


def scaled_square(node: ast.expr) -> tuple[float, ast.Name] | None:
    """Return (k, x) of the product k x x with a constant k < 0 and a name x, None for anything else."""
    match node:
        case ast.BinOp(
            left=ast.UnaryOp(op=ast.USub(), operand=ast.Name() as one), op=ast.Mult(), right=ast.Name() as two
        ):
            factor = -1.0
        case ast.BinOp(
            left=ast.BinOp(left=ast.Constant(value=float(factor)), op=ast.Mult(), right=ast.Name() as one),
            op=ast.Mult(),
            right=ast.Name() as two,
        ):
            pass
        case _:
            return None
    return (factor, one) if one.id == two.id and factor < 0.0 else None

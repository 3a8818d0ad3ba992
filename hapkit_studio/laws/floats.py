"""Leaves out the conversions of what is a float anyway: they are half of the calls numba would compile."""

import ast

# Functions of the generated file that give a float whatever they are given.
_MADE_FLOATS = frozenset(("_float", "_divisor", "_noted", "_force"))
# These give what they are given: floats for floats.
_KEEP_FLOATS = frozenset(("abs", "min", "max"))
_ARRAYS = ("p", "s", "_fault")


class _Floats(ast.NodeTransformer):
    """Knows the names of one function that hold nothing but floats."""

    def __init__(self, function: ast.FunctionDef):
        self.names = {a.arg for a in function.args.args} | _stored(function)
        loops = [n.target for n in ast.walk(function) if isinstance(n, ast.For)]
        self.names -= {*_ARRAYS, *(n.id for n in loops if isinstance(n, ast.Name))}
        before = -1
        while before != len(self.names):
            before = len(self.names)
            for node in ast.walk(function):
                if isinstance(node, ast.Assign):
                    self._assign(node.targets[0], node.value)

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, its in zip(target.elts, value.elts, strict=True):
                self._assign(one, its)
        elif isinstance(target, ast.Name) and not self.is_float(value):
            self.names.discard(target.id)

    def is_float(self, node: ast.expr) -> bool:
        """Return whether an expression is surely a float, neither a whole number nor a truth value."""
        match node:
            case ast.Constant():
                return isinstance(node.value, float)
            case ast.Name():
                return node.id in self.names
            case ast.Subscript(value=ast.Name(id="p" | "s")):
                return True
            case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
                return self.is_float(node.operand)
            case ast.BinOp():
                return self.is_float(node.left) or self.is_float(node.right)
            case ast.IfExp():
                return self.is_float(node.body) and self.is_float(node.orelse)
            case ast.Call(func=ast.Name(id=name)):
                return name in _MADE_FLOATS or (name in _KEEP_FLOATS and all(map(self.is_float, node.args)))
            case ast.Call(func=ast.Attribute(value=ast.Name(id="_math"))):
                return True
        return False

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Leave constants alone: Python itself would reckon them out, (-1.0) ** 0.5 as a complex number."""
        names = {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}
        return self.generic_visit(node) if names > {"_float"} or "_float" not in names else node  # type: ignore

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        is_conversion = isinstance(node.func, ast.Name) and node.func.id == "_float"
        return node.args[0] if is_conversion and self.is_float(node.args[0]) else node


def _stored(function: ast.FunctionDef) -> set[str]:
    return {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def without_conversions(function: ast.FunctionDef) -> ast.FunctionDef:
    """Return a generated function without the conversions of surely floats; its types stay what they were."""
    return _Floats(function).visit(function)

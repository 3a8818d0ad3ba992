"""A function of a harmless file: it can only compute with its arguments, numbers and what is listed."""

import ast
from collections.abc import Set

from hapkit_studio.workshop.allowed import (
    BUILTINS,
    EXPRESSIONS,
    RESERVED,
    SIMPLE,
    is_free,
    is_range,
    is_small,
    need,
    of_math,
    plain_name,
)


class Function:
    """Lets a function's arguments and body through, or raises Refused.

    known are the names of the file, callable those of them that a function may call.
    """

    def __init__(self, arguments: ast.arguments, known: Set[str], callable_names: Set[str]):
        more = (arguments.posonlyargs, arguments.kwonlyargs, arguments.defaults, arguments.kw_defaults)
        need(not any(more) and arguments.vararg is None and arguments.kwarg is None)
        need(all(a.annotation is None for a in arguments.args))
        self.known, self.callable = known, callable_names
        self.arguments = {a.arg for a in arguments.args}
        self.local: set[str] = set()
        self.add(self.arguments)

    def add(self, names: Set[str]) -> None:
        """Make names the function's own."""
        need(all(map(plain_name, names)) and not names & RESERVED)
        self.local |= names

    def block(self, statements: list[ast.stmt]) -> None:
        for node in statements:
            if isinstance(node, ast.If):
                self.expression(node.test)
            elif isinstance(node, ast.For):
                need(is_range(node.iter) and isinstance(node.target, ast.Name))
            else:
                self.simple(node)
                continue
            self.block(node.body)
            self.block(node.orelse)

    def simple(self, node: ast.stmt) -> None:
        """Let a statement through that holds no others."""
        need(isinstance(node, SIMPLE))
        need(not (isinstance(node, ast.AugAssign) and isinstance(node.op, ast.Pow)))
        for child in ast.iter_child_nodes(node):
            if not isinstance(child, ast.operator):
                self.expression(child)

    def expression(self, node: ast.AST) -> None:
        """Let an expression through whose every part is on the list."""
        need(isinstance(node, EXPRESSIONS))
        if isinstance(node, ast.Call):
            self.call(node)
        elif isinstance(node, ast.Attribute):
            self.attribute(node)
        elif isinstance(node, ast.Name):
            need(node.id in self.local or is_free(node.id, self.known))
        else:
            need(not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)) or is_small(node.right))
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.expr):
                    self.expression(child)

    def attribute(self, node: ast.Attribute) -> None:
        """Let ``a.name`` of an argument through where it is read, and the numbers of ``math``."""
        need(isinstance(node.ctx, ast.Load) and not node.attr.startswith("_"))
        of_argument = isinstance(node.value, ast.Name) and node.value.id in self.arguments
        need(of_argument or of_math(node))

    def call(self, node: ast.Call) -> None:
        need(not node.keywords)
        if isinstance(node.func, ast.Name):
            need(node.func.id in BUILTINS | self.callable and node.func.id not in self.local)
        else:
            need(of_math(node.func))
        for argument in node.args:
            self.expression(argument)

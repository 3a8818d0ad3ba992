"""Whether a file is harmless by construction, seen from its syntax tree alone, without executing anything.

Harmless files read, write and start nothing; that they come to an end is not promised. Only what is listed
is let through: at top level a docstring, imports of ``math`` and of the names an environment is made of,
constants, functions, laws and ENVIRONMENT; in functions arithmetic, comparisons, ``if``, loops over a
constant range, and calls of ``math``, of a few built-in functions and of functions of the same file.
A law's body, and what only laws call, is free: none of it is executed as Python, only translated from the
law language. What Python cannot read, or a name that stands for nothing, does no harm either.
"""

import ast
import warnings

from hapkit_studio.workshop.allowed import (
    DYNAMICS,
    PARTS,
    RESERVED,
    Refused,
    is_free,
    is_number,
    loaded,
    maker,
    need,
    of_math,
    physics,
    plain_name,
    stored,
)
from hapkit_studio.workshop.harmless_function import Function

_MOST_NESTED = 100


def is_harmless(text: str) -> bool:
    """Say whether executing this text, and its functions, can do nothing but compute or fail."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            compile(text, "", "exec", dont_inherit=True)
    except (SyntaxError, ValueError):
        return True  # as none of it is ever executed
    except (RecursionError, MemoryError):
        return False
    try:
        tree = ast.parse(text)
        need(_depth(tree) <= _MOST_NESTED)
        _File(tree).check()
    except (Refused, RecursionError, MemoryError):
        return False
    return True


def _depth(tree: ast.AST) -> int:
    """Return how deep a tree is nested, without recursion."""
    depth, level = 0, [tree]
    while level:
        depth, level = depth + 1, [child for node in level for child in ast.iter_child_nodes(node)]
    return depth


class _File:
    """One file: the names known so far, those that are surely numbers, those a function may call."""

    def __init__(self, tree: ast.Module):
        self.statements = tree.body
        self.defined = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
        self.functions = set(self.defined)
        self.known: set[str] = set()
        self.numbers: set[str] = set()

    def check(self) -> None:
        for node in self.statements:
            if isinstance(node, ast.Expr):
                need(isinstance(node.value, ast.Constant))
            elif isinstance(node, ast.Import):
                need([(a.name, a.asname) for a in node.names] == [("math", None)])
            elif isinstance(node, ast.ImportFrom):
                self.imported(node)
            elif isinstance(node, ast.FunctionDef):
                self.definition(node)
            else:
                need(isinstance(node, ast.Assign))
                self.assigned(node)  # type: ignore[arg-type]
        self.bodies()

    def bodies(self) -> None:
        """Let functions through that Python may call: those named outside of any, and on from there."""
        rest = [n for n in self.statements if not isinstance(n, ast.FunctionDef)]
        wanted = set().union(*map(loaded, rest))
        done: set[str] = set()
        while new := (wanted & set(self.defined)) - done:
            for name in new:
                node = self.defined[name]
                if not node.decorator_list:
                    inner = Function(node.args, self.known, self.functions)
                    inner.add(stored(node))
                    inner.block(node.body)
                    wanted |= loaded(node)
            done |= new

    def imported(self, node: ast.ImportFrom) -> None:
        need(node.level == 0 and all(a.asname is None for a in node.names))
        module, names = node.module or "", {a.name for a in node.names}
        if module.startswith(DYNAMICS):
            need(names <= physics(module.removeprefix(DYNAMICS)) - RESERVED - self.functions - self.known)
            self.functions |= names
        else:
            need(names <= PARTS.get(module, set()))
        self.known |= names

    def new_name(self, name: str) -> None:
        """Let a name through that stood for nothing before."""
        need(plain_name(name) and name not in RESERVED | self.known)
        self.known.add(name)

    def assigned(self, node: ast.Assign) -> None:
        name = node.targets[0]
        need(len(node.targets) == 1 and isinstance(name, ast.Name))
        assert isinstance(name, ast.Name)
        number = self.value(node.value)
        self.new_name(name.id)
        if number:
            self.numbers.add(name.id)

    def value(self, node: ast.expr | None) -> bool:
        """Let a value at top level through; return whether it is surely a number."""
        if isinstance(node, ast.Constant):
            return is_number(node)
        if isinstance(node, ast.Name):
            need(is_free(node.id, self.known))
            return node.id in self.numbers or node.id not in self.known
        if isinstance(node, ast.BinOp | ast.UnaryOp | ast.Attribute):
            self.number(node)
            return True
        if isinstance(node, ast.Lambda):
            Function(node.args, self.known, self.functions).expression(node.body)
        elif isinstance(node, ast.Call):
            self.made_of(node)
        else:
            need(isinstance(node, ast.Tuple | ast.List))
            for element in node.elts:  # type: ignore[union-attr]
                self.value(element)
        return False

    def number(self, node: ast.expr) -> None:
        """Let arithmetic on numbers through; without powers, which can take for ever."""
        if isinstance(node, ast.BinOp):
            need(isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div))
            need(self.value(node.left) and self.value(node.right))
        elif isinstance(node, ast.UnaryOp):
            need(isinstance(node.op, ast.USub | ast.UAdd) and self.value(node.operand))
        else:
            need(of_math(node))

    def made_of(self, node: ast.Call) -> None:
        need(maker(node))
        for argument in (*node.args, *(k.value for k in node.keywords)):
            self.value(argument)
        need(all(k.arg is not None and plain_name(k.arg) for k in node.keywords))

    def definition(self, node: ast.FunctionDef) -> None:
        """Let through what is executed where a function is defined."""
        self.new_name(node.name)
        need(len(node.decorator_list) <= 1 and node.returns is None and not getattr(node, "type_params", ()))
        for decorator in node.decorator_list:
            self.decorator(decorator)
        Function(node.args, self.known, self.functions)

    def decorator(self, node: ast.expr) -> None:
        """Let ``@law`` and ``@law(state={…})`` of plain numbers through."""
        if isinstance(node, ast.Call):
            need(not node.args and len(node.keywords) <= 1 and all(k.arg == "state" for k in node.keywords))
            for given in node.keywords:
                need(isinstance(given.value, ast.Dict))
                for part in (*given.value.keys, *given.value.values):  # type: ignore[attr-defined]
                    self.value(part)
            node = node.func
        need(isinstance(node, ast.Name) and node.id == "law")

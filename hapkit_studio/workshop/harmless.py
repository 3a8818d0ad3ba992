"""Whether a file is harmless by construction, seen from its syntax tree alone, without executing anything.

Harmless files read, write and start nothing; that they come to an end is not promised. Only what is listed
here is let through: at top level a docstring, imports of ``math`` and of the names an environment is made of,
constants, functions, laws and one ENVIRONMENT; in functions arithmetic, comparisons, ``if``, loops over a
constant range, and calls of ``math``, of a few built-in functions and of functions of the same file.
"""

import ast
from pathlib import Path

from hapkit_studio import dynamics

PARTS = {
    "hapkit_studio.environments.base": {"Environment"},
    "hapkit_studio.laws": {"law"},
    "hapkit_studio.parameters": {"Choice", "Parameter"},
}
MAKERS = {"Environment", "Choice", "Parameter"}
BUILTINS = {"abs", "bool", "float", "int", "max", "min", "round"}
RESERVED = MAKERS | BUILTINS | {"law", "math", "range"}
_DYNAMICS = "hapkit_studio.dynamics."
_NO_PHYSICS = {"jit"}
_MOST_EXPONENT = 16
_MOST_NESTED = 100
_STATEMENTS = (
    ast.Return,
    ast.Pass,
    ast.Break,
    ast.Continue,
    ast.If,
    ast.Assign,
    ast.AugAssign,
    ast.Expr,
    ast.For,
)
_EXPRESSIONS = (
    *(ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp, ast.Constant, ast.Name),
    *(ast.Attribute, ast.Subscript, ast.Tuple, ast.Call),
)


class _Refused(Exception):
    """The file holds something that is not on the list."""


def is_harmless(text: str) -> bool:
    """Say whether executing this text, and its functions, can do nothing but compute."""
    try:
        tree = ast.parse(text)
        _need(_depth(tree) <= _MOST_NESTED)
        _File(tree).check()
    except (_Refused, SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True


def _need(condition: object) -> None:
    if not condition:
        raise _Refused


def _depth(tree: ast.AST) -> int:
    """Return how deep a tree is nested, without recursion."""
    depth, level = 0, [tree]
    while level:
        depth, level = depth + 1, [child for node in level for child in ast.iter_child_nodes(node)]
    return depth


class _File:
    """One file: the names known so far, and those that are surely numbers."""

    def __init__(self, tree: ast.Module):
        self.statements = tree.body
        self.functions = {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
        self.known: set[str] = set()
        self.numbers: set[str] = set()
        self.made = 0
        _need(not tree.type_ignores)

    def check(self) -> None:
        for statement in self.statements:
            self.top(statement)
        _need(self.made == 1)

    def top(self, node: ast.stmt) -> None:
        if isinstance(node, ast.Expr):
            _need(isinstance(node.value, ast.Constant))
        elif isinstance(node, ast.Import):
            _need([(a.name, a.asname) for a in node.names] == [("math", None)])
            self.known.add("math")
        elif isinstance(node, ast.ImportFrom):
            self.imported(node)
        elif isinstance(node, ast.FunctionDef):
            self.function(node)
        else:
            _need(isinstance(node, ast.Assign))
            self.assigned(node)  # type: ignore[arg-type]

    def imported(self, node: ast.ImportFrom) -> None:
        _need(node.level == 0 and all(a.asname is None for a in node.names))
        module, names = node.module or "", {a.name for a in node.names}
        if module.startswith(_DYNAMICS):
            _need(names <= _physics(module.removeprefix(_DYNAMICS)) - RESERVED - self.functions)
            self.functions |= names
        else:
            _need(names <= PARTS.get(module, set()))
        self.known |= names

    def new_name(self, name: str) -> None:
        _need(not name.startswith("__") and name not in RESERVED and name not in self.known)
        self.known.add(name)

    def assigned(self, node: ast.Assign) -> None:
        _need(len(node.targets) == 1 and isinstance(node.targets[0], ast.Name))
        name = node.targets[0].id  # type: ignore[attr-defined]
        self.new_name(name)
        if _maker(node.value) == "Environment":
            _need(name == "ENVIRONMENT")
            self.made += 1
        if self.value(node.value):
            self.numbers.add(name)

    def value(self, node: ast.expr) -> bool:
        """Let a value at top level through; return whether it is a number."""
        if isinstance(node, ast.Constant):
            return isinstance(node.value, int | float) and not isinstance(node.value, bool)
        if isinstance(node, ast.Name):
            _need(node.id in self.known and not node.id.startswith("__"))
            return node.id in self.numbers
        if isinstance(node, ast.Tuple | ast.List):
            for element in node.elts:
                self.value(element)
        elif isinstance(node, ast.Lambda):
            Function(self, node.args).expression(node.body)
        elif isinstance(node, ast.Call):
            self.maker(node)
        else:
            self.number(node)
            return True
        return False

    def number(self, node: ast.expr) -> None:
        """Let arithmetic on numbers through; without powers, which can take for ever."""
        if isinstance(node, ast.BinOp):
            _need(isinstance(node.op, ast.Add | ast.Sub | ast.Mult | ast.Div))
            sides = [node.left, node.right]
        elif isinstance(node, ast.UnaryOp):
            _need(isinstance(node.op, ast.USub | ast.UAdd))
            sides = [node.operand]
        else:
            return _need(_math_name(node) and "math" in self.known)
        for side in sides:
            _need(self.value(side))
        return None

    def maker(self, node: ast.Call) -> None:
        _need(_maker(node) in self.known)
        for argument in node.args:
            self.value(argument)
        for given in node.keywords:
            _need(given.arg is not None and not given.arg.startswith("__"))
            self.value(given.value)

    def function(self, node: ast.FunctionDef) -> None:
        self.new_name(node.name)
        for decorator in node.decorator_list:
            self.decorator(decorator)
        _need(len(node.decorator_list) <= 1 and node.returns is None and not getattr(node, "type_params", ()))
        inner = Function(self, node.args, is_law=bool(node.decorator_list))
        inner.local |= {
            n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        inner.block(node.body)

    def decorator(self, node: ast.expr) -> None:
        _need("law" in self.known)
        if isinstance(node, ast.Call):
            _need(not node.args and [k.arg for k in node.keywords] in ([], ["state"]))
            for given in node.keywords:
                _need(isinstance(given.value, ast.Dict))
                for part in (*given.value.keys, *given.value.values):  # type: ignore[attr-defined]
                    _need(part is not None)
                    self.value(part)
            node = node.func
        _need(isinstance(node, ast.Name) and node.id == "law")


class Function:
    """One function's arguments, names and body."""

    def __init__(self, file: _File, arguments: ast.arguments, is_law: bool = False):
        more = (arguments.posonlyargs, arguments.kwonlyargs, arguments.defaults, arguments.kw_defaults)
        _need(not any(more) and arguments.vararg is None and arguments.kwarg is None)
        _need(all(a.annotation is None for a in arguments.args))
        self.file, self.is_law = file, is_law
        self.arguments = {a.arg for a in arguments.args}
        self.local = set(self.arguments)
        _need(not any(name.startswith("__") for name in self.arguments) and not self.arguments & RESERVED)

    def block(self, statements: list[ast.stmt]) -> None:
        _need(not any(name.startswith("__") for name in self.local) and not self.local & RESERVED)
        for node in statements:
            _need(isinstance(node, _STATEMENTS))
            for child in ast.iter_child_nodes(node):
                if isinstance(child, ast.stmt):
                    self.block([child])
                elif isinstance(child, ast.expr) and not (isinstance(node, ast.For) and child is node.iter):
                    self.expression(child)
                else:
                    _need(isinstance(child, ast.operator) or isinstance(node, ast.For))
            if isinstance(node, ast.For):
                _need(_constant_range(node.iter))
            if isinstance(node, ast.AugAssign):
                _need(not isinstance(node.op, ast.Pow))

    def expression(self, node: ast.expr) -> None:
        """Let an expression through whose every part is on the list."""
        _need(isinstance(node, _EXPRESSIONS))
        if isinstance(node, ast.Call):
            return self.call(node)
        if isinstance(node, ast.Attribute):
            return self.attribute(node)
        if isinstance(node, ast.Name):
            return _need(node.id in self.local | self.file.numbers | self.file.known | {"_"})
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            _need(_small(node.right))
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):
                self.expression(child)
        return None

    def attribute(self, node: ast.Attribute) -> None:
        """Let ``p.name``, ``s.name`` of an argument through, and the numbers of ``math``."""
        _need(isinstance(node.value, ast.Name) and not node.attr.startswith("_"))
        owner = node.value.id  # type: ignore[attr-defined]
        _need(self.is_law or isinstance(node.ctx, ast.Load))
        _need(owner in self.arguments or (_math_name(node) and "math" in self.file.known))

    def call(self, node: ast.Call) -> None:
        _need(not node.keywords)
        func = node.func
        if isinstance(func, ast.Name):
            _need(func.id in BUILTINS | self.file.functions and func.id not in self.local)
        else:
            _need(_math_name(func) and "math" in self.file.known)
        for argument in node.args:
            self.expression(argument)


def _maker(node: ast.expr) -> str:
    """Return which maker a call calls, "" for none."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in MAKERS:
        return node.func.id
    return ""


def _math_name(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "math"
        and isinstance(node.ctx, ast.Load)
        and not node.attr.startswith("_")
        and node.attr not in ("factorial", "comb", "perm")
    )


def _small(node: ast.expr) -> bool:
    """Say whether an exponent is a small constant."""
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and abs(node.value) <= _MOST_EXPONENT
    )


def _constant_range(node: ast.expr) -> bool:
    return (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == "range"
        and not node.keywords
        and all(isinstance(a, ast.Constant) and type(a.value) is int for a in node.args)
    )


def _physics(module: str) -> set[str]:
    """Return the functions and constants that stand in one file of the studio's dynamics."""
    file = Path(next(iter(dynamics.__path__))) / f"{module}.py"
    _need(module.isidentifier() and module not in _NO_PHYSICS and file.is_file())
    found: set[str] = set()
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
            found |= {t.id for t in node.targets if isinstance(t, ast.Name)}
    return found

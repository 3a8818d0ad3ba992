"""Turn a law's syntax tree into bare source for numba: names become indices, loops burn fuel."""

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from types import FunctionType

from hapkit_studio.errors import LawError
from hapkit_studio.laws import subset
from hapkit_studio.laws.subset import fail
from hapkit_studio.parameters import AnyParameter, Choice

FUEL = 20_000

HEADER = '''\
"""Generated from a force law; edit the law, not this file."""

import math

from numba import cfunc, njit, types

_VALUES = types.CPointer(types.float64)
_FAULT = types.CPointer(types.int64)
_SIGNATURE = types.float64(
    _VALUES, _VALUES, types.float64, types.float64, types.float64, _FAULT
)


@njit(cache=True, error_model="numpy")
def _index(i, size, line, fault):
    k = int(i)
    if i != i or k < 0 or k >= size:
        if fault[0] == 0:
            fault[0] = 2
            fault[1] = line
        return 0
    return k
'''


def function_tree(function: Callable) -> ast.FunctionDef:
    """Return a function's syntax tree with the line numbers of its file."""
    try:
        lines, first = inspect.getsourcelines(function)
    except OSError:
        raise LawError(f"The source of {function.__name__!r} cannot be read; write it in a file.") from None
    tree = ast.parse(textwrap.dedent("".join(lines)))
    ast.increment_lineno(tree, first - 1)
    node = tree.body[0]
    if not isinstance(node, ast.FunctionDef):
        raise fail(node, "a law is a function")
    return node


class _Body(ast.NodeTransformer):
    """Rewrites one function; keeps the names that are surely set, so that none is read before."""

    def __init__(self, names: "Names", arguments: Sequence[str], is_law: bool):
        self.names, self.is_law = names, is_law
        self.known = set(arguments)
        self.helpers: list[str] = []

    # --- statements
    def block(self, statements: list[ast.stmt]) -> list[ast.stmt]:
        out: list[ast.stmt] = []
        for statement in statements:
            new = self.visit(statement)
            out.extend(new if isinstance(new, list) else [new])
        return out

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            return ast.Pass()
        raise fail(node, "this line computes nothing: assign it to a name or return it")

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        if len(node.targets) != 1:
            raise fail(node, "one name at a time: write one line for each")
        value = self.visit(node.value)
        return ast.Assign([self._target(node.targets[0])], value, lineno=node.lineno)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        subset.check_operator(node)
        if isinstance(node.target, ast.Name):
            self._read(node.target)
        value = self.visit(node.value)
        return ast.AugAssign(self._target(node.target), node.op, value)  # type: ignore[arg-type]

    def visit_If(self, node: ast.If) -> ast.stmt:
        test = self.visit(node.test)
        before = set(self.known)
        body = self.block(node.body)
        after_body = self.known if not _leaves(node.body) else None
        self.known = set(before)
        orelse = self.block(node.orelse)
        after_else = self.known if not _leaves(node.orelse) else None
        kept = [k for k in (after_body, after_else) if k is not None]
        self.known = set.intersection(*kept) if kept else before
        return ast.If(test, body or [ast.Pass()], orelse)

    def visit_For(self, node: ast.For) -> ast.stmt:
        subset.check_range(node)
        assert isinstance(node.target, ast.Name)
        before = set(self.known)
        self.known.add(node.target.id)
        burn = ast.parse(
            f"_fuel -= 1\nif _fuel < 0:\n    fault[0] = 3\n    fault[1] = {node.lineno}\n    return math.nan"
        ).body
        body = burn + self.block(node.body)
        self.known = before
        return ast.For(ast.Name(node.target.id, ast.Store()), node.iter, body, [])

    def visit_Return(self, node: ast.Return) -> ast.stmt:
        if node.value is None:
            raise fail(node, "a law returns a force: `return 0.0`")
        return ast.Return(self.visit(node.value))

    def visit_Pass(self, node: ast.Pass) -> ast.stmt:
        return node

    def visit_Break(self, node: ast.Break) -> ast.stmt:
        return node

    def visit_Continue(self, node: ast.Continue) -> ast.stmt:
        return node

    def _target(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Name):
            if node.id in subset.ARGUMENTS or node.id.startswith("_"):
                raise fail(node, f"`{node.id}` cannot be assigned; choose another name")
            self.known.add(node.id)
            return ast.Name(node.id, ast.Store())
        place = self._state(node)
        if place is None:
            raise fail(node, "only names and the state `s` can be assigned")
        return ast.Subscript(ast.Name("s", ast.Load()), place, ast.Store())

    # --- expressions
    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        subset.check_operator(node)
        return ast.BinOp(self.visit(node.left), node.op, self.visit(node.right))

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        if isinstance(node.op, ast.Invert):
            raise fail(node, "`~` is not allowed in a law")
        return ast.UnaryOp(node.op, self.visit(node.operand))

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        return ast.BoolOp(node.op, [self.visit(v) for v in node.values])

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        return ast.IfExp(self.visit(node.test), self.visit(node.body), self.visit(node.orelse))

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        subset.check_comparison(node)
        sides = [node.left, *node.comparators]
        choice = next((c for c in map(self.names.choice, sides) if c), None)
        new = [self._option(s, choice) if isinstance(_constant(s), str) else self.visit(s) for s in sides]
        return ast.Compare(new[0], node.ops, new[1:])

    def _option(self, node: ast.expr, choice: Choice | None) -> ast.expr:
        text = _constant(node)
        if choice is None:
            raise fail(node, f"{text!r} can only be compared with a choice of the parameters")
        if text not in choice.options:
            raise fail(node, f"{choice.label} is one of {', '.join(choice.options)}, not {text!r}")
        return ast.Constant(float(choice.options.index(text)))

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if isinstance(node.value, bool):
            return node
        if isinstance(node.value, int | float):
            return ast.Constant(float(node.value))
        raise fail(node, "only numbers are allowed here")

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self.known and node.id not in ("p", "s"):
            return node
        constant = self.names.globals.get(node.id)
        if isinstance(constant, int | float) and not isinstance(constant, bool):
            return ast.Constant(float(constant))
        return self._read(node)

    def _read(self, node: ast.Name) -> ast.expr:
        if node.id not in self.known:
            raise fail(node, f"'{node.id}' is not defined")
        if node.id in ("p", "s"):
            raise fail(node, f"`{node.id}` is used with a name: `{node.id}.name`")
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        owner = node.value.id if isinstance(node.value, ast.Name) else ""
        if owner == "math" and node.attr in subset.MATH_CONSTANTS:
            return ast.Constant(getattr(math, node.attr))
        if owner == "p" and self.is_law:
            index = ast.Constant(self.names.parameter(node))
            return ast.Subscript(ast.Name("p", ast.Load()), index, ast.Load())
        return self._load_state(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return self._load_state(node)

    def _load_state(self, node: ast.expr) -> ast.expr:
        place = self._state(node)
        if place is None:
            raise fail(node, "only `p.name`, `s.name` and `math` are known here")
        return ast.Subscript(ast.Name("s", ast.Load()), place, ast.Load())

    def _state(self, node: ast.expr) -> ast.expr | None:
        """Return the index expression of ``s.name`` or ``s.name[i]``, checked at run time if it varies."""
        inner = node.value if isinstance(node, ast.Subscript) else node
        if not (isinstance(inner, ast.Attribute) and isinstance(inner.value, ast.Name)):
            return None
        if inner.value.id != "s" or not self.is_law:
            return None
        start, size = self.names.state(inner)
        if not isinstance(node, ast.Subscript):
            if size:
                raise fail(node, "this state has several values: use it with an index")
            return ast.Constant(start)
        if not size:
            raise fail(node, "this state has one value: use it without an index")
        index = self.visit(node.slice)
        call = ast.parse(f"_index(0.0, {size}, {node.lineno}, fault)", mode="eval").body
        assert isinstance(call, ast.Call)
        call.args[0] = index
        return ast.BinOp(ast.Constant(start), ast.Add(), call)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if node.keywords:
            raise fail(node, "arguments are given in order in a law, without names")
        args = [self.visit(a) for a in node.args]
        return ast.Call(self._called(node.func), args, [])

    def _called(self, func: ast.expr) -> ast.expr:
        if isinstance(func, ast.Attribute) and isinstance(func.value, ast.Name) and func.value.id == "math":
            if func.attr in subset.MATH:
                return func
            raise fail(func, f"math.{func.attr} is not in the law language")
        if isinstance(func, ast.Name):
            if func.id in subset.BUILTINS:
                return func
            if isinstance(self.names.globals.get(func.id), FunctionType):
                self.helpers.append(func.id)
                return func
            raise fail(func, f"'{func.id}' is not a function that a law can call")
        raise fail(func, "this call is not allowed in a law")

    def generic_visit(self, node: ast.AST) -> ast.AST:
        raise subset.refuse(node)


def _constant(node: ast.expr) -> object:
    return node.value if isinstance(node, ast.Constant) else None


def _leaves(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _leaves(last.body) and _leaves(last.orelse)
    return isinstance(last, ast.Return | ast.Break | ast.Continue)


def _returns(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _returns(last.body) and _returns(last.orelse)
    return isinstance(last, ast.Return)


class Names:
    """What the words of one law stand for: parameters, state values, globals of its file."""

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


def _translate_one(tree: ast.FunctionDef, names: Names, is_law: bool) -> tuple[ast.FunctionDef, list[str]]:
    arguments = [a.arg for a in tree.args.args]
    if is_law and tuple(arguments) != subset.ARGUMENTS:
        raise fail(tree, "a law takes exactly (p, s, x, v, dt)")
    if not _returns(tree.body):
        raise fail(tree.body[-1], "a law must return a force on every path: end it with `return 0.0`")
    body = _Body(names, arguments, is_law)
    statements = body.block(tree.body)
    prologue = ast.parse(f"_fuel = {FUEL}").body
    extra = [ast.arg("fault")] if is_law else []
    tree.args.args = [ast.arg(a) for a in arguments] + extra
    new = ast.FunctionDef(tree.name, tree.args, prologue + statements, [], None)
    return new, body.helpers


def translate(function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]) -> str:
    """Return the bare source of a law and its helpers; raise LawError with the line of what is wrong."""
    names = Names(parameters, state, function.__globals__)  # type: ignore[attr-defined]
    tree, wanted = _translate_one(function_tree(function), names, is_law=True)
    tree.name = "law"
    helpers: dict[str, str] = {}
    _add_helpers(wanted, names, helpers, ())
    options = 'cache=True, error_model="numpy"'
    parts = [HEADER]
    parts += [f"@njit({options})\n{source}" for source in helpers.values()]
    parts.append(f"@cfunc(_SIGNATURE, {options})\n{ast.unparse(ast.fix_missing_locations(tree))}")
    return "\n\n".join(parts) + "\n"


def _add_helpers(wanted: list[str], names: Names, done: dict[str, str], callers: tuple[str, ...]) -> None:
    for name in wanted:
        if name in callers:
            raise LawError(f"`{name}` calls itself; a law's functions may not.")
        if name in done:
            continue
        tree, inner = _translate_one(function_tree(names.globals[name]), names, is_law=False)
        _add_helpers(inner, names, done, (*callers, name))
        source = ast.unparse(ast.fix_missing_locations(tree))
        # a helper has no fault word of its own: running out of fuel shows as not-a-number
        done[name] = source.replace("fault[0] = 3", "pass").replace("fault[1] = ", "_line = ")

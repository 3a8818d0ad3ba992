"""Translate a law and its helpers into plain source for numba: names become indices, faults are checked.

Every loop iteration uses one unit of fuel; a law without fuel stops. Each function that a law calls is
translated once.
"""

import ast
import hashlib
import inspect
import math
import textwrap
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import FunctionType

from hapkit_studio.dynamics import jit
from hapkit_studio.errors import LawError
from hapkit_studio.laws import subset, watch
from hapkit_studio.laws.mistakes import NOT_CONSTANT, instead_of
from hapkit_studio.laws.subset import BUILTINS, MATH, fail
from hapkit_studio.parameters import AnyParameter, Choice

# generated names begin with an underscore; names in a law never do
PREFIX, TABLE_PREFIX = "_of_", "_table_"
# the studio's functions are proven to terminate and to return a value for all arguments that a law may pass
_PROVEN = "hapkit_studio.dynamics."


class Helpers(dict[FunctionType, str]):
    """The functions that a law calls, by unique name in the generated file.

    ``tables`` contains the numbers of each table that the law and its functions read, by name in this file.
    """

    def __init__(self) -> None:
        super().__init__()
        self.tables: dict[str, tuple[float, ...]] = {}

    def __missing__(self, function: FunctionType) -> str:
        wanted = PREFIX + function.__name__
        while wanted in self.values():
            wanted += "_"
        self[function] = wanted
        return wanted

    def table(self, name: str, numbers: tuple[float, ...]) -> str:
        """Return a table's unique name in the generated file; two source files may use the same name."""
        wanted = TABLE_PREFIX + name
        while repr(self.tables.setdefault(wanted, numbers)) != repr(numbers):
            wanted += "_"
        return wanted


def is_proven(function: FunctionType) -> bool:
    """Return True if a function belongs to the studio, so that it needs no fuel and no division check."""
    return (function.__module__ or "").startswith(_PROVEN)


# CPython 3.11 fails if two threads parse at the same time ("AST constructor recursion depth mismatch")
_PARSING = threading.Lock()


def parse(text: str, name: str = "<unknown>") -> ast.Module:
    """Return the syntax tree of a source text; only one thread parses at a time. Raise like ``ast.parse``."""
    with _PARSING:
        return ast.parse(text, name)


@lru_cache(maxsize=256)
def _text(function: FunctionType) -> str:
    """Return a function's text with empty lines before it, so that line numbers are those of its file."""
    lines, first = inspect.getsourcelines(function)
    return "\n" * (first - 1) + textwrap.dedent("".join(lines))


def function_tree(function: Callable) -> ast.FunctionDef:
    """Return a function's syntax tree with the line numbers of its file."""
    if not isinstance(function, FunctionType):
        raise LawError(f"A law must be a function (p, s, x, v, dt), not {function!r}.")
    try:
        node = parse(_text(function)).body[0]
    except (OSError, SyntaxError):
        raise LawError(
            f"The source code of {function.__name__!r} cannot be read; write this function in a file."
        ) from None
    if not isinstance(node, ast.FunctionDef):
        raise fail(node, "a law must be a function")
    for name in function.__code__.co_freevars:
        raise fail(
            node, f"'{name}' is inside another function: write it at the top of the file, without indentation"
        )
    return node


def values_returned(tree: ast.FunctionDef) -> int:
    """Return how many values a function returns; raise LawError if this number is not constant."""
    found = sorted((n for n in ast.walk(tree) if isinstance(n, ast.Return)), key=lambda n: n.lineno)
    sizes = [len(n.value.elts) if isinstance(n.value, ast.Tuple) else 1 for n in found]
    for node, size in zip(found, sizes, strict=True):
        if size != sizes[0]:
            raise fail(
                node,
                f"`{tree.name}` returns {sizes[0]} values in one line and {size} here: "
                "write the same number of values after each `return`",
            )
    return sizes[0] if sizes else 1


class Names:
    """The parameters, state values and globals of a law's file."""

    def __init__(self, parameters: Sequence[AnyParameter], state: Mapping[str, object], scope: dict):
        self.parameters = {p.key: (i, p) for i, p in enumerate(parameters)}
        self.globals = scope
        self.places: dict[str, tuple[int, int]] = {}
        start = 0
        for key, value in state.items():
            size = len(value) if isinstance(value, tuple) else 0
            self.places[key] = (start, size)
            start += size or 1

    def function(self, name: str) -> FunctionType | None:
        """Return a function of the law's file or the studio's dynamics by its name; None for other names."""
        found = self.globals.get(name)
        found = getattr(found, "py_func", found)
        if not isinstance(found, FunctionType):
            return None
        return found if found.__globals__ is self.globals or is_proven(found) else None

    def table(self, node: ast.expr) -> tuple[float, ...] | None:
        """Return the numbers of a module-level table; None if the node is something else.

        Raise LawError for an invalid table.
        """
        found = self.globals.get(node.id) if isinstance(node, ast.Name) else None
        if not isinstance(found, tuple | list):
            return None
        assert isinstance(node, ast.Name)
        if not 1 <= len(found) <= subset.MOST_IN_TABLE:
            raise fail(
                node, f"`{node.id}` has {len(found)} numbers: a table must have 1 to {subset.MOST_IN_TABLE}"
            )
        for i, number in enumerate(found):
            usable = isinstance(number, int | float) and abs(number) <= subset.LARGEST_IN_TABLE
            if not usable:  # a NaN is also not usable
                wanted = f"the numbers of a table must be at most {subset.LARGEST_IN_TABLE:g}"
                raise fail(node, f"`{node.id}[{i}]` is {number!r:.40}: {wanted}")
        return tuple(map(float, found))

    def parameter(self, node: ast.Attribute) -> int:
        if node.attr not in self.parameters:
            raise fail(node, f"'p.{node.attr}' is not a parameter; available: {', '.join(self.parameters)}")
        return self.parameters[node.attr][0]

    def choice(self, node: ast.expr) -> Choice | None:
        match node:
            case ast.Attribute(value=ast.Name(id="p"), attr=key) if key in self.parameters:
                found = self.parameters[key][1]
                return found if isinstance(found, Choice) else None
        return None

    def state(self, node: ast.Attribute) -> tuple[int, int]:
        if node.attr not in self.places:
            known = ", ".join(self.places) or "none"
            text = f"'s.{node.attr}' is not a state of this law; available: {known}"
            raise fail(node, f'{text}. Add it above the law: `@law(state={{"{node.attr}": 0.0}})`')
        return self.places[node.attr]


# functions that return an integer in Python return a float here, so that infinities and NaN are preserved
FUNCTIONS = {"int": "_np.trunc", "float": "_float", "floor": "_np.floor", "ceil": "_np.ceil"}
FUNCTIONS |= {"fmod": "_np.fmod", "trunc": "_np.trunc"}
# CPython multiplies by the same factors
_FACTORS = {"radians": math.pi / 180.0, "degrees": 180.0 / math.pi}
_TABLE_IS = "a table must be a tuple of numbers, like `(0.0, 1.0)` or `tuple(…)`"
# functions with undefined or infinite values for some arguments
RISKY = frozenset(
    ("sqrt", "tan", "asin", "acos", "exp", "expm1", "log", "log1p", "log10", "sinh", "cosh", "pow")
)


class Rewriter(ast.NodeTransformer):
    """Rewrites one function.

    It tracks the names that are certainly assigned, to reject reads before assignment.
    """

    size = 1  # number of return values

    def __init__(
        self, names: Names, tree: ast.FunctionDef, function: FunctionType, helpers: Helpers, is_law: bool
    ):
        self.names, self.helpers, self.is_law = names, helpers, is_law
        self.proven = is_proven(function)
        self.known = {a.arg for a in tree.args.args}
        stored = (n for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
        self.local = self.known | {n.id for n in stored}
        self.called: list[FunctionType] = []

    # --- statements
    def nothing(self) -> str:
        """Return the expression that a function returns after a fault."""
        return ", ".join(["_math.nan"] * self.size)

    def burn(self, node: ast.stmt) -> list[ast.stmt]:
        """Return the statements that use one unit of fuel and return if no fuel is left."""
        if self.proven:
            return []
        return parse(f"if _spent({node.lineno}, _fault):\n    return {self.nothing()}").body

    def block(self, statements: list[ast.stmt]) -> list[ast.stmt]:
        out: list[ast.stmt] = []
        for statement in statements:
            new = self.visit(statement)
            several = new if isinstance(new, list) else [new]
            out.extend(ast.copy_location(one, statement) for one in several)
        return out

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            return ast.Pass()
        if isinstance(node.value, ast.Call):
            self.visit(node.value)  # report a mistake in the call itself first
        raise fail(node, "this line has no effect: assign its value to a name or return it")

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        if len(node.targets) != 1:
            raise fail(node, "assign one name at a time: write one line for each")
        target = node.targets[0]
        if isinstance(target, ast.Tuple):
            return self._assign_several(node, target)
        value = self.visit(node.value)
        return ast.Assign([self._target(target)], value, lineno=node.lineno)

    def _assign_several(self, node: ast.Assign, target: ast.Tuple) -> ast.stmt:
        size = len(target.elts)
        if not isinstance(node.value, ast.Tuple):
            value = self.call_of(node.value, size)
        elif len(node.value.elts) != size:
            raise fail(
                node,
                f"there are {size} names here, but {len(node.value.elts)} values: write as many values as "
                "names",
            )
        else:
            value = ast.Tuple([self.visit(v) for v in node.value.elts], ast.Load())
        names = ast.Tuple([self._target(t) for t in target.elts], ast.Store())
        return ast.Assign([names], value, lineno=node.lineno)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        subset.check_operator(node)
        before = self.visit(node.target)
        if isinstance(before, ast.Name):
            before = ast.Name(before.id, ast.Load())
        new = self._arithmetic(before, node.op, self.visit(node.value), node.lineno)
        return ast.Assign([self._target(node.target)], new, lineno=node.lineno)

    def visit_If(self, node: ast.If) -> ast.stmt:
        test = self.visit(node.test)
        before = set(self.known)
        body = self.block(node.body)
        after_body, self.known = self.known, set(before)
        orelse = self.block(node.orelse)
        sides = ((node.body, after_body), (node.orelse, self.known))
        kept = [known for side, known in sides if not _always_returns(side, ast.Break, ast.Continue)]
        self.known = set.intersection(*kept) if kept else before
        return ast.If(test, body or [ast.Pass()], orelse)

    def visit_For(self, node: ast.For) -> ast.stmt:
        numbers = self._range_arguments(node.iter)
        subset.check_loop(node, numbers)
        before = set(self.known)
        target = self._target(node.target)
        assert isinstance(target, ast.Name)
        count = f"_count_{target.id}"
        start = parse(f"{target.id} = _float({count})").body + self.burn(node)
        body = start + self.block(node.body)
        self.known = before
        turns = ast.Call(ast.Name("range", ast.Load()), [ast.Constant(n) for n in numbers], [])
        return ast.For(ast.Name(count, ast.Store()), turns, body, [])

    def _range_arguments(self, node: ast.expr) -> list[int]:
        """Return the arguments of a loop's ``range``; raise LawError unless all are integer constants."""
        if self._is_table(node):
            name = node.id  # type: ignore[attr-defined]
            raise fail(node, f"a loop must count: write `for i in range(len({name}))`, and `{name}[i]` in it")
        match node:
            case ast.Call(ast.Name("range"), [_] | [_, _] | [_, _, _] as args, []):
                numbers = [n for n in map(self._integer_constant, args) if n is not None]
                if len(numbers) == len(args):
                    return numbers
        raise fail(node, NOT_CONSTANT)

    def _integer_constant(self, node: ast.expr) -> int | None:
        """Return the value of an integer constant expression; None for any other expression."""
        match node:
            case ast.Constant(value=int() as number) if type(number) is int:
                return number
            case ast.Name(id=name) if name not in self.local and name != "range":
                constant = self.names.globals.get(name)
                return constant if type(constant) is int else None
            case ast.Call(ast.Name("len"), [_], []):
                return self._length(node)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                inner = self._integer_constant(operand)
                return None if inner is None else -inner
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() as op, right=right):
                a, b = self._integer_constant(left), self._integer_constant(right)
                if a is None or b is None:
                    return None
                return a + b if isinstance(op, ast.Add) else a - b if isinstance(op, ast.Sub) else a * b
        return None

    def visit_Return(self, node: ast.Return) -> ast.stmt:
        if node.value is None:
            raise fail(node, "a law must return a force: `return 0.0`")
        if not self.is_law and isinstance(node.value, ast.Tuple):
            several: list[ast.expr] = [_call("_float", [self.visit(v)]) for v in node.value.elts]
            return ast.Return(ast.Tuple(several, ast.Load()))
        value = self.visit(node.value)
        return ast.Return(_watched("_force", value, node.lineno) if self.is_law else value)

    def visit_Pass(self, node: ast.Pass | ast.Break | ast.Continue) -> ast.stmt:
        return node

    visit_Break = visit_Continue = visit_Pass

    def _target(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Name):
            reserved = self.is_law and node.id in subset.ARGUMENTS
            if reserved or (node.id.startswith("_") and node.id != "_"):
                raise fail(node, f"you cannot assign a value to `{node.id}`: choose another name")
            self.known.add(node.id)
            return ast.Name(node.id, ast.Store())
        if isinstance(node, ast.Subscript) and self._is_table(node.value):
            name = node.value.id  # type: ignore[attr-defined]
            raise fail(node, f"`{name}` is a table and cannot change: store changing values in the state `s`")
        place = self._state(node)
        if place is None:
            raise fail(node, "only names and the state `s` can be assigned")
        return ast.Subscript(ast.Name("s", ast.Load()), place, ast.Store())

    # --- expressions
    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        subset.check_operator(node)
        return self._arithmetic(self.visit(node.left), node.op, self.visit(node.right), node.lineno)

    def _arithmetic(self, left: ast.expr, op: ast.operator, right: ast.expr, line: int) -> ast.expr:
        """Return the operation; its operands become floats if integers would give a different result."""
        if isinstance(op, ast.FloorDiv | ast.Mod | ast.Pow):
            left, right = _call("_float", [left]), _call("_float", [right])
        never_zero = isinstance(right, ast.Constant) and bool(right.value)
        if isinstance(op, ast.Div | ast.FloorDiv | ast.Mod) and not self.proven and not never_zero:
            right = _watched("_divisor", right, line)
        result = ast.BinOp(left, op, right)
        return self._noted(result, line) if isinstance(op, ast.Pow) else result

    def _noted(self, value: ast.expr, line: int) -> ast.expr:
        """Return an expression that records its line at run time if its value is not finite."""
        return value if self.proven else _watched("_noted", value, line)

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
        named = all(isinstance(op, ast.Eq | ast.NotEq) for op in node.ops)
        new = [self._option(s, choice) if choice and named else self.visit(s) for s in sides]
        return ast.Compare(new[0], node.ops, new[1:])

    def _option(self, node: ast.expr, choice: Choice) -> ast.expr:
        """Return the expression for a choice's index, or for the index of an option that is given by name."""
        if self.names.choice(node) is choice:
            return self._parameter(node)
        if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
            raise fail(
                node, f"compare {choice.label} with the name of an option: {', '.join(choice.options)}"
            )
        if node.value not in choice.options:
            raise fail(node, f"{choice.label} must be one of {', '.join(choice.options)}, not {node.value!r}")
        return ast.Constant(float(choice.options.index(node.value)))

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if isinstance(node.value, bool):
            return node
        if isinstance(node.value, str):
            raise fail(node, f"the text {node.value!r} can only be compared with a choice parameter")
        return ast.Constant(self._number(node, node.value))

    def _number(self, node: ast.expr, value: object) -> float:
        try:
            if isinstance(value, int | float):
                return float(value)
        except OverflowError:
            raise fail(node, "this number is too large") from None
        raise fail(node, "only numbers are allowed here")

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in self.known:
            if node.id in ("p", "s") and self.is_law:
                raise fail(node, f"write a name after `{node.id}`: `{node.id}.name`")
            return node
        constant = self.names.globals.get(node.id)
        if self._is_table(node):
            raise fail(node, f"`{node.id}` is a table: use one of its numbers, `{node.id}[i]`")
        if node.id in self.local:
            raise fail(node, f"'{node.id}' does not have a value in every case: set it before this line")
        if not isinstance(constant, int | float):
            raise fail(node, self._undefined(node.id))
        return ast.Constant(self._number(node, constant))

    def _undefined(self, name: str) -> str:
        """Return the message for an undefined name."""
        for owner, known in (("p", self.names.parameters), ("s", self.names.places)):
            if name in known:
                return f"'{name}' is not defined: write `{owner}.{name}`"
        found = self.names.globals.get(name)
        if found is not None and not callable(found):
            return f"`{name}` is a `{type(found).__name__}`: {_TABLE_IS}"
        return instead_of(name) or f"'{name}' is not defined"

    def _is_table(self, node: ast.expr) -> bool:
        return isinstance(node, ast.Name) and node.id not in self.local and bool(self.names.table(node))

    def _entry(self, node: ast.Subscript) -> ast.expr:
        """Return a table entry; a variable index is checked at run time."""
        assert isinstance(node.value, ast.Name)
        numbers = self.names.table(node.value)
        assert numbers is not None
        name, size, index = node.value.id, len(numbers), self._integer_constant(node.slice)
        if index is not None and not 0 <= index < size:
            last = f"; the last is `{name}[len({name}) - 1]`" if index == -1 else ""
            raise fail(node, f"`{name}` has {size} numbers: the index must be between 0 and {size - 1}{last}")
        table = ast.Name(self.helpers.table(name, numbers), ast.Load())
        return ast.Subscript(table, self._index(node, size), ast.Load())

    def _index(self, node: ast.Subscript, size: int) -> ast.Call:
        """Return an index that is checked against ``size`` at run time."""
        call = _watched("_index", self.visit(node.slice), node.lineno)
        call.args.insert(1, ast.Constant(size))
        return call

    def _length(self, node: ast.Call) -> int:
        """Return the length of a table or a state for ``len``; raise LawError for anything else."""
        subset.check_count(node, "len", *BUILTINS["len"][:2])
        (what,) = node.args
        if self._is_table(what):
            return len(self.names.table(what) or ())
        match what:
            case ast.Attribute(value=ast.Name("s")) if self.is_law and self.names.state(what)[1]:
                return self.names.state(what)[1]
        raise fail(node, "the argument of `len` must be a table, or a state with several values")

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        owner = node.value.id if isinstance(node.value, ast.Name) else ""
        if owner == "math" and node.attr in subset.MATH_CONSTANTS and self._is_math(node):
            return ast.Constant(getattr(math, node.attr))
        if owner == "p" and self.is_law:
            choice = self.names.choice(node)
            if choice:
                raise fail(
                    node, f"compare {choice.label} with the name of an option: {', '.join(choice.options)}"
                )
            return self._parameter(node)
        return self.visit_Subscript(node)

    def _parameter(self, node: ast.expr) -> ast.expr:
        assert isinstance(node, ast.Attribute)
        return ast.Subscript(ast.Name("p", ast.Load()), ast.Constant(self.names.parameter(node)), ast.Load())

    def _is_math(self, node: ast.expr) -> bool:
        if "math" in self.local or self.names.globals.get("math") is not math:
            raise fail(
                node, "`math` here is not Python's module `math`: write `import math` at the top of the file"
            )
        return True

    def visit_Subscript(self, node: ast.Subscript | ast.Attribute) -> ast.expr:
        if isinstance(node, ast.Subscript) and self._is_table(node.value):
            return self._entry(node)
        place = self._state(node)
        if place is None:
            raise fail(node, self._unknown(node))
        return ast.Subscript(ast.Name("s", ast.Load()), place, ast.Load())

    def _unknown(self, node: ast.Subscript | ast.Attribute) -> str:
        """Return the message for an attribute or a subscript of an unknown object."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = node.value.id
            if owner in ("p", "s") and owner not in self.local:
                one = f"{owner}.{node.attr}"
                return f"`{owner}` can be used only in the law: pass `{one}` to the helper as an argument"
            if hint := instead_of(f"math.{node.attr}" if owner == "math" else owner):
                return hint
        match node:
            case ast.Subscript(value=ast.Name(id=name)) if name not in self.local:
                return self._undefined(name)
        known = "`p.name`, `s.name`, tables" if self.is_law else "the arguments of this function, tables"
        return f"only {known} and `math` can be used here"

    def _state(self, node: ast.expr) -> ast.expr | None:
        """Return the index expression of ``s.name`` or ``s.name[i]``; a variable index is checked."""
        inner = node.value if isinstance(node, ast.Subscript) else node
        if not (self.is_law and isinstance(inner, ast.Attribute) and isinstance(inner.value, ast.Name)):
            return None
        if inner.value.id != "s":
            return None
        start, size = self.names.state(inner)
        if not isinstance(node, ast.Subscript):
            if size:
                raise fail(node, "this state has several values: choose one with an index, `[i]`")
            return ast.Constant(start)
        if not size:
            raise fail(node, "this state has one value: use it without an index")
        return ast.BinOp(ast.Constant(start), ast.Add(), self._index(node, size))

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if node.keywords:
            raise fail(node, "arguments in a law must be given in order, without names")
        func = node.func
        if isinstance(func, ast.Name) and self._helper(func.id):
            return self.call_of(node, 1)
        match func:
            case ast.Attribute(value=ast.Name(id="math"), attr=name):
                if name not in MATH or not self._is_math(func):
                    hint = instead_of(f"math.{name}")
                    raise fail(func, hint or f"math.{name} is not in the law language")
                return self._math_call(node, name)
            case ast.Name(id=name):
                return self._builtin_call(node, name)
            case ast.Attribute(value=ast.Name(id=owner)) if hint := instead_of(owner):
                raise fail(func, hint)
        raise fail(func, "this call is not allowed in a law")

    def _math_call(self, node: ast.Call, name: str) -> ast.expr:
        args = [self.visit(a) for a in node.args]
        subset.check_count(node, f"math.{name}", *MATH[name][:2])
        if name in _FACTORS:
            return ast.BinOp(args[0], ast.Mult(), ast.Constant(_FACTORS[name]))
        if name == "fmod" and not self.proven:
            args[1] = _watched("_divisor", args[1], node.lineno)
        value = _call(FUNCTIONS.get(name, f"_math.{name}"), args)
        return self._noted(value, node.lineno) if name in RISKY else value

    def _builtin_call(self, node: ast.Call, name: str) -> ast.expr:
        scope = self.names.globals
        if name not in self.local and name in MATH and scope.get(name) is getattr(math, name):
            return self._math_call(node, name)  # the function is imported by name
        if name in self.local or name in scope or name not in BUILTINS:
            hint = None if name in self.local or name in scope else instead_of(name)
            raise fail(node, hint or f"'{name}' is not a function that a law can call")
        if name == "len":
            return ast.Constant(float(self._length(node)))
        args = [self.visit(a) for a in node.args]
        subset.check_count(node, name, *BUILTINS[name][:2])
        return _call(FUNCTIONS.get(name, name), args)

    def _helper(self, name: str) -> FunctionType | None:
        return None if name in self.local else self.names.function(name)

    def call_of(self, node: ast.expr, size: int) -> ast.expr:
        """Return the call of a helper that returns ``size`` values."""
        call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        found = self._helper(node.func.id) if call else None  # type: ignore[attr-defined]
        if found is None:
            raise fail(node, f"there are {size} names here, but one value: write as many values as names")
        assert isinstance(node, ast.Call)
        name = found.__name__
        given = values_returned(function_tree(found))
        if given != size:
            values = f"{given} value{'s' * (given != 1)}"
            names = ", ".join("abcdefghijklmnop"[:given])
            raise fail(node, f"`{name}` returns {values}: store them with `{names} = {name}(…)`")
        if node.keywords:
            raise fail(node, "arguments in a law must be given in order, without names")
        most, defaults = found.__code__.co_argcount, found.__defaults__ or ()
        for one in node.args:
            self._check_given(one, name)
        subset.check_count(node, name, most - len(defaults), most)
        self.called.append(found)
        args: list[ast.expr] = []
        for one in node.args:
            # a choice is passed as the index of its option
            is_choice = self.is_law and self.names.choice(one)
            args.append(self._parameter(one) if is_choice else _call("_float", [self.visit(one)]))
        missing = defaults[len(defaults) - (most - len(args)) :] if len(args) < most else ()
        args += [ast.Constant(self._number(node, default)) for default in missing]
        return _call(self.helpers[found], [*args, ast.Name("_fault", ast.Load())])

    def _check_given(self, node: ast.expr, name: str) -> None:
        """Raise LawError if a helper receives all parameters, the whole state or a whole table."""
        if not isinstance(node, ast.Name):
            return
        if self.is_law and node.id in ("p", "s"):
            one = next(iter(self.names.parameters if node.id == "p" else self.names.places), "name")
            text = f"pass single values instead of `{node.id}`, as in `{name}({node.id}.{one})`"
            raise fail(node, f"the arguments of a helper function must be numbers: {text}")
        if self._is_table(node):
            raise fail(
                node,
                f"the arguments of a helper function must be numbers: use the table `{node.id}[i]` in the "
                "helper function",
            )

    def generic_visit(self, node: ast.AST) -> ast.AST:
        raise subset.refuse(node)


def _call(name: str, args: list[ast.expr]) -> ast.Call:
    (statement,) = parse(name).body
    assert isinstance(statement, ast.Expr)
    return ast.Call(statement.value, args, [])


def _watched(function: str, value: ast.expr, line: int) -> ast.Call:
    return _call(function, [value, ast.Constant(line), ast.Name("_fault", ast.Load())])


def _always_returns(statements: list[ast.stmt], *ends: type[ast.stmt]) -> bool:
    """Return True if every path through statements ends with a `return` or with one of ``ends``."""
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _always_returns(last.body, *ends) and _always_returns(last.orelse, *ends)
    return isinstance(last, (ast.Return, *ends))


FUEL = 20_000

# The generated file contains this hash, so a change of the watch functions invalidates the cache.
_WATCHED = hashlib.sha256(inspect.getsource(watch).encode()).hexdigest()[:20]
HEADER = f'''\
"""Generated from a force law, watched by {_WATCHED}; edit the law, not this file."""

import math as _math

import numpy as _np
from numba import cfunc, njit, types

from hapkit_studio.dynamics.jit import internal as _helper
from hapkit_studio.laws.watch import divisor as _divisor
from hapkit_studio.laws.watch import force as _force
from hapkit_studio.laws.watch import index as _index
from hapkit_studio.laws.watch import noted as _noted
from hapkit_studio.laws.watch import spent as _spent
from hapkit_studio.laws.watch import to_float as _float

_VALUES = types.CPointer(types.float64)
_FAULT = types.CPointer(types.int64)
_SIGNATURE = types.float64(
    _VALUES, _VALUES, types.float64, types.float64, types.float64, _FAULT
)
'''
LAW_START = f"""\
if _fault[0] != 0:
    return _math.nan
_fault[1] = _fault[3] if _fault[3] > 0 else {FUEL}
_fault[2] = 0"""


def rewritten(
    function: FunctionType, names: Names, helpers: Helpers, is_law: bool
) -> tuple[ast.FunctionDef, list[FunctionType]]:
    """Return a checked function's tree with names replaced and faults checked, and the helpers it calls."""
    tree = function_tree(function)
    subset.check_arguments(tree, is_law)
    compiling = (jit.compiled, jit.internal, jit.inlined)  # these decorators affect only the compilation
    for one in [] if is_law else tree.decorator_list:
        if not (isinstance(one, ast.Name) and names.globals.get(one.id) in compiling):
            raise fail(
                tree, f"`{tree.name}` is called by a law, so it must not have a decorator (`@` above it)"
            )
    body = Rewriter(names, tree, function, helpers, is_law)
    body.size = 1 if is_law else values_returned(tree)
    statements = ([] if is_law else body.burn(tree)) + body.block(tree.body)
    if not _always_returns(tree.body):  # statements outside the language were already reported
        what = "a law must return a force" if is_law else f"`{tree.name}` must return a number"
        raise fail(tree.body[-1], f"{what} in every case: end the function with `return 0.0`")
    arguments = [ast.arg(a.arg) for a in (*tree.args.args, ast.arg("_fault"))]
    signature = ast.arguments([], arguments, None, [], [], None, [])
    name = "law" if is_law else helpers[function]
    return ast.FunctionDef(name, signature, statements, [], None), body.called


@dataclass(frozen=True)
class CheckedLaw:
    """The checked trees of a law and its functions.

    In the trees, indices replace p and s, and unique names replace helpers.

    ``own`` are the names of the functions in the law's file. ``documents`` contains docstrings by function,
    and ``tables`` numbers by table name.
    """

    tree: ast.FunctionDef
    helpers: dict[str, ast.FunctionDef]
    own: frozenset[str]
    documents: dict[str, str]
    tables: Mapping[str, tuple[float, ...]]


def checked(
    function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]
) -> CheckedLaw:
    """Return a law's trees; raise LawError with the line of the mistake."""
    function_tree(function)
    assert isinstance(function, FunctionType)
    helpers = Helpers()
    trees: dict[str, ast.FunctionDef] = {}

    def add(wanted: Sequence[FunctionType], callers: tuple[FunctionType, ...]) -> None:
        """Add functions in topological order, callees first."""
        for one in wanted:
            if one in callers:
                raise fail(
                    function_tree(one),
                    f"`{one.__name__}` calls itself: this is not allowed in a law",
                )
            if helpers[one] not in trees:
                made, inner = rewritten(one, Names((), {}, one.__globals__), helpers, False)
                add(inner, (*callers, one))
                trees[helpers[one]] = made

    tree, called = rewritten(function, Names(parameters, state, function.__globals__), helpers, True)
    add(called, ())
    same = function.__code__.co_filename
    own = frozenset(name for f, name in helpers.items() if f.__code__.co_filename == same)
    documents = {name: f.__doc__ or "" for f, name in helpers.items()}
    return CheckedLaw(tree, trees, own, documents, helpers.tables)


def translate(function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]) -> str:
    """Return the plain source of a law and its helpers; raise LawError with the line of the mistake."""
    law = checked(function, parameters, state)
    law.tree.body[:0] = parse(LAW_START).body
    for tree in (law.tree, *law.helpers.values()):
        ast.fix_missing_locations(tree)
    parts = [HEADER, *(f"{name} = _np.array({list(numbers)!r})" for name, numbers in law.tables.items())]
    parts += [f"@_helper\n{ast.unparse(helper)}" for helper in law.helpers.values()]
    parts.append(f'@cfunc(_SIGNATURE, cache=True, error_model="numpy", _nrt=False)\n{ast.unparse(law.tree)}')
    return "\n\n".join(parts) + "\n"

"""Turn a law and its helpers into bare source for numba: statement by statement, and loops burn fuel."""

import ast
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import FunctionType

from hapkit_studio.laws import subset
from hapkit_studio.laws.expressions import (
    Expressions,
    Helpers,
    Names,
    function_tree,
    values_returned,
    without_conversions,
)
from hapkit_studio.laws.native import LAW_DIVISION, LAW_FUEL, LAW_INDEX, NOT_A_NUMBER
from hapkit_studio.laws.subset import fail
from hapkit_studio.parameters import AnyParameter


class Body(Expressions):
    """Rewrites one function; keeps the names that are surely set, so that none is read before."""

    size = 1

    def nothing(self) -> str:
        """Return what the function gives back where it cannot go on."""
        return ", ".join(["_math.nan"] * self.size)

    def burn(self, node: ast.stmt) -> list[ast.stmt]:
        """Return the lines that take one unit of fuel and leave the function where none is left."""
        if self.proven:
            return []
        return ast.parse(f"if _spent({node.lineno}, _fault):\n    return {self.nothing()}").body

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
        raise fail(node, "this line computes nothing: assign it to a name or return it")

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        if len(node.targets) != 1:
            raise fail(node, "one name at a time: write one line for each")
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
            raise fail(node, f"there are {size} names here, but {len(node.value.elts)} values")
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
        after_body = self.known if not _leaves(node.body) else None
        self.known = set(before)
        orelse = self.block(node.orelse)
        after_else = self.known if not _leaves(node.orelse) else None
        kept = [k for k in (after_body, after_else) if k is not None]
        self.known = set.intersection(*kept) if kept else before
        return ast.If(test, body or [ast.Pass()], orelse)

    def visit_For(self, node: ast.For) -> ast.stmt:
        subset.check_range(node)
        before = set(self.known)
        target = self._target(node.target)
        assert isinstance(target, ast.Name)
        count = f"_count_{target.id}"
        start = ast.parse(f"{target.id} = _float({count})").body + self.burn(node)
        body = start + self.block(node.body)
        self.known = before
        return ast.For(ast.Name(count, ast.Store()), node.iter, body, [])

    def visit_Return(self, node: ast.Return) -> ast.stmt:
        if node.value is None:
            raise fail(node, "a law returns a force: `return 0.0`")
        if not self.is_law and isinstance(node.value, ast.Tuple):
            several: list[ast.expr] = [
                ast.Call(ast.Name("_float", ast.Load()), [self.visit(v)], []) for v in node.value.elts
            ]
            return ast.Return(ast.Tuple(several, ast.Load()))
        value = self.visit(node.value)
        if self.is_law:
            line, fault = ast.Constant(node.lineno), ast.Name("_fault", ast.Load())
            value = ast.Call(ast.Name("_force", ast.Load()), [value, line, fault], [])
        return ast.Return(value)

    def visit_Pass(self, node: ast.Pass) -> ast.stmt:
        return node

    def visit_Break(self, node: ast.Break) -> ast.stmt:
        return node

    def visit_Continue(self, node: ast.Continue) -> ast.stmt:
        return node

    def _target(self, node: ast.expr) -> ast.expr:
        if isinstance(node, ast.Name):
            reserved = self.is_law and node.id in subset.ARGUMENTS
            if reserved or (node.id.startswith("_") and node.id != "_"):
                raise fail(node, f"`{node.id}` cannot be assigned; choose another name")
            self.known.add(node.id)
            return ast.Name(node.id, ast.Store())
        place = self._state(node)
        if place is None:
            raise fail(node, "only names and the state `s` can be assigned")
        return ast.Subscript(ast.Name("s", ast.Load()), place, ast.Store())


def _leaves(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _leaves(last.body) and _leaves(last.orelse)
    return isinstance(last, ast.Return | ast.Break | ast.Continue)


FUEL = 20_000

HEADER = f'''\
"""Generated from a force law; edit the law, not this file."""

import math as _math

import numpy as _np
from numba import cfunc, njit, types

_VALUES = types.CPointer(types.float64)
_FAULT = types.CPointer(types.int64)
_SIGNATURE = types.float64(
    _VALUES, _VALUES, types.float64, types.float64, types.float64, _FAULT
)
# Only the law is called from outside, and nothing allocates: ways in and reference counts cost compiling.
_helper = njit(
    cache=True, error_model="numpy", _nrt=False, no_cpython_wrapper=True, no_cfunc_wrapper=True
)


@_helper
def _float(a):
    return a * 1.0


@_helper
def _index(i, size, line, fault):
    if 0 <= i < size:
        return int(i)
    if fault[0] == 0:
        fault[0] = {LAW_INDEX}
        fault[1] = line
    return 0


@_helper
def _spent(line, fault):
    if fault[0] == 0:
        fault[1] -= 1
        if fault[1] < 0:
            fault[0] = {LAW_FUEL}
            fault[1] = line
    return fault[0] != 0


@_helper
def _divisor(a, line, fault):
    if a == 0.0 and fault[0] == 0:
        fault[0] = {LAW_DIVISION}
        fault[1] = line
    return a * 1.0


@_helper
def _noted(a, line, fault):
    if fault[2] == 0 and not _math.isfinite(a):
        fault[2] = line
    return a * 1.0


@_helper
def _force(a, line, fault):
    if fault[0] == 0 and not _math.isfinite(a):
        fault[0] = {NOT_A_NUMBER}
        fault[1] = fault[2] if fault[2] else line
    return a * 1.0
'''
LAW_START = f"""\
if _fault[0] != 0:
    return _math.nan
_fault[1] = {FUEL}
_fault[2] = 0"""


def _returns(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _returns(last.body) and _returns(last.orelse)
    return isinstance(last, ast.Return)


def rewritten(
    function: FunctionType, names: Names, helpers: Helpers, is_law: bool
) -> tuple[ast.FunctionDef, list[FunctionType]]:
    """Return a checked function's tree, names replaced and faults watched, and the helpers it calls."""
    tree = function_tree(function)
    subset.check_arguments(tree, is_law)
    if not is_law and not all(map(names.is_compiling, tree.decorator_list)):
        raise fail(tree, f"`{tree.name}` is called by a law: it may not have a decorator")
    body = Body(names, tree, function, helpers, is_law)
    body.size = 1 if is_law else values_returned(tree)
    start = ast.parse(LAW_START).body if is_law else body.burn(tree)
    statements = start + body.block(tree.body)
    if not _returns(tree.body):  # what is not allowed at all was named before
        what = "a law must return a force" if is_law else f"`{tree.name}` must return a number"
        raise fail(tree.body[-1], f"{what} on every path: end it with `return 0.0`")
    arguments = [ast.arg(a.arg) for a in (*tree.args.args, ast.arg("_fault"))]
    signature = ast.arguments([], arguments, None, [], [], None, [])
    name = "law" if is_law else helpers.name(function)
    return ast.FunctionDef(name, signature, statements, [], None), body.called


def _translate_one(
    function: FunctionType, names: Names, helpers: Helpers, is_law: bool
) -> tuple[str, list[FunctionType]]:
    """Return a function's bare source and the helpers it calls."""
    new, called = rewritten(function, names, helpers, is_law)
    return ast.unparse(ast.fix_missing_locations(without_conversions(new))), called


@dataclass(frozen=True)
class CheckedLaw:
    """A law and the functions that it calls as checked trees: p, s and helpers by their numbers and names.

    own: names of the functions that stand in the law's own file; documents: the functions' docstrings.
    """

    tree: ast.FunctionDef
    helpers: dict[str, ast.FunctionDef]
    own: frozenset[str]
    documents: dict[str, str]


def checked(
    function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]
) -> CheckedLaw:
    """Return a law's trees; raise LawError with the line of what is wrong."""
    function_tree(function)
    assert isinstance(function, FunctionType)
    helpers = Helpers()
    names = Names(parameters, state, function.__globals__)
    tree, wanted = rewritten(function, names, helpers, is_law=True)
    tree.body = tree.body[len(ast.parse(LAW_START).body) :]
    trees: dict[str, ast.FunctionDef] = {}
    while wanted:
        one = wanted.pop()
        if helpers.name(one) not in trees:
            trees[helpers.name(one)], more = rewritten(one, Names((), {}, one.__globals__), helpers, False)
            wanted += more
    same = function.__code__.co_filename
    own = frozenset(name for f, name in helpers.names.items() if f.__code__.co_filename == same)
    documents = {name: f.__doc__ or "" for f, name in helpers.names.items()}
    return CheckedLaw(tree, trees, own, documents)


def translate(function: Callable, parameters: Sequence[AnyParameter], state: Mapping[str, object]) -> str:
    """Return the bare source of a law and its helpers; raise LawError with the line of what is wrong."""
    function_tree(function)
    assert isinstance(function, FunctionType)
    helpers = Helpers()
    names = Names(parameters, state, function.__globals__)
    source, wanted = _translate_one(function, names, helpers, is_law=True)
    sources: dict[FunctionType, str] = {}
    _add_helpers(wanted, helpers, sources, ())
    parts = [HEADER]
    parts += [f"@_helper\n{helper}" for helper in sources.values()]
    parts.append(f'@cfunc(_SIGNATURE, cache=True, error_model="numpy", _nrt=False)\n{source}')
    return "\n\n".join(parts) + "\n"


def _add_helpers(
    wanted: list[FunctionType],
    helpers: Helpers,
    done: dict[FunctionType, str],
    callers: tuple[FunctionType, ...],
) -> None:
    for function in wanted:
        if function in callers:
            tree = function_tree(function)
            raise fail(tree, f"`{function.__name__}` calls itself; a law's functions may not")
        if function in done:
            continue
        names = Names((), {}, function.__globals__)
        source, inner = _translate_one(function, names, helpers, is_law=False)
        _add_helpers(inner, helpers, done, (*callers, function))
        done[function] = source

"""Rewrites the body of a law for numba: names become indices, loops burn fuel."""

import ast
import math
from types import FunctionType

from hapkit_studio.laws import subset
from hapkit_studio.laws.names import Names
from hapkit_studio.laws.subset import fail
from hapkit_studio.parameters import Choice

# Generated names begin with an underscore, a law's own never do.
HELPER = "_of_"
BURN = "if _spent({line}, _fault):\n    return _math.nan"
# Whole numbers stay floats: what has no end, or is no number, remains so.
FUNCTIONS = {"int": "_np.trunc", "float": "_float", "floor": "_np.floor", "ceil": "_np.ceil"}
FUNCTIONS |= {"fmod": "_np.fmod"}


class Body(ast.NodeTransformer):
    """Rewrites one function; keeps the names that are surely set, so that none is read before."""

    def __init__(self, names: Names, tree: ast.FunctionDef, is_law: bool):
        self.names, self.is_law = names, is_law
        self.known = {a.arg for a in tree.args.args}
        self.local = {
            n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        }
        self.local |= self.known
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
        new = self._arithmetic(self.visit(node.target), node.op, self.visit(node.value))
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
        start = ast.parse(f"{target.id} = _float({count})\n" + BURN.format(line=node.lineno)).body
        body = start + self.block(node.body)
        self.known = before
        return ast.For(ast.Name(count, ast.Store()), node.iter, body, [])

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
        return self._arithmetic(self.visit(node.left), node.op, self.visit(node.right))

    def _arithmetic(self, left: ast.expr, op: ast.operator, right: ast.expr) -> ast.expr:
        """Return left op right; what differs between whole numbers and floats is done on floats."""
        if isinstance(op, ast.FloorDiv | ast.Mod | ast.Pow):
            left, right = _as_float(left), _as_float(right)
        return ast.BinOp(left, op, right)

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
        if choice is None or not all(isinstance(op, ast.Eq | ast.NotEq) for op in node.ops):
            new = [self.visit(s) for s in sides]
        else:
            new = [self._option(s, choice) for s in sides]
        return ast.Compare(new[0], node.ops, new[1:])

    def _option(self, node: ast.expr, choice: Choice) -> ast.expr:
        """Return the index of a choice or of its option's name."""
        if self.names.choice(node) is choice:
            assert isinstance(node, ast.Attribute)
            return self._parameter(node)
        text = _constant(node)
        if not isinstance(text, str):
            raise fail(node, f"{choice.label} is compared with a name: {', '.join(choice.options)}")
        if text not in choice.options:
            raise fail(node, f"{choice.label} is one of {', '.join(choice.options)}, not {text!r}")
        return ast.Constant(float(choice.options.index(text)))

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if isinstance(node.value, bool):
            return node
        if isinstance(node.value, str):
            raise fail(node, f"{node.value!r} can only be compared with a choice of the parameters")
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
                raise fail(node, f"`{node.id}` is used with a name: `{node.id}.name`")
            return node
        constant = self.names.globals.get(node.id)
        if node.id in self.local or not isinstance(constant, int | float):
            raise fail(node, f"'{node.id}' is not defined")
        return ast.Constant(self._number(node, constant))

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        owner = node.value.id if isinstance(node.value, ast.Name) else ""
        if owner == "math" and node.attr in subset.MATH_CONSTANTS and self._is_math(node):
            return ast.Constant(getattr(math, node.attr))
        if owner == "p" and self.is_law:
            choice = self.names.choice(node)
            if choice:
                raise fail(node, f"{choice.label} is compared with a name: {', '.join(choice.options)}")
            return self._parameter(node)
        return self._load_state(node)

    def _parameter(self, node: ast.Attribute) -> ast.expr:
        return ast.Subscript(ast.Name("p", ast.Load()), ast.Constant(self.names.parameter(node)), ast.Load())

    def _is_math(self, node: ast.expr) -> bool:
        if "math" in self.local or self.names.globals.get("math") is not math:
            raise fail(node, "`math` is not the module: write `import math` at the top of the file")
        return True

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        return self._load_state(node)

    def _load_state(self, node: ast.expr) -> ast.expr:
        place = self._state(node)
        if place is None:
            known = "`p.name`, `s.name`" if self.is_law else "its own arguments"
            raise fail(node, f"only {known} and `math` are known here")
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
        call = ast.parse(f"_index(0.0, {size}, {node.lineno}, _fault)", mode="eval").body
        assert isinstance(call, ast.Call)
        call.args[0] = index
        return ast.BinOp(ast.Constant(start), ast.Add(), call)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if node.keywords:
            raise fail(node, "arguments are given in order in a law, without names")
        args = [self.visit(a) for a in node.args]
        func = node.func
        if isinstance(func, ast.Attribute) and isinstance(func.value, ast.Name) and func.value.id == "math":
            if func.attr not in subset.MATH or not self._is_math(func):
                raise fail(func, f"math.{func.attr} is not in the law language")
            subset.check_count(node, f"math.{func.attr}", subset.MATH[func.attr])
            return _call(FUNCTIONS.get(func.attr, f"_math.{func.attr}"), args)
        if not isinstance(func, ast.Name):
            raise fail(func, "this call is not allowed in a law")
        return self._named_call(node, func.id, args)

    def _named_call(self, node: ast.Call, name: str, args: list[ast.expr]) -> ast.expr:
        found = self.names.globals.get(name)
        own = isinstance(found, FunctionType) and found.__globals__ is self.names.globals
        if name in self.local or (not own and (found is not None or name not in subset.BUILTINS)):
            raise fail(node, f"'{name}' is not a function that a law can call")
        if own:
            assert isinstance(found, FunctionType)
            subset.check_count(node, name, (found.__code__.co_argcount, found.__code__.co_argcount))
            self.helpers.append(name)
            return _call(HELPER + name, [*args, ast.Name("_fault", ast.Load())])
        subset.check_count(node, name, subset.BUILTINS[name])
        return _call(FUNCTIONS.get(name, name), args)

    def generic_visit(self, node: ast.AST) -> ast.AST:
        raise subset.refuse(node)


def _call(name: str, args: list[ast.expr]) -> ast.expr:
    return ast.Call(ast.parse(name, mode="eval").body, args, [])


def _as_float(node: ast.expr) -> ast.expr:
    return _call("_float", [node])


def _constant(node: ast.expr) -> object:
    return node.value if isinstance(node, ast.Constant) else None


def _leaves(statements: list[ast.stmt]) -> bool:
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return _leaves(last.body) and _leaves(last.orelse)
    return isinstance(last, ast.Return | ast.Break | ast.Continue)

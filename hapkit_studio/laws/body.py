"""Rewrites the body of a law for numba: statement by statement, and loops burn fuel."""

import ast

from hapkit_studio.laws import subset
from hapkit_studio.laws.expressions import Expressions
from hapkit_studio.laws.subset import fail


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

"""Writes what soft floating point does dearly in cheaper words, where the value stays the same.

A comparison with zero or of equality looks at bits, a product with a power of two or with a sign changes
them, a division by what seldom changes is a product with an inverse that is kept.
"""

import ast
from typing import NamedTuple

from hapkit_studio.laws import cpp_kinds as kinds
from hapkit_studio.laws.cpp_kept import is_name
from hapkit_studio.laws.cpp_program import Routine
from hapkit_studio.laws.cpp_small import Small
from hapkit_studio.laws.cpp_steady import is_steady
from hapkit_studio.laws.cpp_words import number


class Text(NamedTuple):
    """An expression and how tightly it binds."""

    words: str
    level: int


ATOM, UNARY, PRODUCT, SUM, ORDER, EQUAL, AND, OR, CHOICE = range(9, 0, -1)

_COMPARE = {ast.Eq: ("==", EQUAL), ast.NotEq: ("!=", EQUAL), ast.Lt: ("<", ORDER), ast.LtE: ("<=", ORDER)}
_COMPARE |= {ast.Gt: (">", ORDER), ast.GtE: (">=", ORDER)}
_MIRRORED = {ast.Eq: ast.Eq, ast.NotEq: ast.NotEq, ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt}
_MIRRORED |= {ast.GtE: ast.LtE}
_WITH_ZERO = {ast.Eq: "fast::is_zero({})", ast.NotEq: "!fast::is_zero({})", ast.Lt: "fast::below_zero({})"}
_WITH_ZERO |= {ast.Gt: "fast::above_zero({})", ast.LtE: "fast::to_zero({})", ast.GtE: "fast::from_zero({})"}


class Cheap:
    """The arithmetic and the comparisons of one function."""

    routine: Routine
    small: Small
    signs: set[str]
    inverses: list[str]

    def value(self, node: ast.expr, level: int = 0) -> str:
        """Return an expression as a number, in parentheses where it binds less than wanted."""
        raise NotImplementedError

    def whole(self, node: ast.expr, level: int = 0) -> str:
        """Return a small whole number as one."""
        raise NotImplementedError

    def _arithmetic(self, node: ast.BinOp) -> Text:
        raise NotImplementedError

    def _compared(self, left: ast.expr, op: ast.cmpop, right: ast.expr) -> Text:
        """Return one comparison: of whole numbers, or by bits with what has few of them."""
        word, level = _COMPARE[type(op)]
        names = [n for n in (left, right) if isinstance(n, (ast.Name, ast.Call))]
        if names and self.small.holds(left, self.routine) and self.small.holds(right, self.routine):
            return Text(f"{self.whole(left, SUM)} {word} {self.whole(right, SUM)}", level)
        if isinstance(left, ast.Constant) and not isinstance(right, ast.Constant):
            left, op, right = right, _MIRRORED[type(op)](), left
        if isinstance(right, ast.Constant) and isinstance(right.value, float):
            words = self.value(left)
            if type(op) in (ast.Eq, ast.NotEq) and right.value != 0.0:
                test = f"fast::is({words}, {number(right.value)})"
                return Text(test if isinstance(op, ast.Eq) else f"!{test}", UNARY)
            if right.value == 0.0:
                return Text(_WITH_ZERO[type(op)].format(words), UNARY)
            if calls(left, "abs") and right.value > 0.0 and type(op) in (ast.Gt, ast.LtE):
                test = f"fast::larger({self.value(left.args[0])}, {number(right.value)})"  # type: ignore[attr-defined]
                return Text(test if isinstance(op, ast.Gt) else f"!{test}", UNARY)
        word, level = _COMPARE[type(op)]
        return Text(f"{self.value(left, SUM)} {word} {self.value(right, SUM)}", level)

    def _product(self, factor: ast.expr, other: ast.expr) -> Text | None:
        """Return a product with a power of two, or with a sign, None for another factor."""
        if isinstance(factor, ast.Constant) and isinstance(factor.value, float):
            power = kinds.power_of_two(factor.value)
            if power is None or abs(power) > 30:
                return None
            words = self.value(other) if power else self.value(other, ATOM)
            words = f"fast::scaled<{power}>({words})" if power else words
            return Text(f"-{words}", UNARY) if factor.value < 0.0 else Text(words, ATOM)
        if kinds.is_sign(factor, self.signs):
            if self.small.holds(factor, self.routine):
                return Text(f"fast::flipped_by({self.value(other)}, {self.whole(factor)})", ATOM)
            return Text(f"fast::flipped({self.value(other)}, {self.value(factor)})", ATOM)
        return None

    def _quotient(self, node: ast.BinOp) -> Text:
        left, right = node.left, node.right
        if isinstance(right, ast.Constant) and right.value:
            assert isinstance(right.value, float)
            return self._arithmetic(ast.BinOp(left, ast.Mult(), ast.Constant(1.0 / right.value)))
        bare = right.args[0] if calls(right, "_divisor") else right  # type: ignore[attr-defined]
        if is_steady(bare, self.small.steady.get(self.routine.name, set())):
            watch = "of" if bare is right else "watched"
            return Text(f"{self.value(left, PRODUCT)} * {self._inverse(bare, watch)}", PRODUCT)
        return Text(f"{self.value(left, PRODUCT)} / {self.value(right, UNARY)}", PRODUCT)

    def _inverse(self, node: ast.expr, watch: str) -> str:
        """Return the inverse of what seldom changes, kept from tick to tick."""
        words = self.value(node)
        if words not in self.inverses:
            self.inverses.append(words)
        return f"inverse{self.inverses.index(words) + 1}_.{watch}({words})"


def calls(node: ast.expr, name: str) -> bool:
    """Return whether an expression is a call of this name."""
    return isinstance(node, ast.Call) and is_name(node.func, name)

"""Arithmetic on the tree of a law: what is known is computed, the rest made cheap for the board."""

import math
import operator
from collections.abc import Callable, Sequence

from hapkit_studio.laws.tree import (
    MOST_FLOAT,
    Compare,
    Expr,
    Logic,
    Not,
    Num,
    Op,
    Test,
    Var,
    is_single,
    literal,
)

MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
COMPUTED: dict[str, Callable] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "//": operator.floordiv, "%": operator.mod, "**": operator.pow, "neg": operator.neg,
    "abs": abs, "min": min, "max": max, "<": operator.lt, "<=": operator.le, ">": operator.gt,
    ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


def beyond_single(op: str, left: Expr, value: float) -> Test | bool:
    """Return a comparison with what single precision does not have: beyond all numbers, or next to 0."""
    if abs(value) > MOST_FLOAT:
        return op == "!=" or (op in ("<", "<=")) == (value > 0.0)
    if op in ("==", "!="):
        return op == "!="
    if isinstance(left, Op) and left.name == "abs" and value > 0.0:
        return Compare("==" if op in ("<", "<=") else "!=", left.args[0], literal(0.0))
    # a little above 0: less than it is 0 or less; a little below 0 the other way round
    if value > 0.0:
        return Compare("<=" if op in ("<", "<=") else ">", left, literal(0.0))
    return Compare(">=" if op in (">", ">=") else "<", left, literal(0.0))


def computed(name: str, numbers: Sequence[Num]) -> Num | None:
    """Return the number that an operation gives in double precision, None where it is none."""
    if any(not math.isfinite(n.value) for n in numbers):
        return None
    function = COMPUTED.get(name) or {"int": math.trunc}.get(name) or getattr(math, name)
    try:
        value = function(*(n.value for n in numbers))
    except (ArithmeticError, ValueError):
        return None
    if isinstance(value, complex) or not math.isfinite(value):
        return None
    if all(n.key == repr(n.value) for n in numbers) or (name in "*/" and numbers[0].key == "0.0"):
        return literal(float(value))
    return Num(float(value), f"{name}({','.join(n.key for n in numbers)})")


def simpler(name: str, args: tuple[Expr, ...]) -> Expr:
    """Return an operation in the form that costs the board least."""
    match name, args:
        case "neg", (Op("neg", (inner,)),):
            return inner
        case "neg", (Op("-", (a, b)),):
            return Op("-", (b, a))
        case "neg", (Op("*", (Num() as factor, inner)),):
            return _product(computed("neg", [factor]) or factor, inner)
        case "neg", (Op("+", (Op("*", (Num() as factor, inner)), other)),):
            return Op("-", (_product(computed("neg", [factor]) or factor, inner), other))
        case "+", (Num(value=0.0), other) | (other, Num(value=0.0)) if _zero(args):
            return other
        case "-", (other, Num(value=0.0)) if _zero(args):
            return other
        case "+", (Num() as number, other) if not isinstance(other, Num):
            return simpler("+", (other, number))
        case "+" | "-", (Op("+" | "-" as first, (inner, Num() as a)), Num() as b):
            total = computed("+" if first == name else "-", [a, b])
            if total is not None:
                return Op(first, (inner, total))
        case "+", (a, Op("neg", (b,))):
            return Op("-", (a, b))
        case "+", (Op("neg", (a,)), b):
            return Op("-", (b, a))
        case "-", (a, Op("neg", (b,))):
            return Op("+", (a, b))
        case "*", (a, b):
            return _times(a, b)
        case "/", (a, Num(value=value, key=key)) if value != 0.0 and is_single(1.0 / value):
            return _times(a, literal(1.0 / value) if key == repr(value) else Num(1.0 / value, f"1/{key}"))
    return Op(name, args)


def _zero(args: tuple[Expr, ...]) -> bool:
    """Return whether a term is 0 in the source, not by a parameter that may move."""
    return any(isinstance(a, Num) and a.key in ("0.0", "-0.0") for a in args)


def _times(a: Expr, b: Expr) -> Expr:
    """Return a product, its known factors in one number, its signs outside."""
    factor: Num | None = None
    parts: list[Expr] = []
    negative = False
    for part in (a, b):
        while isinstance(part, Op) and part.name == "neg":
            part, negative = part.args[0], not negative
        number: Expr | None = part
        if isinstance(part, Op) and part.name == "*":
            number, part = part.args if isinstance(part.args[0], Num) else (None, part)
        if not isinstance(number, Num):
            parts.append(part)
            continue
        if number is not part:
            parts.append(part)
        product = number if factor is None else computed("*", [factor, number])
        if product is None or not is_single(product.value):
            return Op("*", (a, b))
        factor = product
    if factor is not None and factor.key in ("0.0", "-0.0") and all(map(_is_finite, parts)):
        return literal(0.0)
    rest = parts[0] if len(parts) == 1 else Op("*", tuple(parts))
    if factor is None:
        return Op("neg", (rest,)) if negative else rest
    if negative:
        factor = computed("neg", [factor]) or factor
    return _product(factor, rest)


def _is_finite(value: Expr) -> bool:
    """Return whether a value of finite ones is finite itself, as far as single precision reaches."""
    if isinstance(value, Op):
        return value.name in ("+", "-", "*", "neg", "abs", "min", "max") and all(map(_is_finite, value.args))
    return isinstance(value, Num | Var)


def _product(factor: Num, product: Expr) -> Expr:
    if factor.key == "1.0":
        return product
    if factor.key == "-1.0":
        return simpler("neg", (product,))
    return Op("*", (factor, product))


def negated(test: Test | bool) -> Test | bool:
    if isinstance(test, bool):
        return not test
    return test.test if isinstance(test, Not) else Not(test)


def joined(op: str, tests: Sequence[Test | bool]) -> Test | bool:
    decides = op == "or"
    if any(isinstance(t, bool) and t == decides for t in tests):
        return decides
    open_ = tuple(t for t in tests if not isinstance(t, bool))
    if not open_:
        return not decides
    return open_[0] if len(open_) == 1 else Logic(op, open_)

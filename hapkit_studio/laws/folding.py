"""Constant folding and forward substitution on the tree of a law.

What is known is computed, the rest is made cheap for the board, and what is computed for one place only is
computed in that place.
"""

import math
import operator
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields

from hapkit_studio.laws.tree import (
    MOST_FLOAT,
    Assign,
    At,
    Block,
    Call,
    Compare,
    Expr,
    Function,
    If,
    Leave,
    Logic,
    Loop,
    Not,
    Num,
    Op,
    Return,
    Select,
    SetAt,
    Specialised,
    Statement,
    Test,
    Var,
    called,
    is_single,
    literal,
    may_fail,
    mentions,
)  # fmt: skip

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


def folded(name: str, numbers: Sequence[Num]) -> Num | None:
    """Fold a constant: return the number that an operation gives in double precision, None if it is none."""
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


def simplified(name: str, args: tuple[Expr, ...]) -> Expr:
    """Return an operation in the form that costs the board least."""
    match name, args:
        case "neg", (Op("neg", (inner,)),):
            return inner
        case "neg", (Op("-", (a, b)),):
            return Op("-", (b, a))
        case "neg", (Op("*", (Num() as factor, inner)),):
            return _product(folded("neg", [factor]) or factor, inner)
        case "neg", (Op("+", (Op("*", (Num() as factor, inner)), other)),):
            return Op("-", (_product(folded("neg", [factor]) or factor, inner), other))
        case "+", (Num(value=0.0), other) | (other, Num(value=0.0)) if _zero(args):
            return other
        case "-", (other, Num(value=0.0)) if _zero(args):
            return other
        case "+", (Num() as number, other) if not isinstance(other, Num):
            return simplified("+", (other, number))
        case "+" | "-", (Op("+" | "-" as first, (inner, Num() as a)), Num() as b):
            total = folded("+" if first == name else "-", [a, b])
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
        product = number if factor is None else folded("*", [factor, number])
        if product is None or not is_single(product.value):
            return Op("*", (a, b))
        factor = product
    if factor is not None and factor.key in ("0.0", "-0.0") and all(map(_is_finite, parts)):
        return literal(0.0)
    rest = parts[0] if len(parts) == 1 else Op("*", tuple(parts))
    if factor is None:
        return Op("neg", (rest,)) if negative else rest
    if negative:
        factor = folded("neg", [factor]) or factor
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
        return simplified("neg", (product,))
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


def substitute(law: Specialised) -> None:
    """Put the value of every variable that is written once and read once into the place that reads it.

    Nothing that it is made of may change on the way there, and it may not end the law.
    """
    bodies = [law.body, *(f.body.body for f in law.functions)]
    read, written = Counter[str](), Counter[str]()
    for body in bodies:
        read.update(_reads(body))
        written.update(_writes(body))
    lasting = {name for f in law.functions for name in (*f.parameters, *f.results)}
    single = {n for n, times in read.items() if times == 1 and written[n] == 1} - lasting
    for body in bodies:
        _in_list(body, {n for n in single if not n.startswith("s[")}, lasting)


def _in_list(statements: list[Statement], single: set[str], lasting: set[str]) -> None:
    at = 0
    while at < len(statements):
        s = statements[at]
        for inner in _lists(s):
            _in_list(inner, single, lasting)
        movable = isinstance(s, Assign) and s.to in single and not may_fail(s.value)
        if movable and _put(s, statements, at + 1, lasting):  # type: ignore[arg-type]
            del statements[at]
        else:
            at += 1


def _put(made: Assign, statements: list[Statement], start: int, lasting: set[str]) -> bool:
    """Replace the one reading of what was made behind a place; return whether it was reached unchanged.

    What functions take and give, the lasting variables, may lie in one place: who writes one may write all.
    """
    parts = frozenset(_reads(made.value))
    for s in statements[start:]:
        if made.to in _reads(s):
            direct = [f.name for f in fields(s) if mentions(getattr(s, f.name), frozenset((made.to,)))]
            if direct:
                setattr(s, direct[0], replaced(getattr(s, direct[0]), made.to, made.value))
                return True
            if isinstance(s, Loop | SetAt):
                return False
            return any(_put(made, inner, 0, lasting) for inner in _lists(s))
        written = set(_writes(s))
        if parts & written or (parts & lasting and (written & lasting or called([s]))):
            return False
    return False


def replaced(value: Expr | Test, name: str, by: Expr):
    """Return an expression or a test with another expression in a variable's place, simplified around it."""
    match value:
        case Var(found) if found == name:
            return by
        case Op(op, args):
            args = tuple(replaced(a, name, by) for a in args)
            numbers = [a for a in args if isinstance(a, Num)]
            return (folded(op, numbers) if len(numbers) == len(args) else None) or simplified(op, args)
        case Select(test, yes, no):
            return Select(*(replaced(part, name, by) for part in (test, yes, no)))
        case Compare(op, left, right):
            return Compare(op, replaced(left, name, by), replaced(right, name, by))
        case Logic(op, tests):
            return Logic(op, tuple(replaced(t, name, by) for t in tests))
        case Not(test):
            return Not(replaced(test, name, by))
    return value


def _lists(s: Statement) -> Iterator[list[Statement]]:
    """Yield the statements inside a statement."""
    match s:
        case If(_, first, second) | Loop(_, first, second):
            yield first
            yield second
        case Block(body) | Leave(_, body):
            yield body  # type: ignore[misc]


def _reads(value: object) -> Iterator[str]:
    """Yield every variable that statements, expressions or tests read, as often as they do."""
    match value:
        case list() | tuple():
            for one in value:
                yield from _reads(one)
        case Var(name):
            yield name
        case At(index):
            # it stays a variable: as if it were read twice
            yield from (*_reads(index), *_reads(index))
        case Leave(_, moves):
            yield from _reads(moves)
        case Call() | Function() | str() | int() | float():
            pass
        case _:
            for one in vars(value).values():
                yield from _reads(one)


def _writes(value: Statement | Sequence[Statement]) -> Iterator[str]:
    """Yield every variable that statements write; of the state all, where an index says which."""
    match value:
        case list():
            for one in value:
                yield from _writes(one)
        case Assign(to):
            yield to
        case SetAt(place):
            yield from (f"s[{place.start + i}]" for i in range(place.size))
        case Call(function):
            yield from function.results
            yield from _writes(function.body)
        case Return():
            pass
        case _:
            for inner in _lists(value):  # type: ignore[arg-type]
                yield from _writes(inner)

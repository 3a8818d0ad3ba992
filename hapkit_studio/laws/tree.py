"""The small tree that a specialised law is: expressions, tests and statements, and the passes over it.

What is known is computed (constant folding), the rest is made cheap for the board, and what is computed for
one place only is computed in that place (forward substitution).
"""

import math
import operator
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

MOST_FLOAT = 3.4028234e38
LEAST_FLOAT = 1.1754944e-38


# --- expressions
@dataclass(frozen=True)
class Num:
    """A known number; key says what it is made of: two of the same value may part when a parameter moves."""

    value: float
    key: str


@dataclass(frozen=True)
class Var:
    """A name: x, v, dt, p[0] … (parameters that are not known), s[0] … (state), or a local one."""

    name: str


@dataclass(frozen=True)
class Op:
    """An operation of the law language: + - * / // % ** neg abs min max, or a function of math."""

    name: str
    args: tuple["Expr", ...]


@dataclass(frozen=True)
class At:
    """The value of state number start + int(index), 0 <= index < size; else the law has no force."""

    index: "Expr"
    start: int
    size: int

    def state(self) -> list[str]:
        """Return the names of all that it may be."""
        return [f"s[{self.start + i}]" for i in range(self.size)]


@dataclass(frozen=True)
class Entry:
    """The number int(index) of a table, 0 <= index < size; else the law has no force."""

    index: "Expr"
    table: str
    size: int


@dataclass(frozen=True)
class Select:
    """One of two values, by a test whose operands stay; for the board both are known."""

    test: "Test"
    yes: "Expr"
    no: "Expr"


Expr = Num | Var | Op | At | Entry | Select


# --- tests
@dataclass(frozen=True)
class Compare:
    """left op right, op one of < <= > >= == !=."""

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Logic:
    """Whether all (op "and") or any (op "or") of the tests hold, the next one asked only where it decides."""

    op: str
    tests: tuple["Test", ...]


@dataclass(frozen=True)
class Not:
    test: "Test"


Test = Compare | Logic | Not


# --- statements
@dataclass
class Stated:
    """A statement, with the line of the law's file that it comes from, 0 for none."""

    line: int = field(default=0, compare=False, kw_only=True)


@dataclass
class Assign(Stated):
    to: str
    value: Expr


@dataclass
class SetAt(Stated):
    place: At
    value: Expr


@dataclass
class If(Stated):
    test: Test
    then: list["Statement"]
    other: list["Statement"]


@dataclass
class Loop(Stated):
    """Run the body so many times; Continue ends one turn, Break all."""

    times: int
    body: list["Statement"]
    after: list["Statement"]  # of every turn, also one that Continue ends


@dataclass
class Break(Stated):
    pass


@dataclass
class Continue(Stated):
    pass


@dataclass
class Block(Stated):
    """What an inlined function became: Leave ends it."""

    body: list["Statement"] = field(default_factory=list)


@dataclass
class Leave(Stated):
    block: Block
    moves: list[Assign]


@dataclass
class Call(Stated):
    """Run a function: its parameters have their values; its results are variables then."""

    function: "Function"


@dataclass
class Return(Stated):
    value: Expr


Statement = Assign | SetAt | If | Loop | Break | Continue | Block | Leave | Call | Return


@dataclass
class Function:
    """A function that is called from several places: it takes and gives variables of these names."""

    key: str
    name: str
    parameters: tuple[str, ...]
    results: tuple[str, ...]
    body: Block

    @property
    def lasting(self) -> tuple[str, ...]:
        """Return the variables that it takes and gives."""
        return (*self.parameters, *self.results)


@dataclass
class Specialised:
    """A law's body, the functions that it calls, each after those that it calls itself, and its tables."""

    body: list[Statement]
    functions: list[Function]
    tables: Mapping[str, tuple[float, ...]]


def literal(value: float) -> Num:
    """Return the number that stands in the source."""
    return Num(value, repr(value))


def is_truth(value: Expr) -> bool:
    """Return whether a value is 1 or 0 by a test."""
    return isinstance(value, Select) and (value.yes, value.no) == (literal(1.0), literal(0.0))


def is_single(value: float) -> bool:
    """Return whether single precision has a number near a value: neither too large nor too small."""
    return value == 0.0 or LEAST_FLOAT <= abs(value) <= MOST_FLOAT


# --- what a tree is made of
def walk(value: object) -> Iterator[Any]:
    """Yield a statement, test or expression, or several, and all that they are made of; enter no call."""
    if isinstance(value, list | tuple):
        for one in value:
            yield from walk(one)
    elif not isinstance(value, str | int | float):
        yield value
        if not isinstance(value, Call):
            # a block that is left is around the place, not in it
            yield from walk([value.moves] if isinstance(value, Leave) else list(vars(value).values()))


def rebuilt(value: Any, change: Callable[[Any], Any]) -> Any:
    """Return an expression or a test with each of its parts, the innermost first, as ``change`` gives it."""
    if isinstance(value, tuple):
        return tuple(rebuilt(one, change) for one in value)
    if not isinstance(value, Expr | Test):
        return value
    return change(replace(value, **{key: rebuilt(one, change) for key, one in vars(value).items()}))


def mentions(value: object, names: frozenset[str]) -> bool:
    """Return whether an expression or a test reads one of these variables."""
    return any(
        n.name in names if isinstance(n, Var) else isinstance(n, At) and not names.isdisjoint(n.state())
        for n in walk(value)
    )


def reads(value: object) -> Iterator[str]:
    """Yield every variable that statements, expressions or tests read, as often as they do."""
    for n in walk(value):
        if isinstance(n, Var):
            yield n.name
        elif isinstance(n, At | Entry):
            # its index stays a variable: as if it were read twice
            yield from reads(n.index)


def writes(value: object) -> Iterator[str]:
    """Yield every variable that statements write; of the state all, where an index says which."""
    for n in walk(value):
        match n:
            case Assign(to):
                yield to
            case SetAt(place):
                yield from place.state()
            case Call(function):
                yield from function.results
                yield from writes(function.body)


def inner_lists(s: Statement) -> list[list[Statement]]:
    """Return the statements inside a statement."""
    match s:
        case If(_, first, second) | Loop(_, first, second):
            return [first, second]
        case Block(body) | Leave(_, body):
            return [body]  # type: ignore[list-item]
    return []


_WEIGHTS = {**dict.fromkeys((Assign, SetAt, Return, If, Op, Select, Not, Compare), 1), Loop: 2}


def weight(statements: object) -> int:
    """Return about how many operations some statements are."""
    found = list(walk(statements))
    calls = sum(1 + len(n.function.parameters) for n in found if isinstance(n, Call))
    return calls + sum(_WEIGHTS.get(type(n), 0) for n in found)


def called(statements: object) -> list[str]:
    """Return the keys of the functions that statements call, one for each place."""
    return [n.function.key for n in walk(statements) if isinstance(n, Call)]


def may_fail(value: object) -> bool:
    """Return whether an expression or a test may end the law: by a divisor of zero, an index outside."""
    for n in walk(value):
        match n:
            case At() | Entry():
                return True
            case Op("/" | "//" | "%" | "fmod", (_, right)):
                if not (isinstance(right, Num) and right.value):
                    return True
    return False


def drop_unused(law: Specialised) -> None:
    """Leave out what is given to names that nothing reads."""
    bodies = [law.body, *(f.body.body for f in law.functions)]
    lasting = {name for f in law.functions for name in f.lasting}
    dropped = True
    while dropped:
        read = lasting | set(reads(bodies))
        dropped = any([_without(body, read) for body in bodies])


def _without(statements: list[Statement], read: set[str]) -> bool:
    """Take assignments to what is not read out of statements; return whether there were any."""
    dropped = False
    kept: list[Statement] = []
    for s in statements:
        dropped |= any([_without(inner, read) for inner in inner_lists(s)])
        match s:
            case Assign(to, value) if to not in read and not to.startswith("s[") and not may_fail(value):
                dropped = True
            case If(test, [], []) if not may_fail(test):
                dropped = True
            case _:
                kept.append(s)
    statements[:] = kept
    return dropped


# --- constants
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
    read, written = Counter(reads(bodies)), Counter(writes(bodies))
    lasting = {name for f in law.functions for name in f.lasting}
    single = {n for n, times in read.items() if times == 1 and written[n] == 1} - lasting
    for body in bodies:
        _in_list(body, {n for n in single if not n.startswith("s[")}, lasting)


def _in_list(statements: list[Statement], single: set[str], lasting: set[str]) -> None:
    at = 0
    while at < len(statements):
        s = statements[at]
        for inner in inner_lists(s):
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
    parts = frozenset(reads(made.value))
    for s in statements[start:]:
        if made.to in reads(s):
            for key, value in vars(s).items():
                if isinstance(value, Expr | Test) and mentions(value, frozenset((made.to,))):
                    setattr(s, key, replaced(value, made.to, made.value))
                    return True
            if isinstance(s, Loop | SetAt):
                return False
            return any(_put(made, inner, 0, lasting) for inner in inner_lists(s))
        written = set(writes(s))
        if parts & written or (parts & lasting and (written & lasting or called([s]))):
            return False
    return False


def replaced(value: Expr | Test, name: str, by: Expr):
    """Return an expression or a test with another expression in a variable's place, simplified around it."""

    def change(part: Expr | Test):
        match part:
            case Var(found) if found == name:
                return by
            case Op(op, args):
                numbers = [a for a in args if isinstance(a, Num)]
                known = folded(op, numbers) if len(numbers) == len(args) else None
                # what is still a quotient has to meet whole numbers
                return known or (part if op == "/" else simplified(op, args))
        return part

    return rebuilt(value, change)

"""The syntax tree of a specialised law: expressions, tests and statements, and the passes over them.

The passes are constant folding, strength reduction for the board, and forward substitution.
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
    """A constant; ``key`` is its origin, because equal constants may differ after a parameter changes."""

    value: float
    key: str


@dataclass(frozen=True)
class Var:
    """A variable: x, v, dt, p[0] … (unknown parameters), s[0] … (state), or a local variable."""

    name: str


@dataclass(frozen=True)
class Op:
    """An operation of the law language: + - * / // % ** neg abs min max, or a function of math."""

    name: str
    args: tuple["Expr", ...]


@dataclass(frozen=True)
class At:
    """The state at index start + int(index), with 0 <= index < size; any other index is a fault."""

    index: "Expr"
    start: int
    size: int

    def state(self) -> list[str]:
        """Return the names of all states that this node may refer to."""
        return [f"s[{self.start + i}]" for i in range(self.size)]


@dataclass(frozen=True)
class Entry:
    """Entry int(index) of a table, with 0 <= index < size; any other index is a fault."""

    index: "Expr"
    table: str
    size: int


@dataclass(frozen=True)
class Select:
    """A conditional expression; on the board both values are constants."""

    test: "Test"
    yes: "Expr"
    no: "Expr"


Expr = Num | Var | Op | At | Entry | Select


# --- tests
@dataclass(frozen=True)
class Compare:
    """The comparison left op right; op is one of < <= > >= == !=."""

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Logic:
    """Conjunction (op "and") or disjunction (op "or") of tests, with short-circuit evaluation."""

    op: str
    tests: tuple["Test", ...]


@dataclass(frozen=True)
class Not:
    test: "Test"


Test = Compare | Logic | Not


# --- statements
@dataclass
class Stated:
    """The base of statements; ``line`` is the line in the law's file, or 0 for a generated statement."""

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
    """Run the body ``times`` times; Continue ends an iteration, Break ends the loop."""

    times: int
    body: list["Statement"]
    after: list["Statement"]  # runs at the end of every iteration, also after Continue


@dataclass
class Break(Stated):
    pass


@dataclass
class Continue(Stated):
    pass


@dataclass
class Block(Stated):
    """The body of an inlined function; a Leave exits the block."""

    body: list["Statement"] = field(default_factory=list)


@dataclass
class Leave(Stated):
    block: Block
    moves: list[Assign]


@dataclass
class Call(Stated):
    """A function call; arguments and results are passed in the function's variables."""

    function: "Function"


@dataclass
class Return(Stated):
    value: Expr


Statement = Assign | SetAt | If | Loop | Break | Continue | Block | Leave | Call | Return


@dataclass
class Function:
    """A function that is called several times; ``parameters`` and ``results`` are names of variables."""

    key: str
    name: str
    parameters: tuple[str, ...]
    results: tuple[str, ...]
    body: Block

    @property
    def lasting(self) -> tuple[str, ...]:
        """Return the variables for parameters and results."""
        return (*self.parameters, *self.results)


@dataclass
class Specialised:
    """A law's body, its functions in topological order, and its tables."""

    body: list[Statement]
    functions: list[Function]
    tables: Mapping[str, tuple[float, ...]]


def literal(value: float) -> Num:
    """Return a constant that comes from a literal of the source."""
    return Num(value, repr(value))


def is_truth(value: Expr) -> bool:
    """Return True if a value is Boolean, 1 or 0."""
    return isinstance(value, Select) and (value.yes, value.no) == (literal(1.0), literal(0.0))


def is_single(value: float) -> bool:
    """Return True if a value is within the range of single precision."""
    return value == 0.0 or LEAST_FLOAT <= abs(value) <= MOST_FLOAT


# --- traversal
def walk(value: object) -> Iterator[Any]:
    """Yield a node or several nodes and all nodes inside; called functions are not entered."""
    if isinstance(value, list | tuple):
        for one in value:
            yield from walk(one)
    elif not isinstance(value, str | int | float):
        yield value
        if not isinstance(value, Call):
            # Leave refers to the block that contains it, so its block is not entered
            yield from walk([value.moves] if isinstance(value, Leave) else list(vars(value).values()))


def rebuilt(value: Any, change: Callable[[Any], Any]) -> Any:
    """Return an expression or test with ``change`` applied to each node, innermost first."""
    if isinstance(value, tuple):
        return tuple(rebuilt(one, change) for one in value)
    if not isinstance(value, Expr | Test):
        return value
    return change(replace(value, **{key: rebuilt(one, change) for key, one in vars(value).items()}))


def mentions(value: object, names: frozenset[str]) -> bool:
    """Return True if an expression or test reads one of these variables."""
    return any(
        n.name in names if isinstance(n, Var) else isinstance(n, At) and not names.isdisjoint(n.state())
        for n in walk(value)
    )


def reads(value: object) -> Iterator[str]:
    """Yield every variable that nodes read; a variable appears once for each read."""
    for n in walk(value):
        if isinstance(n, Var):
            yield n.name
        elif isinstance(n, At | Entry):
            # an index must stay a variable; each name is yielded twice, which prevents a substitution
            yield from reads(n.index)


def writes(value: object) -> Iterator[str]:
    """Yield every variable that statements write; an indexed write may write all states of the array."""
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
    """Return the statement lists inside a statement."""
    match s:
        case If(_, first, second) | Loop(_, first, second):
            return [first, second]
        case Block(body) | Leave(_, body):
            return [body]  # type: ignore[list-item]
    return []


_WEIGHTS = {**dict.fromkeys((Assign, SetAt, Return, If, Op, Select, Not, Compare), 1), Loop: 2}


def weight(statements: object) -> int:
    """Return the approximate number of operations in statements."""
    found = list(walk(statements))
    calls = sum(1 + len(n.function.parameters) for n in found if isinstance(n, Call))
    return calls + sum(_WEIGHTS.get(type(n), 0) for n in found)


def called(statements: object) -> list[str]:
    """Return the keys of the called functions; a key appears once for each call."""
    return [n.function.key for n in walk(statements) if isinstance(n, Call)]


def may_fail(value: object) -> bool:
    """Return True if an evaluation may stop the law: division by zero or an index out of range."""
    for n in walk(value):
        match n:
            case At() | Entry():
                return True
            case Op("/" | "//" | "%" | "fmod", (_, right)):
                if not (isinstance(right, Num) and right.value):
                    return True
    return False


def drop_unused(law: Specialised) -> None:
    """Remove assignments whose variables are not read."""
    bodies = [law.body, *(f.body.body for f in law.functions)]
    lasting = {name for f in law.functions for name in f.lasting}
    dropped = True
    while dropped:
        read = lasting | set(reads(bodies))
        dropped = any([_removed_unused(body, read) for body in bodies])


def _removed_unused(statements: list[Statement], read: set[str]) -> bool:
    """Remove assignments to variables outside ``read``; return True if any were removed."""
    dropped = False
    kept: list[Statement] = []
    for s in statements:
        dropped |= any([_removed_unused(inner, read) for inner in inner_lists(s)])
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
    """Simplify a comparison with a number that in single precision overflows, or underflows to 0."""
    if abs(value) > MOST_FLOAT:
        return op == "!=" or (op in ("<", "<=")) == (value > 0.0)
    if op in ("==", "!="):
        return op == "!="
    if isinstance(left, Op) and left.name == "abs" and value > 0.0:
        return Compare("==" if op in ("<", "<=") else "!=", left.args[0], literal(0.0))
    # "less than a tiny positive value" means <= 0, and "greater than a tiny negative value" means >= 0
    if value > 0.0:
        return Compare("<=" if op in ("<", "<=") else ">", left, literal(0.0))
    return Compare(">=" if op in (">", ">=") else "<", left, literal(0.0))


def folded(name: str, numbers: Sequence[Num]) -> Num | None:
    """Fold constants in double precision; return None if the result is not finite."""
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
    """Return an operation in the form that is cheapest on the board (strength reduction)."""
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
    """Return True if an argument is the literal 0. A parameter is not: its value may change later."""
    return any(isinstance(a, Num) and a.key in ("0.0", "-0.0") for a in args)


def _times(a: Expr, b: Expr) -> Expr:
    """Return a product in which constant factors are merged, with the sign in front of the product."""
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
    if factor.key == "1.0":
        return rest
    return simplified("neg", (rest,)) if factor.key == "-1.0" else Op("*", (factor, rest))


def _is_finite(value: Expr) -> bool:
    """Return True if a value is finite for finite operands in single precision."""
    if isinstance(value, Op):
        return value.name in ("+", "-", "*", "neg", "abs", "min", "max") and all(map(_is_finite, value.args))
    return isinstance(value, Num | Var)


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
    """Forward substitution: if a variable is written once and read once, its value replaces the read.

    The variables in the value must not change in between, and evaluating the value must not stop the law.
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
        if movable and _substituted(s, statements, at + 1, lasting):  # type: ignore[arg-type]
            del statements[at]
        else:
            at += 1


def _substituted(made: Assign, statements: list[Statement], start: int, lasting: set[str]) -> bool:
    """Substitute into the only read after ``start``; return False if an operand changes before this read.

    Persistent variables may share slots, so a write to one counts as a write to all.
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
            return any(_substituted(made, inner, 0, lasting) for inner in inner_lists(s))
        written = set(writes(s))
        if parts & written or (parts & lasting and (written & lasting or called([s]))):
            return False
    return False


def replaced(value: Expr | Test, name: str, by: Expr):
    """Return an expression or test in which a variable is replaced, with the parts around it simplified."""

    def change(part: Expr | Test):
        match part:
            case Var(found) if found == name:
                return by
            case Op(op, args):
                numbers = [a for a in args if isinstance(a, Num)]
                known = folded(op, numbers) if len(numbers) == len(args) else None
                # a remaining quotient is not simplified, because it must be exact for integers
                return known or (part if op == "/" else simplified(op, args))
        return part

    return rebuilt(value, change)

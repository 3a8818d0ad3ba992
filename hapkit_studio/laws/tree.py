"""The small tree that a specialised law is: expressions, tests and statements, and what is asked of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

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


@dataclass(frozen=True)
class Select:
    """One of two values, by a test whose operands stay; for the board both are known."""

    test: "Test"
    yes: "Expr"
    no: "Expr"


Expr = Num | Var | Op | At | Select


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
    """What every statement has: the line of the law's file that it comes from, 0 for none."""

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


@dataclass
class Specialised:
    """A law's body and the functions that it calls, each after those that it calls itself."""

    body: list[Statement]
    functions: list[Function]


def literal(value: float) -> Num:
    """Return the number that stands in the source."""
    return Num(value, repr(value))


def is_single(value: float) -> bool:
    """Return whether single precision has a number near a value: neither too large nor too small."""
    return value == 0.0 or LEAST_FLOAT <= abs(value) <= MOST_FLOAT


def mentions(value: object, names: frozenset[str]) -> bool:
    """Return whether an expression or a test reads one of these variables."""
    match value:
        case Var(name):
            return name in names
        case Op(_, args):
            return any(mentions(a, names) for a in args)
        case Select(test, yes, no):
            return any(mentions(part, names) for part in (test, yes, no))
        case At(index, start, size):
            return mentions(index, names) or any(f"s[{start + i}]" in names for i in range(size))
        case Compare(_, left, right):
            return mentions(left, names) or mentions(right, names)
        case Logic(_, tests):
            return any(mentions(t, names) for t in tests)
        case Not(test):
            return mentions(test, names)
    return False


def weight(statements: Sequence[Statement]) -> int:
    """Return about how many operations some statements are."""
    total = 0
    for s in statements:
        match s:
            case Assign(_, value) | Return(value) | SetAt(_, value):
                total += 1 + _operations(value)
            case If(test, then, other):
                total += 1 + _operations(test) + weight(then) + weight(other)
            case Loop(_, body, after):
                total += 2 + weight(body) + weight(after)
            case Block(body):
                total += weight(body)
            case Leave(_, moves):
                total += len(moves)
            case Call(function):
                total += 1 + len(function.parameters)
    return total


def _operations(value: object) -> int:
    match value:
        case Op(_, args):
            return 1 + sum(map(_operations, args))
        case Select(test) | Not(test):
            return 1 + _operations(test)
        case Compare(_, left, right):
            return 1 + _operations(left) + _operations(right)
        case Logic(_, tests):
            return sum(map(_operations, tests))
    return 0


def called(statements: Sequence[Statement]) -> list[str]:
    """Return the keys of the functions that statements call, one for each place."""
    found: list[str] = []
    for s in statements:
        match s:
            case Call(function):
                found.append(function.key)
            case If(_, first, second) | Loop(_, first, second):
                found += called(first) + called(second)
            case Block(body):
                found += called(body)
    return found


def drop_unused(law: Specialised) -> None:
    """Leave out what is given to names that nothing reads."""
    bodies = [law.body, *(f.body.body for f in law.functions)]
    lasting = {r for f in law.functions for r in (*f.results, *f.parameters)}
    dropped = True
    while dropped:
        read: set[str] = set(lasting)
        for body in bodies:
            _read(body, read)
        dropped = any([_without(body, read) for body in bodies])


def _read(value: object, found: set[str]) -> None:
    """Collect the variables that are read somewhere in statements, expressions or tests."""
    match value:
        case list() | tuple():
            for one in value:
                _read(one, found)
        case Var(name):
            found.add(name)
        case Function() | Num() | str() | int():
            pass
        case Leave(_, moves):
            _read(moves, found)
        case _:
            for one in vars(value).values():
                _read(one, found)


def may_fail(value: object) -> bool:
    """Return whether an expression or a test may end the law: by a divisor of zero, an index outside."""
    match value:
        case At():
            return True
        case Op("/" | "//" | "%" | "fmod", (left, right)):
            return not (isinstance(right, Num) and right.value) or may_fail(left)
        case Op(_, parts) | Logic(_, parts):
            return any(map(may_fail, parts))
        case Compare(_, left, right):
            return may_fail(left) or may_fail(right)
        case Select(test) | Not(test):
            return may_fail(test)
    return False


def _without(statements: list[Statement], read: set[str]) -> bool:
    """Take assignments to what is not read out of statements; return whether there were any."""
    dropped = False
    kept: list[Statement] = []
    for s in statements:
        match s:
            case Assign(to, value) if to not in read and not to.startswith("s[") and not may_fail(value):
                dropped = True
                continue
            case If(_, first, second) | Loop(_, first, second):
                dropped |= _without(first, read) | _without(second, read)
                if isinstance(s, If) and not first and not second and not may_fail(s.test):
                    dropped = True
                    continue
            case Block(body) | Leave(_, body):
                dropped |= _without(body, read)  # type: ignore[arg-type]
        kept.append(s)
    statements[:] = kept
    return dropped

"""Forward substitution: what is worked out for one place only is worked out in that place."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import fields

from hapkit_studio.laws.algebra import computed, simpler
from hapkit_studio.laws.tree import (
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
    may_fail,
    mentions,
)  # fmt: skip


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
            return (computed(op, numbers) if len(numbers) == len(args) else None) or simpler(op, args)
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

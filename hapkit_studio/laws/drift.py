"""Find states that accumulate time; they drift in single precision, on the board and in the sketch.

A float32 clock that adds 1/4000 s per call is 10 s late after 10 minutes, because between two powers of two
every sum has the same rounding error. Integers are exact up to 2^24, which is 70 minutes at 4 kHz. States
that decay, are limited, or follow the handle or another state lose their rounding errors, so they are not
reported.

The method is abstract interpretation: the law is evaluated with forms instead of numbers. A form contains the
state on which a value is based and the step added to this state.
"""

import ast
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from hapkit_studio.laws.translate import CheckedLaw

DT, MOTION, FRACTION = "dt", "motion", "fraction"
_MOST_FORMS = 16
_PERIODIC = ("sin", "cos", "tan")
_UPPER, _LOWER = 1, -1


@dataclass(frozen=True)
class Remark:
    """Advice on a line of a correct law."""

    line: int
    text: str

    def __str__(self) -> str:
        return f"Line {self.line}: {self.text}."


@dataclass(frozen=True)
class Form:
    """An abstract value: the sum of the state with the index ``base`` and a step, or only a step.

    ``parts`` are the dependencies of the step: DT, MOTION, FRACTION (a parameter or a non-integer number),
    and states by index. ``signs`` are the possible signs of the step; 0 means unknown. ``number`` is the
    value if it is constant. ``limits`` are the directions, as signs, in which the sum is limited. ``wrapped``
    is true if a modulo operation reduced the value. ``line`` is the line of the first assignment to the
    state.
    """

    base: int | None = None
    parts: frozenset[str | int] = frozenset()
    signs: frozenset[int] = frozenset((0,))
    number: float | None = None
    limits: frozenset[int] = frozenset()
    wrapped: bool = False
    line: int = 0

    @property
    def depends(self) -> frozenset[str | int]:
        return self.parts if self.base is None else self.parts | {self.base}

    @property
    def bounded(self) -> bool:
        """Return True if tests limit the value in the direction in which its step changes it."""
        return bool(self.limits) if 0 in self.signs else bool(self.signs) and self.signs <= self.limits


Forms = frozenset[Form]
# states that a test compares, and the side on which the test limits each of them
Guards = frozenset[tuple[int, int]]
_UNKNOWN: Forms = frozenset((Form(),))
_PARAMETER: Forms = frozenset((Form(parts=frozenset((FRACTION,))),))


def _number(value: float) -> Form:
    whole = abs(value) < 2**24 and value == int(value)
    signs = frozenset(((value > 0.0) - (value < 0.0),)) if value else frozenset[int]()
    return Form(None, frozenset() if whole else frozenset((FRACTION,)), signs, value)


def _limited(forms: Iterable[Form]) -> Forms:
    """Widening: merge the forms that have the same base if there are many forms."""
    found = frozenset(forms)
    if len(found) <= _MOST_FORMS:
        return found
    merged: dict[int | None, Form] = {}
    for one in found:
        other = merged.setdefault(one.base, one)
        merged[one.base] = Form(
            one.base,
            one.parts | other.parts,
            one.signs | other.signs,
            None,
            one.limits & other.limits,
            one.wrapped and other.wrapped,
            max(one.line, other.line),
        )
    return frozenset(merged.values())


def _unknown_function(*values: Forms) -> Forms:
    """Return the abstract result of an unknown function; it depends on everything its arguments depend on."""
    return frozenset((Form(parts=frozenset(part for forms in values for f in forms for part in f.depends)),))


def _times(a: Form, b: Form) -> Form:
    for one, other in ((a, b), (b, a)):
        if one.number == 1.0:
            return other
    if a.number is not None and b.number is not None:
        return _number(a.number * b.number)
    return Form(None, a.depends | b.depends, frozenset(m * n for m, n in product(a.signs, b.signs)))


def _negative(a: Form) -> Form:
    return _times(a, _number(-1.0))


class _Evaluation:
    """The abstract interpretation of the law, including each call of its helpers."""

    def __init__(self, law: CheckedLaw):
        self.law = law
        self.names: dict[str, Forms] = {"dt": frozenset((Form(None, frozenset((DT,)), frozenset((1,))),))}
        self.names |= dict.fromkeys(("x", "v"), frozenset((Form(parts=frozenset((MOTION,))),)))
        self.states: dict[int, Forms] = {}
        self.guards: Guards = frozenset()
        self.ends: list[dict[int, Forms]] = []  # the states at every return of the law
        self.returned: list[list[Forms]] | None = None  # the return values of the helper that is evaluated
        self.angles: list[tuple[int, Form]] = []  # arguments of sin, cos and tan, with their lines
        self.line = 0  # current line in the law's source
        self.walk(law.tree.body)

    # --- statements
    def walk(self, statements: Sequence[ast.stmt]) -> bool:
        """Evaluate statements in order; return True if all paths return."""
        return any(self.statement(s) for s in statements)

    def statement(self, node: ast.stmt) -> bool:
        if self.returned is None:
            self.line = node.lineno
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                whole = isinstance(value, ast.Tuple)
                values = [self.value(v) for v in value.elts] if whole else self.call(value)  # type: ignore
                for target, forms in zip(targets, values, strict=True):
                    self.assign(target, forms)
            case ast.Assign(targets=[target], value=value):
                self.assign(target, self.value(value))
            case ast.If(test=ast.Call(func=ast.Name(id="_spent"))):
                pass
            case ast.If():
                return self.branch(node)
            case ast.For():
                for _ in range(2):
                    before = dict(self.names), dict(self.states)
                    self.walk(node.body)
                    self.join(*before)
            case ast.Return(value=ast.Tuple(elts=several)):
                self.leave([self.value(one) for one in several])
                return True
            case ast.Return(value=ast.expr() as value):
                self.leave([self.value(value)])
                return True
        return False

    def assign(self, target: ast.expr, forms: Forms) -> None:
        if isinstance(target, ast.Name):
            self.names[target.id] = forms
        elif isinstance(target, ast.Subscript):
            place, exact = _place(target)
            forms = frozenset(f if f.line and f.base == place else replace(f, line=self.line) for f in forms)
            self.states[place] = forms if exact else _limited(forms | self.state(place))

    def state(self, place: int) -> Forms:
        return self.states.get(place, _untouched(place))

    def leave(self, values: list[Forms]) -> None:
        if self.returned is None:
            self.ends.append(dict(self.states))
        else:
            self.returned.append(values)

    def branch(self, node: ast.If) -> bool:
        self.value(node.test)
        when, otherwise = self.limits(node.test)
        before, guards = (dict(self.names), dict(self.states)), self.guards
        self.guards = guards | when
        left = self.walk(node.body)
        after = self.names, self.states
        (self.names, self.states), self.guards = before, guards | otherwise
        gone = self.walk(node.orelse)
        if left:
            return gone  # only the other path, with its guards, reaches the code below
        if gone:
            (self.names, self.states), self.guards = after, guards | when
        else:
            self.join(*after)
            self.guards = guards
        return False

    def join(self, names: Mapping[str, Forms], states: Mapping[int, Forms]) -> None:
        """Join names and states with those of another path."""
        for name, forms in names.items():
            self.names[name] = _limited(forms | self.names.get(name, frozenset()))
        for place in {*states, *self.states}:
            other = states.get(place, _untouched(place))
            self.states[place] = _limited(other | self.state(place))

    def limits(self, test: ast.expr) -> tuple[Guards, Guards]:
        """Return the limits on states if a test is true, and the limits if it is false."""
        none: Guards = frozenset()
        match test:
            case ast.UnaryOp(op=ast.Not(), operand=inner):
                when, otherwise = self.limits(inner)
                return otherwise, when
            case ast.BoolOp(op=op, values=values):
                both = [self.limits(one) for one in values]
                if isinstance(op, ast.And):
                    return none.union(*(when for when, _ in both)), none
                return none, none.union(*(otherwise for _, otherwise in both))
            case ast.Compare(
                left=left, ops=[ast.Lt() | ast.LtE() | ast.Gt() | ast.GtE() as op], comparators=[right]
            ):
                less = isinstance(op, ast.Lt | ast.LtE)
                low, high = (left, right) if less else (right, left)
                pairs = ((low, _UPPER), (high, _LOWER))
                when = frozenset((k, side) for node, side in pairs for k in self.compared(node))
                return when, frozenset((k, -side) for k, side in when)
        return none, none

    def compared(self, node: ast.expr) -> set[int]:
        """Return the states from which an operand differs only by constants and multiples of dt."""
        return {f.base for f in self.value(node) if f.base is not None and f.parts <= {DT, FRACTION}}

    # --- values
    def value(self, node: ast.expr) -> Forms:
        match node:
            case ast.Constant(value=bool() | int() | float() as number):
                return frozenset((_number(float(number)),))
            case ast.Name(id=name):
                return self.names.get(name, _UNKNOWN)
            case ast.Subscript(value=ast.Name(id="p")):
                return _PARAMETER
            case ast.Subscript(value=ast.Name(id="s")):
                return self.state(_place(node)[0])
            case ast.Subscript(slice=index):
                return _unknown_function(self.value(index), _PARAMETER)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return frozenset(map(_negative, self.value(operand)))
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.value(operand)
            case ast.BinOp(left=left, op=op, right=right):
                return self.combined(op, self.value(left), self.value(right))
            case ast.IfExp(test=test, body=body, orelse=orelse):
                guards, (when, otherwise) = self.guards, self.limits(test)
                self.guards = guards | when
                yes = self.value(body)
                self.guards = guards | otherwise
                no = self.value(orelse)
                self.guards = guards
                return _limited(yes | no)
            case ast.BoolOp(values=values):
                return _limited(frozenset().union(*map(self.value, values)))
            case ast.Call():
                return self.called(node)
            case ast.Compare(left=left, comparators=others):
                for one in (left, *others):
                    self.value(one)
        return _UNKNOWN  # a comparison: its value is 1.0 or 0.0

    def combined(self, op: ast.operator, left: Forms, right: Forms) -> Forms:
        pairs = list(product(left, right))
        match op:
            case ast.Add():
                return _limited(self.sum(a, b) for a, b in pairs)
            case ast.Sub():
                return _limited(self.difference(a, b) for a, b in pairs)
            case ast.Mult():
                return _limited(_times(a, b) for a, b in pairs)
            case ast.Div() if all(b.number for b in right):
                return _limited(_times(a, _number(1.0 / (b.number or 1.0))) for a, b in pairs)
            case ast.Mod():
                return _wrapped(left)
        return _unknown_function(left, right)

    def sum(self, a: Form, b: Form) -> Form:
        if a.base is None and b.base is None and a.number is not None and b.number is not None:
            return _number(a.number + b.number)
        if a.base is None:
            a, b = b, a
        limits = a.limits | b.limits | {side for place, side in self.guards if place == a.base}
        signs = a.signs | b.signs
        return Form(a.base, a.parts | b.depends, signs, None, limits, a.wrapped or b.wrapped, a.line)

    def difference(self, a: Form, b: Form) -> Form:
        if a.base is not None and a.base == b.base:
            return Form(parts=a.parts | b.parts)
        return self.sum(a, _negative(b))

    def called(self, node: ast.Call) -> Forms:
        match node.func:
            case ast.Name(id=name) if name in self.law.helpers:
                return self.call(node)[0]
            case ast.Name(id="_float" | "_noted" | "_force" | "_divisor"):
                return self.value(node.args[0])
            case ast.Name(id="min" | "max" as name):
                side = frozenset((_UPPER if name == "min" else _LOWER,))
                every = frozenset[Form]().union(*(self.value(one) for one in node.args))
                return _limited(replace(f, limits=f.limits | side) for f in every)
            case ast.Attribute(attr="fmod"):
                return _wrapped(self.value(node.args[0]))
        given = [self.value(one) for one in node.args]
        if isinstance(node.func, ast.Attribute) and node.func.attr in _PERIODIC:
            self.angles += [(self.line, form) for form in given[0]]
        return _unknown_function(*given)

    def call(self, node: ast.expr) -> list[Forms]:
        """Return what a helper returns for its arguments."""
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        tree = self.law.helpers[node.func.id]
        names = [a.arg for a in tree.args.args]
        given = dict(zip(names, map(self.value, node.args), strict=True))
        outside = self.names, self.returned, self.guards
        self.names, self.returned = given, []
        self.walk(tree.body)
        found = self.returned
        self.names, self.returned, self.guards = outside
        return [_limited(frozenset().union(*column)) for column in zip(*found, strict=True)]


def _wrapped(forms: Forms) -> Forms:
    """Return the abstract remainder of a value; the value before the division may still grow."""
    return frozenset(replace(f, wrapped=True) for f in forms)


def _place(node: ast.Subscript) -> tuple[int, bool]:
    """Return the index of a state and True; for a variable index, the array's first index and False."""
    match node.slice:
        case ast.Constant(value=int() as place):
            return place, True
        case ast.BinOp(left=ast.Constant(value=int() as start)):
            return start, False
    raise AssertionError(ast.dump(node))


def remarks(law: CheckedLaw, state_names: Sequence[str]) -> tuple[Remark, ...]:
    """Return remarks by line on states that accumulate dt, on stored times, and on growing angles."""
    evaluation = _Evaluation(law)
    places = sorted({place for end in evaluation.ends for place in end})
    finals = {
        place: {form for end in evaluation.ends for form in end.get(place, _untouched(place))}
        for place in places
    }
    found = []
    for place, forms in finals.items():
        drifting = [f for f in forms if _drifts(place, f, forms, finals)]
        if drifting:
            periodic = any(f.wrapped or FRACTION in f.parts or f.signs >= {1, -1} for f in drifting)
            instead = _PERIOD if periodic else _COUNT
            line = max(f.line for f in drifting)
            found.append(Remark(line, instead.format(_name(state_names[place]))))
    counters = {place for place, forms in finals.items() if _counts_for_ever(place, forms)}
    for line, angle in evaluation.angles:
        if counter := _one_of(counters, angle):
            found.append(Remark(line, _ANGLE.format(_name(state_names[counter[0]]))))
    for place, forms in finals.items():
        for form in forms:
            if form.base is None and DT in form.parts and (counter := _one_of(counters, form)):
                names = (_name(state_names[k]) for k in (place, *counter))
                found.append(Remark(form.line, _KEPT.format(*names)))
    return tuple(sorted(dict.fromkeys(found), key=lambda r: r.line))


_DRIFTS = "`s.{0}` becomes inaccurate on the board and in a sketch, which compute with 7 digits: "
_COUNT = (
    _DRIFTS
    + "count the calls, `s.{0} += 1`, and multiply by `dt` last, as in `(s.{0} - s.start) * dt`. With 7 "
    "digits, a sum of `dt` is wrong by 3 ms after 10 s and by seconds after 10 min"
)
_AGAIN = (
    "start `s.{0}` again from 0 after each period, with `s.{0} = (s.{0} + 1) % n` for `n` calls in a period"
)
_PERIOD = _DRIFTS + _AGAIN
_KEPT = (
    "the time `s.{0}` becomes inaccurate on the board and in a sketch: store the count, `s.{0} = s.{1}`, "
    "and multiply by `dt` last, as in `(s.{1} - s.{0}) * dt`"
)
_ANGLE = "this angle grows with `s.{0}` and becomes inaccurate on the board and in a sketch: " + _AGAIN


def _untouched(place: int) -> Forms:
    return frozenset((Form(place, signs=frozenset()),))


def _name(state: str) -> str:
    return state.partition("[")[0]


def _drifts(place: int, form: Form, forms: set[Form], finals: Mapping[int, set[Form]]) -> bool:
    """Return True if a state accumulates time without a limit or an exact reset."""
    if form.base != place:
        return False
    # a non-integer step in every call accumulates like time
    always = FRACTION in form.parts and all(f.base == place and FRACTION in f.parts for f in forms)
    taken_back = any(f.base == place and f.signs and DT not in f.parts for f in forms)
    if not (DT in form.parts or always) or (form.bounded and not taken_back):
        return False
    return not _causes(form.parts, finals) & {MOTION, place}


def _causes(parts: Iterable[str | int], finals: Mapping[int, set[Form]]) -> set[str | int]:
    """Return all dependencies of parts: the parts, and the dependencies of the states among them."""
    found, open_ = set[str | int](), set(parts)
    while open_:
        part = open_.pop()
        found.add(part)
        if isinstance(part, int):
            open_ |= {d for f in finals.get(part, ()) for d in f.depends} - found - {part}
    return found


def _one_of(counters: set[int], form: Form) -> tuple[int, ...]:
    """Return the only state on which a value depends, as a tuple, if this state is one of ``counters``.

    Otherwise return (). A value that depends on two counters may be their difference, which does not grow.
    """
    states = tuple(part for part in form.depends if isinstance(part, int))
    return states if len(states) == 1 and states[0] in counters else ()


def _counts_for_ever(place: int, forms: set[Form]) -> bool:
    """Return True if a state counts up or down for ever and is never reset."""
    return any(f.signs for f in forms) and all(
        f.base == place and not (f.bounded or f.wrapped) for f in forms
    )

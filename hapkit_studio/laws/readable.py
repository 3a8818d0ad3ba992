"""A law specialised for readability: choices are resolved; names and functions stay as in the source."""

import ast
from collections import Counter
from collections.abc import Sequence

from hapkit_studio.laws import tree as t
from hapkit_studio.laws.specialise import Specialiser
from hapkit_studio.laws.translate import CheckedLaw

_ONE, _ZERO = t.literal(1.0), t.literal(0.0)
_PERIOD = t.Var("dt")


def specialise(law: CheckedLaw, values: Sequence[float], choices: frozenset[int]) -> t.Specialised:
    """Return a law whose choices, given by index, are resolved.

    A call becomes an operation named ``name()``. The second and further results of a call become operations
    ``.a``, ``.b`` … on this operation.
    """
    inlined: set[str] = set()
    moving: set[tuple[str, str]] = set()
    while True:
        walk = _Readable(law, values, choices, inlined, moving)
        made = t.Specialised(walk.law(), [], law.tables)
        if not moving >= walk.differing:
            moving |= walk.differing
            continue
        more = {k for k, f in walk.functions.items() if walk.calls[k] == 1 and _is_straight(f.body)}
        if not more:
            break
        inlined |= more
    _drop_unread_state(made.body)
    t.drop_unused(made)
    needed = _called(made.body)
    for function in reversed(walk.functions.values()):
        if function.name in needed:
            made.functions.insert(0, function)
            needed |= _called(function.body)
    return made


class _Readable(Specialiser):
    """A specialiser that keeps one variable per source name and does not inline functions."""

    def __init__(
        self,
        law: CheckedLaw,
        values: Sequence[float],
        choices: frozenset[int],
        inlined: set[str],
        moving: set[tuple[str, str]],
    ):
        super().__init__(law, {i: values[i] for i in choices}, None, inlined)
        self.values, self.moving = values, moving
        self.differing: set[tuple[str, str]] = set()  # (function, parameter) pairs whose arguments vary
        self.given: dict[str, dict[str, t.Expr]] = {}  # known arguments by function
        self.own: set[str] = set()  # the current function's parameters that have a separate variable
        self.changing: dict[int, set[str]] = {}  # names that are assigned more than once, by function
        # results that are constant, by function
        self.known_results: dict[str, list[t.Num | None]] = {}

    def walk(self, statements: Sequence[ast.stmt]) -> bool:
        if statements is self.scope.tree.body:
            self.pin_changing(statements)
        return super().walk(statements)

    def pin_changing(self, statements: Sequence[ast.stmt]) -> None:
        """Give one variable to each parameter, and to each name with several assignments in the function."""
        nodes = [n for s in statements for n in ast.walk(s)]
        stores = Counter(n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
        heads = [n.body[0] for n in nodes if isinstance(n, ast.For)]
        counters = {n.targets[0].id for n in heads}  # type: ignore[attr-defined]
        changing = {n for n, times in stores.items() if times > 1 and n != "_"}
        self.changing[id(self.scope.tree)] = changing | counters
        for name in stores:
            if name in self.own:
                self.scope.pinned[name] = name
            elif name in self.env or name in changing - counters:
                self.pin(name)

    def pin(self, name: str) -> None:
        """Pin a name to one variable, unless its value is constant in its scope."""
        if name in self.env or name in self.changing[id(self.scope.tree)]:
            super().pin(name)

    def fresh(self, name: str) -> str:
        return super().fresh(name.strip("_") or "value")

    def bind(self, name: str, value: t.Expr) -> None:
        if name == "_" and not self.reads(name):
            return
        if name in self.scope.pinned or isinstance(value, t.Num | t.Var):
            super().bind(name, value)
        else:
            self.env[name] = self.stored(value, name)
            if t.is_truth(value):
                self.truths.add(self.env[name])

    def emit(self, statement: t.Statement) -> None:
        match statement:
            case t.If(t.Compare("==", t.Var(name), t.Num(0.0)), [t.Assign(to, t.Num(0.0))], []) if name == to:
                pass  # no effect: this statement sets a variable to 0 only if it is already 0
            case _:
                super().emit(statement)

    def keep_unless_select(self, value: t.Expr) -> t.Expr:
        return value

    def assign_several(self, targets: Sequence[ast.expr], value: ast.expr) -> None:
        values = [self.value(v) for v in value.elts] if isinstance(value, ast.Tuple) else self.call(value)
        for i, target in enumerate(targets):
            # a later value must not read a variable that this assignment changes
            written = frozenset(self.written([target]))
            for j, other in enumerate(values[i + 1 :], i + 1):
                if t.mentions(other, written):
                    name = getattr(targets[j], "id", "")  # "" for a state
                    values[j] = self.copy(other, f"new_{name}" if name else "new")
            self.assign(target, values[i])

    # --- functions
    def call(self, node: ast.expr) -> list[t.Expr]:
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        tree = self.source.helpers[node.func.id]
        key, names = tree.name, [a.arg for a in tree.args.args if a.arg != "_fault"]
        given = {n: self.value(a) for n, a in zip(names, node.args, strict=False)}
        if key in self.inlined:
            self.own = set()
            kept = {n: v if _is_constant(v) else self.stored(v, n) for n, v in given.items()}
            return self.write_in(tree, kept)
        known = {n: v for n, v in given.items() if _is_constant(v) and (key, n) not in self.moving}
        before = self.given.setdefault(key, known)
        self.differing |= {(key, n) for n in {*before, *known} if before.get(n) != known.get(n)}
        if key not in self.functions:
            self.functions[key] = self.made(key, tree, given, [n for n in names if n not in known])
        self.calls[key] += 1
        function = self.functions[key]
        for name in sorted(set(given) - set(function.parameters)):
            if t.may_fail(given[name]):  # evaluating an unused argument may still stop the law
                self.stored(given[name], name)
        made = t.Op(f"{function.name}()", tuple(given[n] for n in function.parameters))
        known_results = self.known_results[key]
        if len(known_results) == 1:
            return [known_results[0] or made]
        got = self.stored(made, "got")
        return [r or t.Op(f".{'abcdefghijklmnop'[i]}", (got,)) for i, r in enumerate(known_results)]

    def made(
        self, key: str, tree: ast.FunctionDef, given: dict[str, t.Expr], moving: list[str]
    ) -> t.Function:
        name = tree.name.removeprefix("_of_").lstrip("_")
        while name in ("force", *(f.name for f in self.functions.values())):
            name += "_"
        outside = self.frames, self.states, self.used, self.truths
        self.frames, self.states, self.used, self.truths = [], {}, Counter(["dt", *moving]), set()
        block, self.own = t.Block(), set(moving)
        found = self.enter(tree, given | {n: t.Var(n) for n in moving}, block)
        self.frames, self.states, self.used, self.truths = outside
        results = tuple(f"@{i}" for i in range(len(found[0][1])))
        for leave, values in found:
            leave.moves += [t.Assign(r, v) for r, v in zip(results, values, strict=True)]
        function = t.Function(key, name, (), results, block)
        t.drop_unused(t.Specialised([], [function], {}))
        read = {n.name for n in t.walk(block) if isinstance(n, t.Var)}
        function.parameters = tuple(n for n in moving if n in read)
        fails = any(isinstance(n, t.Op) and n.name == "divisor()" for n in t.walk(block))
        self.known_results[key] = [
            v[0] if not fails and isinstance(v[0], t.Num) and all(o == v[0] for o in v) else None
            for v in zip(*(values for _, values in found), strict=True)
        ]
        return function

    # --- values
    def value(self, node: ast.expr) -> t.Expr:
        match node:
            case ast.Call(func=ast.Name(id="_divisor"), args=args):
                value = self.value(args[0])
                return value if self.never_zero(value) else t.Op("divisor()", (value,))
        return super().value(node)

    def never_zero(self, value: t.Expr) -> bool:
        found = self.evaluated(value)
        return isinstance(found, t.Num) and found.value != 0.0

    def evaluated(self, value: t.Expr) -> t.Expr:
        """Return a value with parameters substituted, in which the period is a plain number."""
        match value:
            case t.Var(name) if name.startswith("p["):
                return t.literal(self.values[int(name[2:-1])])
            case t.Var("dt"):
                return t.literal(1e-3)
            case t.Op(name, args) if _is_constant(value):
                return self.op(name, *map(self.evaluated, args))
        return value

    def op(self, name: str, *args: t.Expr) -> t.Expr:
        numbers = [a for a in args if isinstance(a, t.Num)]
        found: t.Expr | None = t.folded(name, numbers) if len(numbers) == len(args) else None
        if args[0] == _ZERO and (name == "copysign" or (name == "/" and self.never_zero(args[1]))):
            return _ZERO
        if found is None and any(abs(n.value) in (0.0, 1.0) for n in numbers):
            found = t.simplified(name, args)
        return found or t.Op(name, args)

    def choice(self, test: t.Test, yes: t.Num, no: t.Num) -> t.Expr:
        return t.Select(test, yes, no)

    def chosen(self, test: t.Test, yes: t.Expr, no: t.Expr) -> t.Expr | None:
        return t.Select(test, yes, no)

    def compare(self, op: str, left: t.Expr, right: t.Expr) -> t.Test | bool:
        chosen = t.Select(t.Compare("!=", left, _ZERO), _ONE, _ZERO) if left in self.truths else left
        if isinstance(chosen, t.Select) and isinstance(right, t.Num):
            test, arms = chosen.test, (chosen.yes, chosen.no)
            yes, no = (self.compare(op, arm, right) if isinstance(arm, t.Num) else None for arm in arms)
            if isinstance(yes, bool) and isinstance(no, bool):
                return yes if yes == no else test if yes else t.negated(test)
        made = super().compare(op, left, right)
        if isinstance(made, t.Compare) and isinstance(made.right, t.Num):
            if not t.is_single(made.right.value):
                return t.beyond_single(made.op, made.left, made.right.value)
            if made.left == _PERIOD and made.right.value == 0.0:
                return made.op in (">", ">=", "!=")
        return made


def _is_constant(value: t.Expr) -> bool:
    """Return True if a value consists only of numbers, parameters and the period."""
    match value:
        case t.Op(name, args):
            return not name.endswith("()") and not name.startswith(".") and all(map(_is_constant, args))
        case t.Var(name):
            return name == "dt" or name.startswith("p[")
    return isinstance(value, t.Num)


def _called(value: object) -> set[str]:
    """Return the names of the called functions."""
    return {n.name[:-2] for n in t.walk(value) if isinstance(n, t.Op) and n.name.endswith("()")}


def _state_read(value: object) -> Counter[str]:
    """Return how often each state is read."""
    parts = [n for n in t.walk(value) if isinstance(n, t.Var | t.At)]
    return Counter(name for n in parts for name in (n.state() if isinstance(n, t.At) else [n.name]))


def _drop_unread_state(statements: list[t.Statement]) -> None:
    """Remove assignments to states that the law itself never reads, because only a drawing uses them."""
    read = _state_read(statements)
    sets = [n for n in t.walk(statements) if isinstance(n, t.Assign) and n.to.startswith("s[")]
    for one in sets:
        read[one.to] -= _state_read(one.value)[one.to]
    for one in sets:
        if not read[one.to]:
            one.to = "unread"


def _is_straight(block: t.Block) -> bool:
    """Return True if a block has no early exit."""
    return [n for n in t.walk(block.body) if isinstance(n, t.Leave)] == block.body[-1:]

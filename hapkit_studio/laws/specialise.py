"""Partial evaluation of a law for the board: choices are resolved, constants folded, functions inlined.

All parameters and the period are known numbers. For a sketch, ``readable`` keeps the names of parameters.
"""

import ast
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce

from hapkit_studio.laws import tree as t
from hapkit_studio.laws.translate import CheckedLaw

_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**",
}  # fmt: skip
_COMPARISONS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
# functions in the generated source that return their argument unchanged
_TRANSPARENT = frozenset(("_float", "_noted", "_force", "_divisor"))
_ROUNDING = frozenset(("floor", "ceil", "trunc"))


def specialise(law: CheckedLaw, known: Mapping[int, float], period: float, small: int = 14) -> t.Specialised:
    """Return a law for known parameters, by index, and a period in s, optimised for speed.

    A function that is called once, or has at most ``small`` operations, is inlined.
    """
    inlined: set[str] = set()
    while True:
        walk = Specialiser(law, known, period, inlined)
        made = t.Specialised(walk.law(), list(walk.functions.values()), law.tables)
        sizes: dict[str, int] = {}  # size of each function, including its callees
        for key, function in walk.functions.items():
            sizes[key] = t.weight(function.body) + sum(sizes[k] for k in t.called(function.body))
        more = {key for key, size in sizes.items() if walk.calls[key] == 1 or size <= small}
        if not more:
            break
        inlined |= more
    t.drop_unused(made)
    t.substitute(made)
    return made


@dataclass
class _Scope:
    """The state of a function while it is evaluated."""

    tree: ast.FunctionDef
    shows: bool  # True if its line numbers are those of the law's file
    block: t.Block | None = None  # the block that replaces the function; None for the law's body
    found: list[tuple[t.Leave, list[t.Expr]]] = field(default_factory=list)  # return values
    pinned: dict[str, str] = field(default_factory=dict)  # the variable of each name that a loop changes
    loads: Counter[str] | None = None


class Specialiser:
    """An abstract interpreter of a law that records what is known of every name."""

    def __init__(self, law: CheckedLaw, known: Mapping[int, float], period: float | None, inlined: set[str]):
        self.source, self.known, self.period, self.inlined = law, known, period, inlined
        self.folds = period is not None
        self.out: list[t.Statement] = []
        self.scopes: list[_Scope] = []
        self.frames: list[dict[str, t.Expr]] = []  # the values of the names, innermost frame last
        self.states: dict[str, t.Expr] = {}  # the known values of state and of arguments
        self.used: Counter[str] = Counter()
        self.functions: dict[str, t.Function] = {}
        self.calls: Counter[str] = Counter()
        self.truths: set[t.Expr] = set()  # Boolean variables
        self.line = 0

    def law(self) -> list[t.Statement]:
        period = t.Var("dt") if self.period is None else t.Num(self.period, "dt")
        self.frames.append({"x": t.Var("x"), "v": t.Var("v"), "dt": period})
        self.used.update(("x", "v", "dt"))
        self.scopes.append(_Scope(self.source.tree, True))
        self.walk(self.source.tree.body)
        return self.out

    # --- names
    @property
    def env(self) -> dict[str, t.Expr]:
        return self.frames[-1]

    @property
    def scope(self) -> "_Scope":
        return self.scopes[-1]

    def fresh(self, name: str) -> str:
        """Return an unused variable name."""
        name = name.lstrip("_")
        self.used[name] += 1
        return name if self.used[name] == 1 else self.fresh(f"{name}_{self.used[name]}")

    def emit(self, statement: t.Statement) -> None:
        statement.line = self.line
        self.out.append(statement)

    def stored(self, value: t.Expr, name: str = "t") -> t.Expr:
        """Return a value that costs nothing to read: a constant or a variable."""
        return value if isinstance(value, t.Num | t.Var) else self.copy(value, name)

    def copy(self, value: t.Expr, name: str = "t") -> t.Var:
        """Return a new variable with this value."""
        made = self.fresh(name)
        self.emit(t.Assign(made, value))
        return t.Var(made)

    def detach(self, names: frozenset[str]) -> None:
        """Snapshot expressions that read variables which are about to be overwritten."""
        copies: dict[t.Expr, t.Expr] = {}
        for frame in self.frames:
            for name, value in frame.items():
                if t.mentions(value, names):
                    frame[name] = copies[value] = copies.get(value) or self.copy(value, name)
        self.states = {k: v for k, v in self.states.items() if k not in names and not t.mentions(v, names)}

    def bind(self, name: str, value: t.Expr) -> None:
        """Bind a name to a value."""
        if name in self.scope.pinned:
            variable = self.scope.pinned[name]
            if value != t.Var(variable):
                self.detach_others(variable)
                self.emit(t.Assign(variable, value))
            return
        lazy = isinstance(value, t.Num | t.Var)
        if isinstance(value, t.Select):
            lazy = self.is_cheap_test(value.test) or self.reads(name) == 1
        self.env[name] = value if lazy else self.stored(value, name)

    def detach_others(self, variable: str) -> None:
        """Snapshot all expressions that read a loop's variable, except the name bound to that variable."""
        own = {n: t.Var(v) for n, v in self.scope.pinned.items() if v == variable and n in self.env}
        for name in own:
            del self.env[name]
        self.detach(frozenset((variable,)))
        self.env.update(own)

    # --- statements
    def walk(self, statements: Sequence[ast.stmt]) -> bool:
        """Evaluate statements in order; return True if the code after them is unreachable."""
        return any(self.statement(s) for s in statements)

    def statement(self, node: ast.stmt) -> bool:
        if self.scope.shows:
            self.line = node.lineno
        match node:
            case ast.Assign(targets=[ast.Tuple(elts=targets)], value=value):
                self.assign_several(targets, value)
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if is_test(value):
                self.bind(name, self.truth(value, self.reads(name) == 1))
            case ast.Assign(targets=[target], value=value):
                self.assign(target, self.value(value))
            case ast.If(test=ast.Call(func=ast.Name(id="_spent"))):
                pass
            case ast.If():
                return self.branch(node)
            case ast.For():
                self.loop(node)
            case ast.Return(value=value):
                self.leave(value)
                return True
            case ast.Break():
                self.emit(t.Break())
                return True
            case ast.Continue():
                self.emit(t.Continue())
                return True
        return False

    def assign(self, target: ast.expr, value: t.Expr) -> None:
        if isinstance(target, ast.Name):
            self.bind(target.id, value)
            return
        place = self.place(target)
        if isinstance(place, t.At):
            value = self.stored(value)
            self.detach(frozenset(place.state()))
            self.emit(t.SetAt(place, value))
        elif self.states.get(place.name) != value and value != place:
            self.detach(frozenset((place.name,)))
            self.emit(t.Assign(place.name, value))
            if isinstance(value, t.Num | t.Var):
                self.states[place.name] = value  # valid until the state or the value is overwritten

    def assign_several(self, targets: Sequence[ast.expr], value: ast.expr) -> None:
        if isinstance(value, ast.Tuple):
            values = [self.keep_unless_select(self.value(v)) for v in value.elts]
        else:
            values = self.call(value)
        written = frozenset(self.written(targets))
        values = [self.copy(v) if t.mentions(v, written) else v for v in values]
        for target, one in zip(targets, values, strict=True):
            self.assign(target, one)

    def keep_unless_select(self, value: t.Expr) -> t.Expr:
        return value if isinstance(value, t.Select) else self.stored(value)

    def written(self, targets: Sequence[ast.expr]) -> list[str]:
        """Return the persistent variables that assignment targets write."""
        found: list[str] = []
        for target in targets:
            match target:
                case ast.Name(id=name):
                    found += [self.scope.pinned[name]] if name in self.scope.pinned else []
                case ast.Subscript(slice=ast.Constant(value=int() as place)):
                    found.append(f"s[{place}]")
                case ast.Subscript(slice=ast.BinOp(ast.Constant(int() as start), _, ast.Call(args=args))):
                    found += [f"s[{start + i}]" for i in range(ast.literal_eval(args[1]))]
        return found

    def branch(self, node: ast.If) -> bool:
        test = self.test(node.test)
        if isinstance(test, bool):
            return self.walk(node.body if test else node.orelse)
        frames, states = [dict(f) for f in self.frames], dict(self.states)
        outside, self.out, line = self.out, [], self.line
        left = self.walk(node.body)
        then, then_frames, then_states = self.out, self.frames, self.states
        self.frames, self.states, self.out = frames, states, []
        gone = self.walk(node.orelse)
        other = self.out
        self.out, self.line = outside, line
        if gone and not left:
            self.frames, self.states = then_frames, then_states
        elif not left:
            self.merge(test, then, then_frames, other)
            self.states = {k: v for k, v in self.states.items() if then_states.get(k) == v}
        if then or other or t.may_fail(test):
            self.emit(t.If(test, then, other))
        return left and gone

    def merge(
        self,
        test: t.Test,
        then: list[t.Statement],
        then_frames: list[dict[str, t.Expr]],
        other: list[t.Statement],
    ) -> None:
        """Merge the values of every name after a branch; self.frames contains those of the ``other`` side."""
        chosen: dict[tuple[t.Expr, t.Expr], t.Expr] = {}
        empty = self.folds and not then and not other and self.is_cheap_test(test)
        for mine, theirs in zip(self.frames, then_frames, strict=True):
            for name in list(mine):
                yes, no = theirs.get(name), mine[name]
                if yes is None:
                    del mine[name]
                    continue
                if yes == no:
                    continue
                if (yes, no) not in chosen:
                    if yes == t.literal(0.0) and test == t.Compare("==", no, yes):
                        chosen[yes, no] = no  # both values are the same, because the test is true only for 0
                    elif empty and isinstance(yes, t.Num) and isinstance(no, t.Num):
                        chosen[yes, no] = t.Select(test, yes, no)
                    else:
                        made = self.fresh(name)
                        then.append(t.Assign(made, yes))
                        other.append(t.Assign(made, no))
                        chosen[yes, no] = t.Var(made)
                mine[name] = chosen[yes, no]

    def is_cheap_test(self, test: t.Test, several: bool = False) -> bool:
        """Return True if a test is cheap enough for conditional code: one cheap comparison, or several joined
        ones if ``several`` is true."""
        match test:
            case t.Compare(_, left, right):
                return _is_cheap(left) and _is_cheap(right)
            case t.Not(inner):
                return self.is_cheap_test(inner, several)
            case t.Logic(_, tests):
                return several and all(self.is_cheap_test(one, True) for one in tests)
        return False

    def loop(self, node: ast.For) -> None:
        call = node.iter
        assert isinstance(call, ast.Call)
        turns = range(*(ast.literal_eval(a) for a in call.args))
        if not turns:
            return
        counter, body = node.body[0].targets[0].id, node.body[1:]  # type: ignore[attr-defined]
        targets = _targets(body)
        assigned = {one.id for one in targets if isinstance(one, ast.Name)}
        outer = self.scope.pinned
        self.detach(frozenset(self.written([one for one in targets if not isinstance(one, ast.Name)])))
        for name in sorted((assigned | {counter}) & set(outer)):
            self.detach_others(outer[name])
        known = counter in self.env
        names = [n for s in body for n in ast.walk(s) if isinstance(n, ast.Name)]
        counted = known or any(n.id == counter and not isinstance(n.ctx, ast.Store) for n in names)
        self.scope.pinned = dict(outer)
        for name in sorted(assigned | ({counter} if counted else set())):
            if name not in outer:
                self.pin(name)
        after: list[t.Statement] = []
        outside, self.out, self.states, line = self.out, [], {}, self.line
        if counted:
            place = self.scope.pinned[counter]
            # use a separate counter if the body changes the name, or if code after the loop reads it
            own = self.fresh(counter) if counter in assigned or known else place
            outside.append(t.Assign(own, t.literal(float(turns.start))))
            if own != place:
                self.emit(t.Assign(place, t.Var(own)))
            after.append(t.Assign(own, t.Op("+", (t.Var(own), t.literal(float(turns.step))))))
        before = [dict(f) for f in self.frames]
        self.walk(body)
        self.frames, self.states = before, {}
        inner, self.out, self.line = self.out, outside, line
        self.emit(t.Loop(len(turns), inner, after))
        self.scope.pinned = outer

    def pin(self, name: str) -> None:
        """Keep a name in one variable while a loop that changes the name is evaluated."""
        variable = self.fresh(name)
        if name in self.env:
            self.emit(t.Assign(variable, self.env[name]))
        self.scope.pinned[name] = variable
        self.env[name] = t.Var(variable)

    def leave(self, value: ast.expr | None) -> None:
        assert value is not None
        block = self.scope.block
        if block is None:
            self.emit(t.Return(self.value(value)))
            return
        several = value.elts if isinstance(value, ast.Tuple) else [value]
        values = [self.keep_unless_select(self.value(v)) for v in several]
        made = t.Leave(block, [])
        self.emit(made)
        self.scope.found.append((made, values))

    # --- functions
    def call(self, node: ast.expr) -> list[t.Expr]:
        """Return the results of a call to one of the law's functions."""
        assert isinstance(node, ast.Call)
        assert isinstance(node.func, ast.Name)
        tree = self.source.helpers[node.func.id]
        names = [a.arg for a in tree.args.args if a.arg != "_fault"]
        # the last argument is the array of fault words
        values = [self.keep_unless_select(self.value(a)) for a in node.args[:-1]]
        given = dict(zip(names, values, strict=True))
        key = f"{node.func.id}({','.join(v.key if isinstance(v, t.Num) else '' for v in values)})"
        if key in self.inlined:
            return self.write_in(tree, given)
        return self.call_function(key, tree, given)

    def enter(
        self, tree: ast.FunctionDef, given: dict[str, t.Expr], block: t.Block
    ) -> list[tuple[t.Leave, list[t.Expr]]]:
        """Evaluate a function's body into the block; return its ``return`` statements with their values."""
        scope = _Scope(tree, self.scope.shows and tree.name in self.source.own, block)
        self.frames.append(given)
        self.scopes.append(scope)
        line, outside, self.out = self.line, self.out, block.body
        self.walk(tree.body)
        self.line, self.out = line, outside
        self.frames.pop()
        self.scopes.pop()
        return scope.found

    def write_in(self, tree: ast.FunctionDef, given: dict[str, t.Expr]) -> list[t.Expr]:
        """Inline a function and return its results."""
        block = t.Block()
        found = self.enter(tree, given, block)
        if len(found) == 1 and block.body[-1] is found[0][0]:
            self.out += block.body[:-1]
            return found[0][1]
        results: list[t.Expr] = []
        columns = list(zip(*(values for _, values in found), strict=True))
        for column in columns:
            if all(v == column[0] for v in column):
                results.append(column[0])
                continue
            made = self.fresh("r")
            for (leave, _), value in zip(found, column, strict=True):
                leave.moves.append(t.Assign(made, value))
            results.append(t.Var(made))
        match block.body:
            case [t.If(test, [_], []), _] if len(found) == 2 and self.is_cheap_test(test):
                # the values are constants, so no branch is needed
                if all(a == b or (isinstance(a, t.Num) and isinstance(b, t.Num)) for a, b in columns):
                    return [a if a == b else t.Select(test, a, b) for a, b in columns]
        self.emit(block)
        return results

    def call_function(self, key: str, tree: ast.FunctionDef, given: dict[str, t.Expr]) -> list[t.Expr]:
        """Return the results of a function that is not inlined; its code is built at the first call."""
        self.calls[key] += 1
        moving = [n for n, v in given.items() if not isinstance(v, t.Num)]
        if key not in self.functions:
            self.functions[key] = self.made(key, tree, given, moving)
        function = self.functions[key]
        for parameter, name in zip(function.parameters, moving, strict=True):
            if self.states.get(parameter) != given[name]:
                self.emit(t.Assign(parameter, given[name]))
                self.states[parameter] = given[name]
        self.emit(t.Call(function))
        # the call may have changed the arguments of other functions
        own = frozenset(function.parameters)
        self.states = {k: v for k, v in self.states.items() if k in own or k.startswith("s[")}
        return [self.copy(t.Var(name), "r") for name in function.results]

    def made(
        self, key: str, tree: ast.FunctionDef, given: dict[str, t.Expr], moving: list[str]
    ) -> t.Function:
        name = self.fresh(tree.name.removeprefix("_of_"))
        parameters = tuple(self.fresh(f"{name}_{n}") for n in moving)
        inside = {**given, **{n: t.Var(p) for n, p in zip(moving, parameters, strict=True)}}
        frames, states = self.frames, self.states
        self.frames, self.states = [], {}
        block = t.Block()
        found = self.enter(tree, inside, block)
        self.frames, self.states = frames, states
        results = tuple(self.fresh(f"{name}_out") for _ in found[0][1])
        for leave, values in found:
            leave.moves += [t.Assign(r, v) for r, v in zip(results, values, strict=True)]
        return t.Function(key, name, parameters, results, block)

    # --- values
    def value(self, node: ast.expr) -> t.Expr:
        """Return the value of an expression; conditions inside become statements before it."""
        match node:
            case ast.Constant(value=bool() | int() | float() as value):
                return t.literal(float(value))
            case ast.Name(id=name):
                return self.env[name]
            case ast.Subscript(ast.Name("p"), ast.Constant(int() as n)):
                return t.Num(self.known[n], f"p{n}") if n in self.known else t.Var(f"p[{n}]")
            case ast.Subscript(value=ast.Name(id="s")):
                place = self.place(node)
                return place if isinstance(place, t.At) else self.states.get(place.name, place)
            case ast.Subscript(ast.Name(table), ast.Call(args=[index, ast.Constant(int() as size), *_])):
                return self.entry(table, self.value(index), size)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.value(operand)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.op("neg", self.value(operand))
            case ast.BinOp(left=left, op=op, right=right):
                return self.op(_ARITHMETIC[type(op)], self.value(left), self.value(right))
            case ast.IfExp():
                return self.either(node)
            case ast.Call(func=ast.Name(id=name), args=args) if name in self.source.helpers:
                return self.call(node)[0]
            case ast.Call(func=ast.Name(id=name), args=args) if name in _TRANSPARENT:
                return self.value(args[0])
            case ast.Call(func=ast.Name(id="min" | "max" as name), args=args):
                return reduce(partial(self.op, name), [self.value(a) for a in args])
            case ast.Call(func=ast.Name(id=name), args=args):
                return self.op(name, *(self.value(a) for a in args))
            case ast.Call(func=ast.Attribute(attr=name), args=[ast.BinOp(op=ast.Div()) as quotient]) if (
                self.folds and name in _ROUNDING
            ):
                # multiplication by the inverse may miss an exact integer quotient
                sides = (self.stored(self.value(quotient.left)), self.stored(self.value(quotient.right)))
                both = all(isinstance(side, t.Num) for side in sides)
                return self.op(name, self.op("/", *sides) if both else t.Op("/", sides))
            case ast.Call(func=ast.Attribute(attr="log10"), args=[operand]) if self.folds:
                argument = self.value(operand)
                known = t.folded("log10", [argument]) if isinstance(argument, t.Num) else None
                return known or self.op("*", self.op("log", argument), t.literal(1.0 / math.log(10.0)))
            case ast.Call(func=ast.Attribute(attr=name), args=args):
                return self.op("abs" if name == "fabs" else name, *(self.value(a) for a in args))
        return self.truth(node)

    def truth(self, node: ast.expr, once: bool = False) -> t.Expr:
        """Return a test's value as a number, 1 or 0.

        If ``once`` is true, the value is read only once and not stored.
        """
        if isinstance(node, ast.BoolOp) and not all(map(self.is_truth, node.values)):
            return self.one_of(node)
        one, zero = t.literal(1.0), t.literal(0.0)
        test = self.test(node)
        if isinstance(test, bool):
            return one if test else zero
        if isinstance(test, t.Compare) and self.folds:
            test = t.Compare(test.op, self.stored(test.left), self.stored(test.right))
        if once and self.is_cheap_test(test, True):
            return t.Select(test, one, zero)
        return self.choice(test, one, zero)

    def is_truth(self, node: ast.expr) -> bool:
        """Return True if the value of a node is Boolean, 1 or 0."""
        if isinstance(node, ast.Name):
            value = self.env[node.id]
            return value in self.truths or t.is_truth(value)
        return all(map(self.is_truth, node.values)) if isinstance(node, ast.BoolOp) else is_test(node)

    def one_of(self, node: ast.BoolOp) -> t.Expr:
        """Return the operand that decides the result of `and` or `or`; the operands are numbers."""
        value = self.stored(self.value(node.values[0]))
        if len(node.values) == 1:
            return value
        test = self.compare("!=", value, t.literal(0.0))
        if isinstance(node.op, ast.And):
            test = t.negated(test)
        rest = ast.BoolOp(node.op, node.values[1:])
        if isinstance(test, bool):
            return value if test else self.one_of(rest)
        outside, self.out = self.out, []
        other = self.one_of(rest)
        inner, self.out = self.out, outside
        return self.branched(test, value, other, (), inner)

    def reads(self, name: str) -> int:
        """Return how often the current function reads a name."""
        if self.scope.loads is None:
            names = [n for n in ast.walk(self.scope.tree) if isinstance(n, ast.Name)]
            self.scope.loads = Counter(n.id for n in names if isinstance(n.ctx, ast.Load))
        return self.scope.loads[name]

    def choice(self, test: t.Test, yes: t.Num, no: t.Num) -> t.Expr:
        return t.Select(test, yes, no) if self.is_cheap_test(test) else self.branched(test, yes, no)

    def branched(
        self,
        test: t.Test,
        yes: t.Expr,
        no: t.Expr,
        then: Sequence[t.Statement] = (),
        other: Sequence[t.Statement] = (),
    ) -> t.Var:
        """Return a variable that is assigned in a branch; each value is computed only on its side."""
        made = self.fresh("t")
        self.emit(t.If(test, [*then, t.Assign(made, yes)], [*other, t.Assign(made, no)]))
        return t.Var(made)

    def either(self, node: ast.IfExp) -> t.Expr:
        test = self.test(node.test)
        if isinstance(test, bool):
            return self.value(node.body if test else node.orelse)
        outside, self.out = self.out, []
        yes = self.value(node.body)
        then, self.out = self.out, []
        no = self.value(node.orelse)
        other, self.out = self.out, outside
        if not then and not other and (chosen := self.chosen(test, yes, no)):
            return chosen
        return self.branched(test, yes, no, then, other)

    def chosen(self, test: t.Test, yes: t.Expr, no: t.Expr) -> t.Expr | None:
        """Return a conditional expression with two values; None if a branch is needed."""
        both = isinstance(yes, t.Num) and isinstance(no, t.Num)
        return t.Select(test, yes, no) if both and self.is_cheap_test(test, True) else None

    def place(self, node: ast.expr) -> t.At | t.Var:
        """Return the state that a subscript refers to."""
        assert isinstance(node, ast.Subscript)
        match node.slice:
            case ast.Constant(value=int() as place):
                return t.Var(f"s[{place}]")
            case ast.BinOp(left=ast.Constant(value=int() as start), right=ast.Call(args=[index, size, *_])):
                at, count = self.value(index), ast.literal_eval(size)
                if isinstance(at, t.Num) and 0.0 <= at.value < count:
                    return t.Var(f"s[{start + int(at.value)}]")
                return t.At(self.stored(at), start, count)
        raise AssertionError(ast.dump(node))

    def entry(self, table: str, index: t.Expr, size: int) -> t.Expr:
        """Return a table entry; it is a constant if the index is known."""
        if isinstance(index, t.Num) and 0.0 <= index.value < size:
            return t.literal(self.source.tables[table][int(index.value)])
        return t.Entry(self.stored(index) if self.folds else index, table, size)

    def op(self, name: str, *args: t.Expr) -> t.Expr:
        """Return an operation, folded if all operands are known, and simplified if possible."""
        numbers = [a for a in args if isinstance(a, t.Num)]
        if len(numbers) == len(args):
            found = t.folded(name, numbers)
            if found is not None:
                return found
        selects = [a for a in args if isinstance(a, t.Select)]
        if len(selects) == 1 and len(numbers) == len(args) - 1:
            chosen = selects[0]
            yes, no = (
                t.folded(name, [arm if a is chosen else a for a in args])  # type: ignore[misc]
                for arm in (chosen.yes, chosen.no)
            )
            if yes is not None and no is not None:
                return t.Select(chosen.test, yes, no)
        return t.simplified(name, tuple(self.stored(a) if isinstance(a, t.Select) else a for a in args))

    # --- tests
    def test(self, node: ast.expr) -> t.Test | bool:
        """Return a test, or its outcome if the outcome is known."""
        match node:
            case ast.Constant(value=value):
                return bool(value)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return t.negated(self.test(operand))
            case ast.BoolOp(op=op, values=values):
                return self.logic("and" if isinstance(op, ast.And) else "or", values)
            case ast.Compare(left=left, ops=ops, comparators=others):
                sides = [self.value(n) for n in (left, *others)]
                sides = [self.stored(s) for s in sides] if len(sides) > 2 else sides
                tests = [
                    self.compare(_COMPARISONS[type(op)], a, b)
                    for op, a, b in zip(ops, sides, sides[1:], strict=False)
                ]
                return t.joined("and", tests)
        return self.compare("!=", self.value(node), t.literal(0.0))

    def logic(self, op: str, values: Sequence[ast.expr]) -> t.Test | bool:
        """Return the test for values joined by ``op``, "and" or "or", with short-circuit evaluation."""
        first = self.test(values[0])
        if len(values) == 1:
            return first
        if isinstance(first, bool):
            return self.logic(op, values[1:]) if first == (op == "and") else first
        outside, self.out = self.out, []
        rest = self.logic(op, values[1:])
        inner, self.out = self.out, outside
        if not inner:
            found = t.joined(op, [first, rest])
            if isinstance(found, bool) and t.may_fail(first):
                self.emit(t.If(first, [], []))
            return found
        made = self.fresh("t")
        one, zero = t.literal(1.0), t.literal(0.0)
        if isinstance(rest, bool):
            inner.append(t.Assign(made, one if rest else zero))
        else:
            inner.append(t.If(rest, [t.Assign(made, one)], [t.Assign(made, zero)]))
        known: list[t.Statement] = [t.Assign(made, zero if op == "and" else one)]
        self.emit(t.If(first, inner, known) if op == "and" else t.If(first, known, inner))
        return t.Compare("!=", t.Var(made), zero)

    def compare(self, op: str, left: t.Expr, right: t.Expr) -> t.Test | bool:
        if isinstance(left, t.Num) and isinstance(right, t.Num):
            return bool(t.COMPUTED[op](left.value, right.value))
        if isinstance(left, t.Num) or isinstance(right, t.Select):
            op, left, right = t.MIRRORED[op], right, left
        if not self.folds:
            return t.Compare(op, left, right)
        if isinstance(left, t.Select) and isinstance(right, t.Num):
            yes, no = (self.compare(op, arm, right) for arm in (left.yes, left.no))
            if isinstance(yes, bool) and isinstance(no, bool):
                return yes if yes == no else left.test if yes else t.negated(left.test)
        left, right = (self.stored(s) if isinstance(s, t.Select) else s for s in (left, right))
        if isinstance(right, t.Num) and not t.is_single(right.value):
            return t.beyond_single(op, left, right.value)
        return t.Compare(op, left, right)


def _is_cheap(value: t.Expr) -> bool:
    """Return True if reading a value costs almost nothing."""
    inner = value.args[0] if isinstance(value, t.Op) and value.name in ("abs", "neg") else value
    return isinstance(inner, t.Num | t.Var)


def is_test(node: ast.expr) -> bool:
    return isinstance(node, ast.Compare | ast.BoolOp) or (
        isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
    )


def _targets(statements: Sequence[ast.stmt]) -> list[ast.expr]:
    """Return the targets of all assignments in statements, including loop counters."""
    nodes = [n for s in statements for n in ast.walk(s) if isinstance(n, ast.Assign)]
    targets = [one for n in nodes for one in n.targets]
    return [e for one in targets for e in (one.elts if isinstance(one, ast.Tuple) else [one])]

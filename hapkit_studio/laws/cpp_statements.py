"""Writes the statements of a rewritten law in C++."""

import ast

from hapkit_studio.laws import cpp_scopes
from hapkit_studio.laws.cpp_expressions import Expressions, Places
from hapkit_studio.laws.cpp_program import Routine
from hapkit_studio.laws.cpp_small import Small
from hapkit_studio.laws.cpp_words import mangled


class Statements(Expressions):
    """Writes the body of one function; burns says whether its turns are counted."""

    def __init__(
        self,
        routine: Routine,
        routines: dict[str, Routine],
        places: Places,
        small: Small,
        burns: bool = False,
    ):
        super().__init__(routine, routines, places, small)
        self.burns = burns
        self.owned = cpp_scopes.owned(routine.tree)
        loads = [
            n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)
        ]
        stores = [
            n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        ]
        self.loaded = frozenset(loads)
        self.once = {name for name in stores if stores.count(name) == 1}
        self.fresh: set[str] = set()
        self.calls = 0

    def block(self, statements: list[ast.stmt], indent: str = "  ") -> list[str]:
        """Return the lines of a block, its names declared where they are first needed."""
        lines: list[str] = []
        needed = self.owned.get(id(statements), {})
        for place, statement in enumerate(statements):
            names = needed.get(place, [])
            direct = _targets(statement)
            for name in names:
                if name in direct:
                    self.fresh.add(name)
                elif name in self.loaded:
                    lines.append(f"{indent}{self._kind(name)} {mangled(name)} = {self._nothing(name)};")
            lines += self.statement(statement, indent)
        return lines

    def _kind(self, name: str) -> str:
        return "bool" if name in self.truths else "int8_t" if name in self._small else "float"

    def _nothing(self, name: str) -> str:
        return "false" if name in self.truths else "0" if name in self._small else "0.0f"

    @property
    def _small(self) -> set[str]:
        return self.small.names.get(self.routine.name, set())

    def _is_small(self, target: ast.expr) -> bool:
        return isinstance(target, ast.Name) and target.id in self._small and target.id not in self.truths

    def statement(self, node: ast.stmt, indent: str) -> list[str]:
        """Return the lines of one statement."""
        match node:
            case ast.Assign():
                return self._assign(node, indent)
            case ast.If():
                return self._if(node, indent)
            case ast.For():
                return self._for(node, indent)
            case ast.Return():
                return [f"{indent}return {self._returned(node.value)};"]
            case ast.Break():
                return [f"{indent}break;"]
            case ast.Continue():
                return [f"{indent}continue;"]
        return []

    def _returned(self, node: ast.expr | None) -> str:
        assert node is not None
        results = self.small.results.get(self.routine.name, [False])
        values = node.elts if isinstance(node, ast.Tuple) else [node]
        words = [self.suited(v, small) for v, small in zip(values, results, strict=True)]
        return result(words, results)

    def _assign(self, node: ast.Assign, indent: str) -> list[str]:
        target, value = node.targets[0], node.value
        if not isinstance(target, ast.Tuple):
            return self._set(target, self.suited(value, self._is_small(target)), indent)
        if isinstance(value, ast.Tuple):
            return self._set_each(target.elts, value.elts, indent)
        assert isinstance(value, ast.Call)
        self.calls += 1
        got = f"got{self.calls}_"
        assert isinstance(value.func, ast.Name)
        # what is written by hand gives back a reference to where its results stay
        by_hand = self.routines[value.func.id].by_hand
        kind = "auto&" if by_hand else kind_of_result(self.small.results[value.func.id])
        lines = [f"{indent}const {kind} {got} = {self.helper_call(value)};"]
        for i, one in enumerate(target.elts):
            if not isinstance(one, ast.Name) or one.id in self.loaded:
                lines += self._set(one, f"{got}.{'abcdefgh'[i]}", indent)
        return lines

    def _set_each(self, targets: list[ast.expr], values: list[ast.expr], indent: str) -> list[str]:
        """Return several assignments at once; by names of their own where one reads what another sets."""
        words = [self.suited(v, self._is_small(t)) for t, v in zip(targets, values, strict=True)]
        if not _independent(targets, values):
            lines = []
            for i in range(len(words)):
                self.calls += 1
                lines.append(f"{indent}const auto new{self.calls}_ = {words[i]};")
                words[i] = f"new{self.calls}_"
        else:
            lines = []
        for target, word in zip(targets, words, strict=True):
            lines += self._set(target, word, indent)
        return lines

    def _set(self, target: ast.expr, words: str, indent: str) -> list[str]:
        if not isinstance(target, ast.Name):
            return [f"{indent}{self.value(target)} = {words};"]
        name = target.id
        if name not in self.loaded:
            return [f"{indent}(void)({words});"]
        kind = ""
        if name in self.fresh:
            self.fresh.discard(name)
            kind = f"{'const ' if name in self.once else ''}{self._kind(name)} "
        return [f"{indent}{kind}{mangled(name)} = {words};"]

    def _if(self, node: ast.If, indent: str) -> list[str]:
        if _is_burn(node):
            empty = node.body[0]
            assert isinstance(empty, ast.Return)
            values = len(empty.value.elts) if isinstance(empty.value, ast.Tuple) else 1
            nothing = (
                "NAN" if values == 1 else f"laws::Several<{values}>{{{{{', '.join(['NAN'] * values)}}}}}"
            )
            return [f"{indent}if (laws::spent()) return {nothing};"] if self.burns else []
        lines = [f"{indent}if ({self.test(node.test)}) {{"]
        lines += self.block(node.body, indent + "  ")
        orelse = self.block(node.orelse, indent + "  ")
        if not orelse:
            return [*lines, f"{indent}}}"]
        if len(node.orelse) == 1 and orelse[0].startswith(f"{indent}  if ("):
            again = [line[2:] for line in orelse]
            return [*lines, f"{indent}}} else {again[0].lstrip()}", *again[1:]]
        return [*lines, f"{indent}}} else {{", *orelse, f"{indent}}}"]

    def _for(self, node: ast.For, indent: str) -> list[str]:
        assert isinstance(node.target, ast.Name)
        assert isinstance(node.iter, ast.Call)
        numbers = [ast.literal_eval(a) for a in node.iter.args]
        start, stop, step = (0, numbers[0], 1) if len(numbers) == 1 else (*numbers, 1)[:3]
        kind = "int16_t" if all(abs(n) < 2**15 - abs(step) for n in (start, stop)) else "int64_t"
        count = mangled(node.target.id.removeprefix("_"))
        sign = "<" if step > 0 else ">"
        head = f"for ({kind} {count} = {start}; {count} {sign} {stop}; {count} += {step}) {{"
        return [f"{indent}{head}", *self.block(node.body, indent + "  "), f"{indent}}}"]


def kind_of_result(results: list[bool]) -> str:
    """Return the type of what a function gives back, by which of it is small."""
    kinds = ["int8_t" if small else "float" for small in results]
    return kinds[0] if len(kinds) == 1 else f"laws::Results<{', '.join(kinds)}>"


def result(words: list[str], results: list[bool]) -> str:
    """Return the words of a result of that type."""
    if len(words) == 1:
        return words[0]
    given = [
        f"int8_t({w})" if small and not w.isalnum() else w for w, small in zip(words, results, strict=True)
    ]
    return f"{kind_of_result(results)}{{{', '.join(given)}}}"


def _targets(statement: ast.stmt) -> set[str]:
    """Return the names that a statement sets as a whole, so that it can declare them."""
    if not isinstance(statement, ast.Assign):
        return set()
    target = statement.targets[0]
    targets = target.elts if isinstance(target, ast.Tuple) else [target]
    read = {n.id for n in ast.walk(statement.value) if isinstance(n, ast.Name)}
    return {t.id for t in targets if isinstance(t, ast.Name)} - read


def _independent(targets: list[ast.expr], values: list[ast.expr]) -> bool:
    set_before = [ast.dump(t).replace("Store()", "Load()") for t in targets]
    for i, value in enumerate(values):
        read = {ast.dump(n) for n in ast.walk(value)}
        varies = any(
            isinstance(n, ast.Subscript) and not isinstance(n.slice, ast.Constant) for n in ast.walk(value)
        )
        if varies or any(one in read for one in set_before[:i]):
            return False
    return all(not isinstance(t, ast.Subscript) or isinstance(t.slice, ast.Constant) for t in targets)


def _is_burn(node: ast.If) -> bool:
    return (
        isinstance(node.test, ast.Call)
        and isinstance(node.test.func, ast.Name)
        and node.test.func.id == "_spent"
    )


def watched(tree: ast.FunctionDef) -> bool:
    """Return whether anything in a function can be a fault besides a force that is no number."""
    calls = (n.func.id for n in ast.walk(tree) if isinstance(n, ast.Call) and isinstance(n.func, ast.Name))
    return any(name in ("_divisor", "_index") for name in calls)

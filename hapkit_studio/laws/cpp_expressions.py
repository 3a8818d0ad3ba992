"""Writes the expressions of a rewritten law in C++, in single precision.

What soft floating point does dearly is written cheaper where the value stays: a product with a power of two
or with a sign, a division by what seldom changes, the sine of turns.
"""

import ast
from typing import NamedTuple

from hapkit_studio.laws import cpp_kinds as kinds
from hapkit_studio.laws.cpp_cheap import AND, ATOM, CHOICE, OR, PRODUCT, SUM, UNARY, Cheap, Text, calls
from hapkit_studio.laws.cpp_kept import arguments, is_name
from hapkit_studio.laws.cpp_program import REMEMBERED, Routine
from hapkit_studio.laws.cpp_small import Small
from hapkit_studio.laws.cpp_taken import taken_over
from hapkit_studio.laws.cpp_words import constant_name, mangled, number
from hapkit_studio.laws.helpers import PREFIX

_BINARY = {ast.Add: ("+", SUM), ast.Sub: ("-", SUM), ast.Mult: ("*", PRODUCT), ast.Div: ("/", PRODUCT)}
_PLAIN = {"_divisor": "laws::divisor", "abs": "fast::magnitude"}
_TWO = {"min": "fast::least", "max": "fast::most"}


class Places(NamedTuple):
    """What a law's parameters and states are called where they are indexed."""

    parameters: tuple[str, ...] = ()
    states: tuple[str, ...] = ()


class Expressions(Cheap):
    """Writes the expressions of one function."""

    def __init__(self, routine: Routine, routines: dict[str, Routine], places: Places, small: Small):
        self.routine, self.routines, self.places, self.small = routine, routines, places, small
        self.kept, self.own = small.kept, small.kept.get(routine.name, set())
        self.truths, self.signs = kinds.truths(routine.tree), kinds.signs(routine.tree)
        self.inverses: list[str] = []
        self.taken = taken_over(routine, routines, self.kept)
        self.crowded = _crowded(routine.tree)

    @staticmethod
    def word(name: str) -> str:
        """Return a local name."""
        return mangled(name.removeprefix("_"))

    def value(self, node: ast.expr, level: int = 0) -> str:
        """Return an expression as a number, in parentheses where it binds less than wanted."""
        text = self._value(node)
        return f"({text.words})" if text.level < level else text.words

    def test(self, node: ast.expr, level: int = 0) -> str:
        """Return an expression as a condition."""
        if isinstance(node, ast.BoolOp):
            word, own = ("&&", AND) if isinstance(node.op, ast.And) else ("||", OR)
            # each side in parentheses where it mixes && and ||, as compilers want it
            words = f" {word} ".join(self.test(v, AND + 1) for v in node.values)
            return f"({words})" if own < level else words
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return f"!{self.test(node.operand, ATOM)}"
        if kinds.is_truth(node, self.truths):
            return self.value(node, level)
        if isinstance(node, ast.Name) and self.small.holds(node, self.routine):
            return self.value(node, level)
        return f"!fast::is_zero({self.value(node)})"

    def _value(self, node: ast.expr) -> Text:
        match node:
            case ast.Constant():
                value = node.value
                if isinstance(value, bool):
                    return Text("true" if value else "false", ATOM)
                assert isinstance(value, float)
                return Text(number(value), UNARY if str(value)[0] == "-" else ATOM)
            case ast.Name():
                return Text(kept_name(node.id) if node.id in self.own else self.word(node.id), ATOM)
            case ast.Subscript():
                return self._place(node)
            case ast.UnaryOp(op=ast.USub()):
                return Text(f"-{self.value(node.operand, ATOM)}", UNARY)
            case ast.UnaryOp(op=ast.UAdd()):
                return self._value(node.operand)
            case ast.BoolOp():
                return self._logic(node)
            case ast.UnaryOp():
                return Text(self.test(node), UNARY)
            case ast.IfExp():
                test, body = self.test(node.test, CHOICE + 1), self.value(node.body, CHOICE + 1)
                return Text(f"{test} ? {body} : {self.value(node.orelse, CHOICE)}", CHOICE)
            case ast.Compare():
                return self._compare(node)
            case ast.BinOp():
                return self._arithmetic(node)
            case ast.Call():
                return self._call(node)
        raise AssertionError(ast.dump(node))

    def whole(self, node: ast.expr, level: int = 0) -> str:
        """Return a small whole number as one."""
        match node:
            case ast.Constant():
                assert isinstance(node.value, float)
                text = Text(f"{node.value:.0f}".replace("-0", "0"), UNARY if node.value < 0.0 else ATOM)
            case ast.UnaryOp():
                text = Text(f"-{self.whole(node.operand, ATOM)}", UNARY)
            case ast.IfExp():
                test, body = self.test(node.test, CHOICE + 1), self.whole(node.body, CHOICE + 1)
                text = Text(f"{test} ? {body} : {self.whole(node.orelse, CHOICE)}", CHOICE)
            case ast.Subscript():
                text = Text(f"laws::option({self.value(node)})", ATOM)
            case _:
                text = self._value(node)
        return f"({text.words})" if text.level < level else text.words

    def suited(self, node: ast.expr, small: bool) -> str:
        """Return an expression as what takes it holds it."""
        return self.whole(node) if small else self.value(node)

    def _logic(self, node: ast.BoolOp) -> Text:
        """Return `a and b` as Python has it: one of its sides."""
        if kinds.is_truth(node, self.truths):
            return Text(self.test(node), AND if isinstance(node.op, ast.And) else OR)
        first, *rest = node.values
        other = rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
        sides = (other, first) if isinstance(node.op, ast.And) else (first, other)
        return self._value(ast.IfExp(first, *sides))

    def _place(self, node: ast.Subscript) -> Text:
        assert isinstance(node.value, ast.Name)
        place = node.slice
        if isinstance(place, ast.Constant):
            return Text(f"{node.value.id}[{self._named(node.value.id, place.value)}]", ATOM)
        assert isinstance(place, ast.BinOp)
        assert isinstance(place.left, ast.Constant)
        assert isinstance(place.right, ast.Call)
        index, size = place.right.args[:2]
        assert isinstance(size, ast.Constant)
        name = self._named("s", place.left.value)
        return Text(f"s[{name} + laws::index({self.value(index)}, {size.value!r})]", ATOM)

    def _named(self, array: str, place: object) -> str:
        assert isinstance(place, int)
        return (self.places.parameters if array == "p" else self.places.states)[place]

    def _compare(self, node: ast.Compare) -> Text:
        sides = [node.left, *node.comparators]
        parts = []
        for left, op, right in zip(sides, node.ops, sides[1:], strict=False):
            parts.append(self._compared(left, op, right))
        return parts[0] if len(parts) == 1 else Text(" && ".join(p.words for p in parts), AND)

    def _arithmetic(self, node: ast.BinOp) -> Text:
        if isinstance(node.op, ast.Mult):
            for factor, other in ((node.left, node.right), (node.right, node.left)):
                cheap = self._product(factor, other)
                if cheap:
                    return cheap
        if isinstance(node.op, ast.Div):
            return self._quotient(node)
        if type(node.op) not in _BINARY:
            return self._rare(node)
        word, level = _BINARY[type(node.op)]
        right = self.value(node.right, level + 1)
        return Text(f"{self.value(node.left, level)} {word} {right}", level)

    def _rare(self, node: ast.BinOp) -> Text:
        left, right = node.left, node.right
        if isinstance(node.op, ast.Pow):
            power = right.value if isinstance(right, ast.Constant) else None
            if power in (2.0, 3.0, 4.0):
                return Text(f"fast::power<{power:.0f}>({self.value(left)})", ATOM)
            return Text(f"powf({self.value(left)}, {self.value(right)})", ATOM)
        name = "fast::floor_division" if isinstance(node.op, ast.FloorDiv) else "fast::modulo"
        return Text(f"{name}({self.value(left)}, {self.value(right)})", ATOM)

    def _call(self, node: ast.Call) -> Text:
        if isinstance(node.func, ast.Attribute):
            return self._math(node.func, node.args)
        assert isinstance(node.func, ast.Name)
        name = node.func.id
        if name in self.routines:
            return Text(self.helper_call(node), ATOM)
        if name in _TWO:
            words = self.value(node.args[0])
            for other in node.args[1:]:
                words = f"{_TWO[name]}({words}, {self.value(other)})"
            return Text(words, ATOM)
        return Text(f"{_PLAIN[name]}({self.value(node.args[0])})", ATOM)

    def helper_call(self, node: ast.Call) -> str:
        """Return the call of a helper."""
        assert isinstance(node.func, ast.Name)
        called = self.routines[node.func.id]
        kept, given, settings = self.kept.get(called.name, set()), [], []
        for name, actual in zip(arguments(called), node.args, strict=False):
            if name not in kept:
                given.append(self.suited(actual, name in self.small.names.get(called.name, ())))
            elif name not in self.taken and not (is_name(actual, name) and name in self.own):
                settings.append((f"numbers::{kept_name(name)}", self.value(actual)))
        if called.by_hand in REMEMBERED and self.routine.persons:
            settings.append((REMEMBERED[called.by_hand], "NAN"))
        return _call(called.word, given, settings, id(node) in self.crowded)

    def take_over(self) -> list[str]:
        """Return the lines that set what parameters alone decide, where they may have changed."""
        if not self.taken:
            return []
        lines = [f"    numbers::{kept_name(name)} = {self.value(v)};" for name, v in self.taken.items()]
        return ["  if (!laws::current) {", "    laws::current = true;", *lines, "  }"]

    def _math(self, func: ast.Attribute, args: list[ast.expr]) -> Text:
        assert isinstance(func.value, ast.Name)
        name = {"fabs": "magnitude"}.get(func.attr, func.attr)
        if name in ("sin", "cos"):
            turns = kinds.without_turn(args[0])
            if turns is not None:
                return Text(f"fast::{name}_of_turns({self.value(turns)})", ATOM)
        square = kinds.scaled_square(args[0]) if name == "exp" else None
        if square:
            return Text(f"fast::exp_of_square({number(square[0])}, {self.value(square[1])})", ATOM)
        if name == "fmod" and calls(args[1], "_divisor"):
            return Text(f"fast::remainder({self.value(args[0])}, {self.value(args[1])})", ATOM)
        name = {"fmod": "remainder", "pow": "power_of", "copysign": "signed_as"}.get(name, name)
        return Text(f"fast::{name}({', '.join(self.value(a) for a in args)})", ATOM)


def _call(name: str, given: list[str], settings: list[tuple[str, str]], crowded: bool) -> str:
    """Return a call after its kept arguments are set; all in a function where other calls are about."""
    if not settings:
        return f"{name}({', '.join(given)})"
    if not crowded:
        words = ", ".join(f"{place} = {value}" for place, value in settings)
        return f"({words}, {name}({', '.join(given)}))"
    lines = [f"const float a{i} = {value}" for i, value in enumerate([v for _, v in settings] + given)]
    lines += [f"{place} = a{i}" for i, (place, _) in enumerate(settings)]
    rest = ", ".join(f"a{len(settings) + i}" for i in range(len(given)))
    return f"[&] {{ {'; '.join(lines)}; return {name}({rest}); }}()"


def kept_name(name: str) -> str:
    """Return where an argument waits that is not handed on."""
    return f"with_{mangled(name)}"


def _crowded(tree: ast.FunctionDef) -> set[int]:
    """Return the identities of the helper calls that stand in one expression with others.

    C++ may reckon two sides of a sum in any order, and one of them between the parts of the other.
    """
    found: set[int] = set()
    for statement in (n for n in ast.walk(tree) if isinstance(n, ast.stmt)):
        for expression in (n for n in ast.iter_child_nodes(statement) if isinstance(n, ast.expr)):
            calls = [id(n) for n in ast.walk(expression) if _is_helper_call(n)]
            found.update(calls if len(calls) > 1 else ())
    return found


def _is_helper_call(node: ast.AST) -> bool:
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
        return False
    return node.func.id.startswith(PREFIX)


def parameter_names(keys: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of a law's parameters as indices."""
    return tuple(constant_name(key) for key in keys)

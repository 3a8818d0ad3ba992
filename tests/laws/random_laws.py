"""Random laws of the whole law language; a seed determines each of them."""

import random
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio.laws.law import Law, _Values
from hapkit_studio.parameters import AnyParameter, Choice, Parameter
from tests.laws.law_files import written

PARAMETERS: tuple[AnyParameter, ...] = (
    Parameter("a", "A", "", 1.5, -4.0, 4.0),
    Parameter("b", "B", "", 0.3, 0.01, 2.0),
    Parameter("c", "C", "", -2.0, -50.0, 50.0),
    Choice("mode", "Mode", ("off", "soft", "hard")),
    Choice("side", "Side", ("left", "right")),
)
STATE = {"count": 0.0, "sum": 0.5, "table": (1.0, -2.0, 0.25), "last": 0.0, "pair": (0.0, 3.0)}
SINGLE, TABLES = ("count", "sum", "last"), {"table": 3, "pair": 2}
HEAD = """\
import math
from math import cos, hypot

from hapkit_studio.laws import law

GAIN = 2.5
STEPS = 3
SMALL = 0.125
CURVE = (0.5, -1.25, 0.0, 2.0, -0.75)


"""
CURVE = 5  # length of the table
TURNS = {"STEPS": 3, "len(CURVE) - 2": 3}
# functions that accept any argument; for other functions, expressions that keep the argument in the domain
ANY = ("sin", "cos", "tan", "atan", "tanh", "fabs", "floor", "ceil", "trunc", "radians", "degrees")
KEPT_IN = {
    "log10": "(abs({}) + 0.25)", "sqrt": "abs({})",
    "asin": "max(-1.0, min(1.0, {}))", "acos": "min(1.0, max({}, -1.0))",
    "exp": "min(3.0, {})", "expm1": "min(2.0, {})", "log": "(abs({}) + 0.25)", "log1p": "abs({})",
    "sinh": "max(-3.0, min(3.0, {}))", "cosh": "max(-2.0, min(2.0, {}))",
}  # fmt: skip
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
ROWS = 60


@dataclass
class _Helper:
    name: str
    arguments: int
    results: int
    defaults: int = 0


class _Writer:
    """A writer of the functions of one law; ``names`` are the variables that can be read at this position."""

    def __init__(self, seed: int):
        self.random = random.Random(seed)
        self.helpers: list[_Helper] = []
        self.inside_law = False
        self.names: list[str] = []
        self.lines: list[str] = []
        self.indent = 1
        self.loops = 0
        self.turns = 1  # product of the iterations of all enclosing loops
        self.made = 0

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def pick(self, options):
        return self.random.choice(list(options))

    def put(self, text: str) -> None:
        self.lines.append("    " * self.indent + text)

    # --- write values
    def number(self) -> str:
        rough = f"{self.random.uniform(-3.0, 3.0):.3g}"
        whole = str(self.random.randint(-4, 5))
        exact = self.pick(("0.5", "0.25", "-1.5", "2.0", "1e-3", "1.0", "0.0", "-1.0"))
        return self.pick((rough, rough, whole, exact, "GAIN", "STEPS", "SMALL", "math.pi", "math.e"))

    def leaf(self) -> str:
        options = [self.number(), self.pick(self.names), self.pick(self.names)]
        if self.inside_law:
            options += [self.pick(("x", "v", "x", "v", "dt")), self.pick(("p.a", "p.b", "p.c"))]
            options += [f"s.{self.pick(SINGLE)}", self.element()]
        return f"CURVE[{self.index(CURVE)}]" if self.chance(0.08) else self.pick(options)

    def element(self) -> str:
        name = self.pick(TABLES)
        return f"s.{name}[{self.index(TABLES[name])}]"

    def index(self, size: int) -> str:
        index = self.pick(
            (
                str(self.random.randrange(size)),
                f"{'s.count' if self.inside_law else self.pick(self.names)} % {size}",
                f"int(abs({self.pick(self.names)})) % {size}",
                f"min({size - 1}, max(0, {self.pick(self.names)}))",
                f"{size - 1} - int(min({size - 0.5}, abs(10.0 * {self.pick(self.names)})))",
            )
        )
        if self.chance(0.04):
            index = self.pick((f"int({self.pick(self.names)})", f"{self.pick(self.names)} / 8.0"))
        return index

    def value(self, depth: int) -> str:
        """Return an expression of at most ``depth`` levels."""
        if depth <= 0 or self.chance(0.12):
            return self.leaf()
        # avoid expensive operations inside loops
        kind = self.random.randrange(8 if self.turns > 1 and self.chance(0.6) else 20)
        one, other = (lambda: self.value(depth - 1)), (lambda: self.value(depth - 2))
        if kind < 8:
            return f"({one()} {self.pick('+-*+-*')} {other()})"
        if kind < 10:
            return self.quotient(one(), other())
        if kind == 10:
            return f"-{one()}" if self.chance(0.8) else f"+{one()}"
        if kind < 13:
            return self.function(one(), other())
        if kind == 13:
            return f"({one()} if {self.test(depth - 1)} else {other()})"
        if kind == 14:
            third = f", {self.leaf()}" if self.chance(0.3) else ""
            return f"{self.pick(('min', 'max'))}({one()}, {other()}{third})"
        if kind == 15:
            return f"{self.pick(('abs', 'int', 'float'))}({one()})"
        if kind == 17 and self.chance(0.3):
            return f"({one()} {self.pick(('and', 'or'))} {other()})"
        if kind == 16:
            return self.power(one())
        helper = self.helper(1)
        return helper if helper else f"({one()} - {other()})"

    def quotient(self, top: str, bottom: str) -> str:
        operator = self.pick(("/", "/", "//", "%", "fmod"))
        bottom = self.pick(
            (bottom, f"(1.5 + abs({bottom}))", f"(1.5 + abs({bottom}))", "0.7", "-4.0", "GAIN")
        )
        if self.inside_law and self.chance(0.2):
            bottom = "p.b"
        if self.inside_law and self.chance(0.05):
            bottom = self.pick(("(s.count - 5.0)", "(s.last * 0.0)", "(x - s.last)"))
        return f"math.fmod({top}, {bottom})" if operator == "fmod" else f"({top} {operator} {bottom})"

    def function(self, one: str, other: str) -> str:
        if self.chance(0.25):
            name = self.pick(("atan2", "hypot", "copysign", "pow"))
            if name == "pow":
                return f"math.pow(abs({one}) + 0.5, max(-2.0, min(2.0, {other})))"
            if name == "copysign":
                other = f"({other} or {self.pick(('1.0', '-1.0'))})"
            return f"math.{name}({one}, {other})" if self.chance(0.8) else f"hypot({one}, {other})"
        if self.chance(0.45):
            name = self.pick(ANY)
            return f"math.{name}({one})" if self.chance(0.8) else f"cos({one})"
        name = self.pick(KEPT_IN)
        bare = self.chance(0.08)
        return f"math.{name}({one if bare else KEPT_IN[name].format(one)})"

    def power(self, base: str) -> str:
        if self.chance(0.7):
            return f"({base} ** {self.pick(('2', '3', '2.0', '1', '0', '4'))})"
        exponent = self.pick(("-1", "0.5", "-2", "1.5", "SMALL", "p.b" if self.inside_law else "0.3"))
        return f"((0.5 + abs({base})) ** {exponent})"

    def helper(self, results: int) -> str:
        options = [h for h in self.helpers if h.results == results]
        if not options or self.turns > 2:
            return ""
        one = self.pick(options)
        given = [self.value(1) for _ in range(one.arguments - self.random.randint(0, one.defaults))]
        if self.inside_law and self.chance(0.2):
            given[0] = "p.mode"
        return f"{one.name}({', '.join(given)})"

    def test(self, depth: int) -> str:
        kind = self.random.randrange(12)
        if kind == 0 and depth > 0:
            return f"not {self.test(depth - 1)}" if self.chance(0.5) else f"not ({self.test(depth - 1)})"
        if kind < 4 and depth > 0:
            word = self.pick(("and", "or"))
            return f"({self.test(depth - 1)} {word} {self.test(depth - 1)})"
        if kind == 4:
            low, high = sorted((self.random.uniform(-2, 2), self.random.uniform(-2, 2)))
            return f"{low:.3g} {self.pick(('<', '<='))} {self.value(1)} {self.pick(('<', '<='))} {high:.3g}"
        if kind < 7 and self.inside_law:
            key, option = self.pick((("mode", "off"), ("mode", "soft"), ("mode", "hard"), ("side", "left")))
            return f"p.{key} {self.pick(('==', '!='))} {option!r}"
        operator = self.pick(COMPARISONS[:4] * 3 + COMPARISONS)
        return f"{self.value(1)} {operator} {self.value(0) if self.chance(0.5) else self.number()}"

    # --- write statements
    def target(self) -> str:
        if self.inside_law and self.chance(0.4):
            return f"s.{self.pick(SINGLE)}" if self.chance(0.5) else self.element()
        return self.pick(self.names)

    def new_name(self) -> str:
        self.made += 1
        return f"w{self.made}"

    def block(self, count: int, leave: str) -> None:
        """Write some statements; names assigned in them are not used afterwards."""
        names, before = list(self.names), len(self.lines)
        self.indent += 1
        for _ in range(count):
            self.statement(leave)
        if len(self.lines) == before:
            self.put("pass")
        self.indent -= 1
        self.names = names

    def statement(self, leave: str) -> None:
        kind = self.random.randrange(20)
        if kind < 7:
            value = self.value(3)
            if self.chance(0.3):
                name = self.new_name()
                self.put(f"{name} = {value}")
                self.names.append(name)
            else:
                self.put(f"{self.target()} = {value}")
        elif kind < 9:
            operator = self.pick(("+", "-", "*", "/", "+", "//", "%", "**"))
            if operator == "**":
                value = "2"
            else:
                value = f"(2.0 + abs({self.value(1)}))" if operator in "//%" else self.value(2)
            self.put(f"{self.target()} {operator}= {value}")
        elif kind < 11:
            self.several()
        elif kind == 11:
            self.put(f"{self.pick(self.names)} = {self.test(1)}")
        elif kind < 16:
            self.branch(leave)
        elif kind < 18 and self.indent < 5:
            self.loop(leave)
        elif self.indent > 1 and self.chance(0.15):
            self.give_back(leave)
        elif self.inside_law:
            self.put(
                self.pick(
                    ("s.count += 1.0", "s.sum = 0.9 * s.sum + x", "s.last = x", "s.count = s.count % 7")
                )
            )

    def several(self) -> None:
        first, second = self.random.sample(self.names, 2)
        kind = self.random.randrange(4)
        call = self.helper(2)
        if kind == 0:
            self.put(f"{first}, {second} = {second}, {first}")
        elif kind == 1 and self.inside_law:
            self.put(f"s.table[0], s.table[2], {first} = s.table[2], {self.value(1)}, s.table[0]")
        elif kind == 2 and call:
            self.put(f"{first}, {self.target() if self.inside_law else second} = {call}")
        else:
            self.put(f"{first}, {second} = {self.value(2)}, {self.value(2)}")

    def branch(self, leave: str) -> None:
        self.put(f"if {self.test(2)}:")
        self.block(self.random.randint(1, 2), leave)
        while self.chance(0.3):
            self.put(f"elif {self.test(1)}:")
            self.block(1, leave)
        if self.chance(0.5):
            self.put("else:")
            self.block(self.random.randint(1, 2), leave)

    def loop(self, leave: str) -> None:
        turns = self.pick((*TURNS, "3", "2", "1, 4", "5, 0, -2", "0, -3, -1", "-1, 2", "4", "2, 2"))
        size = TURNS.get(turns) or len(range(*map(int, turns.split(","))))
        if self.turns * size > 6:
            return
        counter = self.new_name() if self.chance(0.7) else self.pick(self.names)
        self.put(f"for {counter} in range({turns}):")
        names = list(self.names)
        self.names.append(counter)
        self.loops += 1
        outside, self.turns = self.turns, self.turns * max(1, size)
        self.block(self.random.randint(1, 2), leave)
        if self.chance(0.5):
            self.indent += 1
            self.put(f"if {self.test(1)}:")
            self.put(f"    {self.pick(('break', 'continue'))}")
            self.statement(leave)
            self.indent -= 1
        self.turns = outside
        self.loops -= 1
        self.names = names

    def give_back(self, leave: str) -> None:
        values = ", ".join(self.value(1) for _ in range(int(leave)))
        self.put(f"if {self.test(1)}:")
        self.put(f"    return {values}")

    # --- write functions
    def write_helper(self, number: int) -> None:
        one = _Helper(f"helper_{number}", self.random.randint(1, 3), self.random.randint(1, 2))
        self.names = [f"q{i}" for i in range(one.arguments)]
        one.defaults = int(one.arguments > 1 and self.chance(0.3))
        default = f"={self.pick(('SMALL', '2', '-0.75'))}" * one.defaults
        self.put_head(f"def {one.name}({', '.join(self.names)}{default}):")
        for _ in range(2 - len(self.names) + 1):
            name = self.new_name()
            self.put(f"{name} = {self.value(1)}")
            self.names.append(name)
        for _ in range(self.random.randint(1, 3)):
            self.statement(str(one.results))
        self.put(f"return {', '.join(self.value(2) for _ in range(one.results))}")
        self.helpers.append(one)

    def put_head(self, text: str) -> None:
        self.lines += ["", "", text] if self.lines else [text]

    def write_law(self) -> None:
        self.inside_law = True
        self.names = ["x", "v", "dt"]
        self.put_head(f"@law(state={STATE!r})")
        self.lines.append("def force(p, s, x, v, dt):")
        first = ["f", "g", "h"]
        for name in first:
            self.put(f"{name} = {self.value(2)}")
        self.names = list(first)
        if self.chance(0.15):
            self.put("f = math.inf")
            self.put(f"f = min(f, {self.value(2)})")
        for _ in range(self.random.randint(3, 7)):
            self.statement("1")
        self.put(f"return {self.value(3)}")


def text(seed: int) -> str:
    """Return the text of the file of a random law."""
    writer = _Writer(seed)
    for number in range(writer.random.randint(0, 3)):
        writer.write_helper(number)
    writer.write_law()
    return HEAD + "\n".join(writer.lines) + "\n"


def law(folder: Path, seed: int) -> Law:
    """Return a random law with its file in a folder, or raise LawError if it violates the language."""
    made = written(folder / f"random_{seed}.py", text(seed))
    made.CURVE = _Values(made.CURVE)  # plain Python counts negative indices from the end
    made.force.bind(PARAMETERS)
    return made.force


def settings(seed: int) -> dict[str, float]:
    """Return random settings of a random law."""
    found = random.Random(seed + 0.5)
    numbers = {p.key: p.default for p in PARAMETERS}
    for p in PARAMETERS:
        if isinstance(p, Choice):
            numbers[p.key] = float(found.randrange(len(p.options)))
        elif found.random() < 0.8:
            numbers[p.key] = round(found.uniform(p.low, p.high), 4)
    return numbers


def rows(seed: int, count: int = ROWS) -> np.ndarray:
    """Return rows (n, 2) of position and velocity, with few or many digits, sometimes at rest."""
    found = np.random.default_rng(seed)
    x = np.cumsum(found.normal(0.0, 0.3, count))
    v = found.normal(0.0, 1.0, count)
    short = found.random(count) < 0.5
    x[short], v[short] = np.round(x[short] * 16.0) / 16.0, np.round(v[short] * 4.0) / 4.0
    v[found.random(count) < 0.15] = 0.0
    held = np.flatnonzero(found.random(count) < 0.2)
    x[held] = x[np.maximum(held - 1, 0)]
    return np.stack([x, v], axis=1)

"""Translates a law into C for a sketch, from the syntax tree that ``readable`` returns."""

import math
import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hapkit_studio.laws import tree as t
from hapkit_studio.laws.law import Law
from hapkit_studio.laws.readable import specialise
from hapkit_studio.laws.translate import TABLE_PREFIX, checked
from hapkit_studio.parameters import Choice

# Reserved words of C++, and names of the Arduino core, some of which are macros that ignore scopes.
_RESERVED = """
alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const constexpr
continue decltype default delete do double dynamic_cast else enum explicit export extern false final float
for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq
override private protected public register reinterpret_cast return short signed sizeof static static_assert
static_cast struct switch template this thread_local throw true try typedef typeid typename union unsigned
using virtual void volatile wchar_t while xor xor_eq
abs bit bitClear bitRead bitSet bitWrite boolean byte cli constrain degrees highByte interrupts lowByte map
max min noInterrupts radians random round sei sq word main setup loop assert errno
j0 j1 jn y0 y1 yn sin cos tan exp log pow sqrt floor ceil fabs gamma
p s law stopped smaller larger modulo floorDivide divisor index entry expMinusOne logOnePlus
"""
_TAKEN = frozenset(_RESERVED.split())
WIDTH, _SHORT = 105, 80  # width of a line; width up to which two declarations share a line
_LEVELS = {"?": 1, "or": 2, "and": 3, "==": 4, "!=": 4, "<": 5, "<=": 5, ">": 5, ">=": 5}
_SUM, _PRODUCT, _SIGN, _ATOM = 6, 7, 8, 9
# names that are different in C, and names of the sketch's helper functions
_NAMES = {"abs": "fabsf", "**": "powf", "min": "smaller", "max": "larger", "//": "floorDivide", "%": "modulo"}
_NAMES |= {"expm1": "expMinusOne", "log1p": "logOnePlus"}
_HELPERS = frozenset((*_NAMES.values(), "divisor", "index", "entry")) - {"fabsf", "powf"}


@dataclass(frozen=True)
class Source:
    """A law in C: its text, the text of its call, the helpers that it needs, and its parameters' indices."""

    text: str
    call: str
    helpers: frozenset[str]
    parameters: frozenset[int]


def translate(law: Law, values: Sequence[float]) -> Source:
    """Return a law in C, in which the choices among its parameters are fixed.

    Raise LawError if the law cannot be translated.
    """
    trees = checked(law.function, law.parameters, law.state)
    choices = frozenset(i for i, p in enumerate(law.parameters) if isinstance(p, Choice))
    made = specialise(trees, values, choices)
    names = {f"p[{i}]": f"p.{mangled(p.key)}" for i, p in enumerate(law.parameters)}
    for i, state in enumerate(law.state_names):
        key, bracket, place = state.partition("[")
        names[f"s[{i}]"] = f"s.{mangled(key)}{bracket}{place}"
    functions = {f.name: f for f in made.functions}
    used = {n.name for n in t.walk([made.body, [f.body for f in made.functions]]) if isinstance(n, t.Var)}
    given = [n for n in ("x", "v") if n in used]
    writer = _Writer(names, functions, {r.line: f"{r.text}." for r in law.remarks})
    sizes = sorted({len(f.results) for f in made.functions} - {1})
    pieces = [f"struct Values{n} {{ float {', '.join('abcdefghijklmnop'[:n])}; }};" for n in sizes]
    text = ["\n".join(["// The results of functions that return several values.", *pieces])] if pieces else []
    for function in made.functions:
        result = "float" if len(function.results) == 1 else f"Values{len(function.results)}"
        about = trees.documents[function.key]
        text.append(writer.function(about, result, function.name, function.parameters, function.body.body))
    about = law.function.__doc__ or "Return the force in N, positive to the right."
    text.append(writer.function(about, "float", "force", given, made.body))
    if writer.tables:
        text.insert(0, "\n\n".join(_table(name, made.tables[name]) for name in writer.tables))
    if writer.states:
        text.insert(0, _memory(law, writer.states))
    places = frozenset(int(n[2:-1]) for n in used if n.startswith("p["))
    return Source("\n\n".join(text), f"law::force({', '.join(given)})", frozenset(writer.helpers), places)


def _memory(law: Law, used: set[str]) -> str:
    rows = []
    for key, value in law.state.items():
        name = mangled(key)
        if isinstance(value, tuple) and any(u.startswith(f"s.{name}[") for u in used):
            rows.append(f"{name}[{len(value)}] = {{{', '.join(map(number, value))}}}")
        elif not isinstance(value, tuple) and f"s.{name}" in used:
            rows.append(f"{name} = {number(value)}")
    head = "// The law's memory from one tick to the next."
    return "\n".join([head, "struct {", *wrapped(f"  float {', '.join(rows)};"), "} s;"])


def _table(name: str, numbers: Sequence[float]) -> str:
    rows = textwrap.wrap(
        ", ".join(map(number, numbers)), WIDTH, initial_indent="    ", subsequent_indent="    "
    )
    name = mangled(name.removeprefix(TABLE_PREFIX))
    return "\n".join([f"const float {name}[{len(numbers)}] PROGMEM = {{", *rows, "};"])


class _Writer:
    """Writes functions in C, and records the helpers, states and tables that they use."""

    def __init__(
        self, names: Mapping[str, str], functions: Mapping[str, t.Function], remarks: Mapping[int, str]
    ):
        self.names, self.functions = names, functions
        self.remarks = dict(remarks)  # by source line; a remark is removed when it is written
        self.helpers: set[str] = set()
        self.states: set[str] = set()
        self.tables: dict[str, None] = {}
        self.sets: Counter[str] = Counter()  # number of assignments to each name
        self.read: set[str] = set()  # names that are read
        self.truths: set[str] = set()  # names of Boolean variables

    def function(
        self, about: str | None, result: str, name: str, given: Sequence[str], body: list[t.Statement]
    ) -> str:
        sets = [n for n in t.walk(body) if isinstance(n, t.Assign)]
        self.sets = Counter(n.to for n in sets)
        self.read = {n.name for n in t.walk(body) if isinstance(n, t.Var)}
        once = {n for n, times in Counter([*given, *self.sets.elements()]).items() if times == 1}
        self.truths = {n.to for n in sets if n.to in once and t.is_truth(n.value)}
        head = f"{result} {mangled(name)}({', '.join(f'float {mangled(n)}' for n in given)}) {{"
        lines = self.block(body, "  ", {*given, "dt"})
        whole = f"{head} {lines[0].lstrip()} }}"
        made = [whole] if len(lines) == 1 and len(whole) <= WIDTH else [head, *lines, "}"]
        return "\n".join([*comment(about), *(line for long in made for line in wrapped(long))])

    # --- statements
    def block(self, statements: Sequence[t.Statement], indent: str, outside: set[str]) -> list[str]:
        """Return the lines of statements; a name is declared at its first assignment or before a branch."""
        declared, lines = set(outside), []
        for i, s in enumerate(statements):
            behind = statements[i + 1 :]
            remark = comment(self.remarks.pop(s.line, None), WIDTH - len(indent))
            lines += [indent + line for line in remark]
            if isinstance(s, t.If | t.Loop):
                inner = dict.fromkeys(n.to for n in t.walk(s) if isinstance(n, t.Assign))
                names = [n for n in inner if self.is_new(n, declared) and _is_read(n, behind)]
                lines += [f"{indent}float {', '.join(map(mangled, names))};"] if names else []
                declared.update(names)
            if isinstance(s, t.Assign) and behind and _counter(behind[0]) == s.to:
                if self.is_new(s.to, declared) and _is_read(s.to, behind[1:]):
                    lines.append(f"{indent}float {mangled(s.to)};")
                    declared.add(s.to)
            elif isinstance(s, t.Loop):
                begin = statements[i - 1] if s.after else None
                lines += self.loop(s, begin, indent, declared)
            elif isinstance(s, t.If):
                lines += self.branch(s, indent, declared)
            else:
                line = f"{indent}{self.simple(s, declared)}"
                kind = next((k for k in ("const float ", "float ") if line.startswith(indent + k)), "")
                if kind and lines and lines[-1].startswith(indent + kind) and len(lines[-1] + line) < _SHORT:
                    line = f"{lines.pop()[:-1]}, {line.removeprefix(indent + kind)}"
                lines.append(line)
        return lines

    def is_new(self, name: str, declared: set[str]) -> bool:
        return name not in declared and name not in self.names and not name.startswith("@")

    def simple(self, s: t.Statement, declared: set[str]) -> str:
        match s:
            case t.Assign(to, t.Op("+" | "-" | "*" | "/" as op, (t.Var(same), value))) if to == same:
                return f"{self.place(to)} {op}= {self.text(value)};"
            case t.Assign(to, value) if to not in self.read and not to.startswith("s["):
                return f"(void)({self.text(value)});"  # the call is kept because it may stop the law
            case t.Assign(to, t.Select(test)) if to in self.truths:
                declared.add(to)
                return f"const bool {mangled(to)} = {self.test(test)[0]};"
            case t.Assign(to, value):
                kind = ""
                if self.is_new(to, declared):
                    declared.add(to)
                    kind = f"{'const ' if self.sets[to] == 1 else ''}{self.kind(value)} "
                return f"{kind}{self.place(to)} = {self.text(value)};"
            case t.SetAt(place, value):
                return f"{self.text(place)} = {self.text(value)};"
            case t.Return(value):
                return f"return {self.text(value)};"
            case t.Leave(_, moves):
                values = ", ".join(self.text(m.value) for m in moves)
                return f"return {values};" if len(moves) == 1 else f"return {{{values}}};"
            case t.Break():
                return "break;"
            case t.Continue():
                return "continue;"
        raise AssertionError(s)

    def kind(self, value: t.Expr) -> str:
        if isinstance(value, t.Op) and value.name[:-2] in self.functions:
            results = len(self.functions[value.name[:-2]].results)
            return "float" if results == 1 else f"Values{results}"
        return "float"

    def branch(self, s: t.If, indent: str, declared: set[str], short: bool = True) -> list[str]:
        test, then, other = (s.test, s.then, s.other) if s.then else (t.Not(s.test), s.other, s.then)
        head = f"{indent}if ({self.test(test)[0]})"
        lines, rest = (self.block(one, f"{indent}  ", declared) for one in (then, other))
        whole = f"{head} {lines[0].lstrip()}" if lines else ""
        if not rest:
            short = (
                short and len(lines) == 1 and len(whole) <= WIDTH and not isinstance(then[0], t.If | t.Loop)
            )
            return [whole] if short else [f"{head} {{", *lines, f"{indent}}}"]
        if len(other) == 1 and isinstance(other[0], t.If):
            rest = self.branch(other[0], indent, declared, False)
            return [f"{head} {{", *lines, f"{indent}}} else {rest[0].lstrip()}", *rest[1:]]
        return [f"{head} {{", *lines, f"{indent}}} else {{", *rest, f"{indent}}}"]

    def loop(self, s: t.Loop, begin: t.Statement | None, indent: str, declared: set[str]) -> list[str]:
        if begin is None:
            kind = "uint16_t" if s.times < 2**16 else "uint32_t"
            head = f"for ({kind} turn_ = 0; turn_ < {s.times}; turn_++)"
            return [f"{indent}{head} {{", *self.block(s.body, f"{indent}  ", declared), f"{indent}}}"]
        match begin, s.after:
            case t.Assign(counter, t.Num(first)), [t.Assign(_, t.Op("+", (_, t.Num(step))))]:
                kind = "float " if self.is_new(counter, declared) else ""
                name, sign = mangled(counter), "<" if step > 0.0 else ">"
                test = f"{name} {sign} {number(first + s.times * step)}"
                head = f"for ({kind}{name} = {number(first)}; {test}; {name} += {number(step)})"
                body = self.block(s.body, f"{indent}  ", declared | {counter})
                return [f"{indent}{head} {{", *body, f"{indent}}}"]
        raise AssertionError(s.after)

    # --- values
    def is_truth(self, value: t.Expr) -> bool:
        return isinstance(value, t.Var) and value.name in self.truths

    def place(self, name: str) -> str:
        found = self.names.get(name)
        if found is None:
            return "kPeriod" if name == "dt" else mangled(name)
        if name.startswith("s["):
            self.states.add(found)
        return found

    def text(self, value: t.Expr, level: int = 0) -> str:
        """Return an expression as text, in parentheses if its precedence is below ``level``."""
        code, own = self.value(value)
        return code if own >= level else f"({code})"

    def value(self, value: t.Expr) -> tuple[str, int]:
        """Return an expression as text, and its precedence."""
        match value:
            case t.Num():
                code = number(value.value)
                return code, _SIGN if code.startswith("-") else _ATOM
            case t.Var(name) if name in self.truths:
                return f"{mangled(name)} ? 1.0f : 0.0f", _LEVELS["?"]
            case t.Var(name):
                return self.place(name), _ATOM
            case t.At(index, start, size):
                self.helpers.add("index")
                name = self.place(f"s[{start}]").removesuffix("[0]")
                return f"{name}[index({self.text(index)}, {size})]", _ATOM
            case t.Entry(index, table, size):
                self.helpers.add("entry")
                self.tables[table] = None
                return (
                    f"entry({mangled(table.removeprefix(TABLE_PREFIX))}, {size}, {self.text(index)})",
                    _ATOM,
                )
            case t.Select(test, yes, no):
                one, level = self.test(test)
                code = one if level > _LEVELS["?"] else f"({one})"
                return f"{code} ? {self.text(yes, 2)} : {self.text(no, 2)}", _LEVELS["?"]
            case t.Op("+" | "-" as name, (left, right)):
                return f"{self.text(left, _SUM)} {name} {self.text(right, _PRODUCT)}", _SUM
            case t.Op("*" | "/" as name, (left, right)):
                return f"{self.text(left, _PRODUCT)} {name} {self.text(right, _SIGN)}", _PRODUCT
            case t.Op("neg", (operand,)):
                code = self.text(operand, _SIGN)
                return f"-({code})" if code.startswith("-") else f"-{code}", _SIGN
            case t.Op("**", (t.Var() as base, t.Num(value=2.0))):
                return f"{self.text(base)} * {self.text(base)}", _PRODUCT
            case t.Op(name, args) if name.startswith("."):
                return f"{self.text(args[0])}{name}", _ATOM
            case t.Op(name, args):
                return f"{self.called(name)}({', '.join(map(self.text, args))})", _ATOM
        raise AssertionError(value)

    def called(self, name: str) -> str:
        if name[:-2] in self.functions:
            return mangled(name[:-2])
        made = _NAMES.get(name, name.removesuffix("()") if name.endswith("()") else f"{name}f")
        self.helpers |= {made} & _HELPERS
        return made

    def test(self, test: t.Test) -> tuple[str, int]:
        match test:
            case t.Compare("!=", t.Var(name), t.Num(value=0.0)) if name in self.truths:
                return mangled(name), _ATOM
            case t.Compare(op, left, right):
                level = _LEVELS[op]
                return f"{self.text(left, level + 1)} {op} {self.text(right, level + 1)}", level
            case t.Logic(op, tests):
                level = _LEVELS[op]
                made = (self.test(one) for one in tests)
                sign = " && " if op == "and" else " || "
                return sign.join(w if own >= 4 or own == level else f"({w})" for w, own in made), level
            case t.Not(t.Compare("==" | "!=" as op, left, right)) if not self.is_truth(left):
                return self.test(t.Compare("!=" if op == "==" else "==", left, right))
            case t.Not(inner):
                code, level = self.test(inner)
                return f"!{code}" if level == _ATOM else f"!({code})", _SIGN
        raise AssertionError(test)


def _counter(s: t.Statement) -> str:
    """Return the name of a loop's counter; "" if the counter is unused."""
    after = s.after if isinstance(s, t.Loop) else []
    return after[0].to if after and isinstance(after[0], t.Assign) else ""


def _is_read(name: str, statements: Sequence[t.Statement]) -> bool:
    """Return True if statements read a name before they assign to it."""
    for s in statements:
        if any(n == t.Var(name) or (isinstance(n, t.Assign) and n.to == name) for n in t.walk(s)):
            return not isinstance(s, t.Assign) or t.Var(name) in t.walk(s.value)
    return False


# --- names and text
def mangled(name: str) -> str:
    """Return a Python name as a valid, unique C++ name."""
    plain = "".join(c if c.isascii() else f"_u{ord(c):x}" for c in name)
    taken = plain in _TAKEN or plain.endswith("_") or plain.upper() == plain
    return plain + "_" if taken else plain


def number(value: float) -> str:
    """Return a single-precision literal: INFINITY on overflow, 0 on underflow."""
    with np.errstate(over="ignore", under="ignore"):
        single = np.float32(value)
    if math.isnan(single):
        return "NAN"
    if math.isinf(single):
        return "INFINITY" if single > 0 else "-INFINITY"
    return "0.0f" if abs(single) < np.finfo(np.float32).tiny else f"{single!s}f"


def comment(text: str | None, width: int = WIDTH) -> list[str]:
    """Return the first paragraph of a docstring as comment lines."""
    line = " ".join((text or "").split("\n\n")[0].replace("\\", " ").split())
    return textwrap.wrap(line, width, initial_indent="// ", subsequent_indent="// ", break_on_hyphens=False)


def wrapped(line: str) -> list[str]:
    """Return the lines into which a line of code is wrapped at WIDTH."""
    indent = line[: len(line) - len(line.lstrip())] + "    "
    return textwrap.wrap(
        line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )

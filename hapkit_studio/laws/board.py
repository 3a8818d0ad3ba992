"""A law as code for the board's virtual machine.

The law is specialised, its variables are assigned to slots, and its cycles are counted before it is sent.
"""

import math
import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import accumulate
from typing import Any

from hapkit_studio.errors import LawError
from hapkit_studio.laws import machine, specialise
from hapkit_studio.laws import tree as t
from hapkit_studio.laws.law import Law
from hapkit_studio.laws.machine import EQUAL, FIRST, GREATER, LESS, UNORDERED, V, X, instructions
from hapkit_studio.laws.translate import CheckedLaw, checked

_SMALL = (60, 14, 6)
"""Largest numbers of operations of functions that are inlined at every call; tried until the code fits."""


@dataclass(frozen=True)
class Program:
    """A law for the board; parameter values change only constants, not the code.

    ``states`` is the number of state values. ``given`` contains the initial values of the slots from FIRST
    on: state, constants, tables. ``slots`` is the total number of slots. ``most`` is the worst-case number of
    cycles of a call. ``lines`` contains the source line of each instruction. ``tables`` is the number of
    bytes in tables.
    """

    code: bytes
    states: int
    given: tuple[float, ...]
    slots: int
    most: int
    lines: tuple[int, ...] = field(compare=False)
    tables: int = field(default=0, compare=False)

    @property
    def usual(self) -> float:
        """Return the mean number of cycles per call, for the test motion with the highest mean."""
        return machine.mean_cycles(self.code, self.slots, self.given)[0]

    @property
    def rest(self) -> int:
        """Return the typical number of cycles of a tick without the law.

        They include the velocity estimate if the law reads the velocity.
        """
        reads = any(
            kind == "s" and self.code[at + 1 + i] == machine.V
            for at, operation, _ in instructions(self.code)
            for i, kind in enumerate(operation.operands)
        )
        return machine.REST + (machine.ESTIMATE if reads else 0)

    def cycles_by_line(self) -> dict[int, float]:
        """Return the mean cycles per call of each source line."""
        found: dict[int, float] = {}
        counts = machine.mean_cycles(self.code, self.slots, self.given)[1]
        for (_, operation, _), line, count in zip(instructions(self.code), self.lines, counts, strict=True):
            found[line] = found.get(line, 0.0) + count * operation.usual
        return found

    @property
    def size(self) -> int:
        return 4 * self.slots + len(self.code) + machine.RAMPS * machine.RAMP

    @property
    def data(self) -> bytes:
        """Return all bytes of the program; the caller sends them in chunks."""
        return struct.pack(f"<{len(self.given)}f", *self.given) + self.code


@dataclass
class Code:
    """An instruction before slots are assigned; its operands are variables, labels or numbers."""

    name: str
    operands: tuple = ()
    mask: int = 0  # outcomes at which a compare-and-jump instruction jumps
    line: int = 0  # line in the source


class Label:
    """A jump target."""


_BINARY = {o.name.lower(): o.name for o in machine.OPERATIONS if 0x10 <= o.code < 0x20} | {
    "+": "ADD", "-": "SUBTRACT", "*": "MULTIPLY", "/": "DIVIDE", "min": "MINIMUM", "max": "MAXIMUM",
    "//": "FLOOR_DIVIDE", "%": "MODULO", "fmod": "REMAINDER", "**": "POWER", "pow": "POWER",
}  # fmt: skip
_TURNED = {"+": "ADD", "*": "MULTIPLY", "-": "SUBTRACT_FROM", "/": "DIVIDE_INTO"}
_UNARY = {o.name.lower(): o.name for o in machine.OPERATIONS if 0x20 <= o.code < 0x40}
_UNARY |= {"neg": "NEGATE", "abs": "ABSOLUTE", "trunc": "TRUNCATE"}
_OUTCOMES = {
    "<": LESS, "<=": LESS | EQUAL, ">": GREATER, ">=": GREATER | EQUAL, "==": EQUAL,
    "!=": LESS | GREATER | UNORDERED,
}  # fmt: skip
_ALL = LESS | EQUAL | GREATER | UNORDERED
_MIRROR = {LESS: GREATER, GREATER: LESS}
_OPERATIONS = {o.name: o for o in machine.OPERATIONS}
# instructions that leave the accumulator A unchanged
_PRESERVE_A = frozenset(("STORE", "COMPARE", "TEST", "STORE_AT", "LABEL"))
_ENDING = frozenset(("RETURN", "JUMP"))
_FORWARD = frozenset(("JUMP", "TEST", "COMPARE"))
# instructions that only load a new value into A
_LOAD_ONLY = frozenset(("LOAD", *_UNARY.values()))


@lru_cache(maxsize=64)
def _trees(law: Law) -> CheckedLaw:
    return checked(law.function, law.parameters, law.state)


def compile(law: Law, values: Mapping[str, float], period: float, room: int = 0) -> Program:
    """Compile a law for the board, with parameter values by key and the period in s.

    Functions are inlined as long as the code fits in ``room`` bytes; otherwise the smallest code is returned.
    Raise LawError if the board cannot run the law.
    """
    known = {i: float(values[p.key]) for i, p in enumerate(law.parameters)}
    found: list[Program] = []
    for small in _SMALL:
        made = specialise.specialise(_trees(law), known, period, small)
        try:
            found.append(assemble(made, law.initial_state.tolist()))
        except LawError as error:
            reason = error
        else:
            if found[-1].size <= room:
                return found[-1]
    if not found:
        raise reason
    return min(found, key=lambda program: program.size)


def assemble(law: t.Specialised, start: Sequence[float]) -> Program:
    """Return the program of a specialised law with initial state ``start``; raise LawError if too large."""
    sections = [_Section(f) for f in law.functions]
    main = _Section(None, law.body)
    _lay_out([*sections, main])
    numbers: dict[str, int] = {}
    given = list(start)
    operands = [o for section in (*sections, main) for c in section.code for o in c.operands]
    for one in operands:
        if isinstance(one, t.Num) and one.key not in numbers:
            numbers[one.key] = FIRST + len(given)
            given.append(one.value)
    constants = len(given)
    for table in dict.fromkeys(o for o in operands if isinstance(o, str)):
        numbers[table] = FIRST + len(given)
        given += law.tables[table]
    in_tables = 4 * (len(given) - constants)
    first = FIRST + len(given)
    slots = first + max(section.top for section in (*sections, main))
    if in_tables and slots > machine.MOST_SLOTS:
        raise LawError(
            f"The tables of this law take {in_tables:,} bytes, but "
            f"the board has only {machine.ARENA} bytes for the whole law. Use fewer numbers."
        )
    for count, most, what in (
        (slots, machine.MOST_SLOTS, "values in use at the same time"),
        (len(sections), machine.MOST_SUBROUTINES, "functions that are called from several places"),
        (main.depth, machine.MOST_CALLS, "functions inside one another"),
        (main.counter, machine.MOST_COUNTERS, "loops inside one another"),
    ):
        if count > most:
            raise LawError(
                f"This law has {count} {what}, but the board can hold only {most}. Simplify the law."
            )
    code, lines = _Encoder(numbers, first).encoded([*sections, main])
    most = machine.longest_path(code)
    return Program(code, len(start), tuple(map(_single, given)), slots, most, lines, in_tables)


def _single(value: float) -> float:
    return struct.unpack("<f", struct.pack("<f", value))[0]


class _Section:
    """The code of one function, or of the law's body, before its variables have slots."""

    def __init__(self, function: t.Function | None, body: list[t.Statement] | None = None):
        self.function = function
        self.code: list[Code] = []
        self.counter = 0  # number of loop counters used in this section or in its callees
        self.depth = 0  # call depth below this section
        self.places: dict[str, int] = {}
        self.base = self.top = 0
        self.called: list[t.Function] = []
        self._in_a: set[t.Expr] = set()  # the expressions that equal A
        # for each label, the expressions that equal A at every forward jump to the label
        self._at_label: dict[Label, set[t.Expr]] = {}
        self._numbers: dict[str, int] = {}  # bit positions of variables
        self._ends: dict[int, Label] = {}
        self._loops: list[tuple[Label, Label]] = []
        self._starts: dict[int, Label] = {}  # keyed by the LOOP instruction
        self._extra = self._line = 0
        if function is None:
            assert body is not None
            self.statements(body)
        else:
            self.statements([function.body])
            self.put("RETURN")
        self.optimise()

    def put(self, name: str, *operands: Any, mask: int = 0) -> None:
        self.code.append(Code(name, operands, mask, self._line))
        if name in _FORWARD:
            aim = operands[-1]
            self._at_label[aim] = self._at_label.get(aim, self._in_a) & self._in_a
        if name not in _PRESERVE_A:
            self._in_a = set()

    def label(self, label: Label) -> None:
        """Emit a label; keep only the knowledge of A that holds on every path to the label."""
        brought = self._at_label.get(label)
        if self.code and self.code[-1].name in _ENDING:
            self._in_a = set(brought or ())
        elif brought is not None:
            self._in_a = self._in_a & brought
        self.code.append(Code("LABEL", (label,)))

    def in_slot(self, value: t.Expr) -> t.Var:
        """Return a temporary variable that contains a value."""
        self.load(value)
        self._extra += 1
        made = t.Var(f"#{self._extra}")
        self.store(made)
        return made

    # --- statements
    def statements(self, statements: Sequence[t.Statement]) -> None:
        for s in statements:
            self.statement(s)

    def statement(self, s: t.Statement) -> None:
        self._line = s.line or self._line
        match s:
            case t.Assign(to, value):
                self.load(value)
                self.store(t.Var(to))
            case t.SetAt(place, value):
                self.load(value)
                self.put("STORE_AT", place.index, FIRST + place.start, place.size)
                self._in_a -= {h for h in self._in_a if isinstance(h, t.Var) and h.name.startswith("s[")}
            case t.Return(value):
                self.load(value)
                self.put("RETURN")
            case t.If(test, then, other):
                self.branch(test, then, other)
            case t.Loop():
                self.loop(s)
            case t.Break():
                self.put("JUMP", self._loops[-1][1])
            case t.Continue():
                self.put("JUMP", self._loops[-1][0])
            case t.Block(body):
                end = self._ends[id(s)] = Label()
                self.statements(body)
                self.label(end)
            case t.Leave(block, moves):
                self.statements(moves)
                self.put("JUMP", self._ends[id(block)])
            case t.Call(function):
                self.called.append(function)
                self.put("CALL", function)

    def branch(self, test: t.Test, then: list[t.Statement], other: list[t.Statement]) -> None:
        """Emit a branch; an empty side needs no jump."""
        if not then:
            test, then, other = t.Not(test), other, then
        no, end = Label(), Label()
        self.jump(test, no, False)
        self.statements(then)
        if other:
            self.put("JUMP", end)
        self.label(no)
        self.statements(other)
        self.label(end)

    def loop(self, loop: t.Loop) -> None:
        turn, end, start = Label(), Label(), Label()
        at = len(self.code)
        self.put("LOOP", 0, loop.times)
        self._starts[id(self.code[at])] = start
        self.label(start)
        self._loops.append((turn, end))
        outside, self.counter = self.counter, 0
        self.statements(loop.body)
        self._loops.pop()
        self.label(turn)
        self.statements(loop.after)
        number = self.counter
        self.code[at].operands = (number, loop.times)
        self.put("NEXT", number, start)
        self.label(end)
        self.counter = max(outside, number + 1)

    # --- tests
    def jump(self, test: t.Test, label: Label, when: bool) -> None:
        """Emit a jump that is taken if the test's outcome is ``when``."""
        match test:
            case t.Not(inner):
                self.jump(inner, label, not when)
            case t.Logic(op, tests):
                if (op == "or") == when:
                    for one in tests:
                        self.jump(one, label, when)
                    return
                over = Label()
                for one in tests[:-1]:
                    self.jump(one, over, not when)
                self.jump(tests[-1], label, when)
                self.label(over)
            case t.Compare(op, left, right):
                mask = _OUTCOMES[op] if when else _ALL ^ _OUTCOMES[op]
                self.compare(mask, left, right, label)

    def compare(self, mask: int, left: t.Expr, right: t.Expr, label: Label) -> None:
        if isinstance(right, t.Num) and right.value == 0.0 and right.key in ("0.0", "-0.0"):
            self.load(left)
            self.put("TEST", label, mask=mask)
            return
        if not isinstance(right, t.Num | t.Var) or (right in self._in_a and isinstance(left, t.Num | t.Var)):
            left, right = right, left
            mask = (mask & (EQUAL | UNORDERED)) | sum(_MIRROR[m] for m in (LESS, GREATER) if mask & m)
        right = right if isinstance(right, t.Num | t.Var) else self.in_slot(right)
        self.load(left)
        self.put("COMPARE", right, label, mask=mask)

    # --- values
    def store(self, to: t.Var) -> None:
        if to in self._in_a:
            return
        self.put("STORE", to)
        self._in_a = {h for h in self._in_a if not t.mentions(h, frozenset((to.name,)))} | {to}

    def load(self, value: t.Expr) -> None:
        """Load a value into A."""
        if value in self._in_a:
            return
        match value:
            case t.Num(number) if abs(number) > t.MOST_FLOAT:  # this number is infinite in single precision
                self.load(t.literal(math.copysign(3e38, number)))
                self.put("MULTIPLY", t.literal(3e38))
            case t.Num(number) if not t.is_single(number):
                self.load(t.literal(0.0))
            case t.Num() | t.Var():
                self.put("LOAD", value)
            case t.At(index, start, size):
                self.put("LOAD_AT", index, FIRST + start, size)
            case t.Entry(index, table, size):
                self.put("LOAD_AT", index, table, size)
            case t.Select(test, yes, no):
                other, end = Label(), Label()
                self.jump(test, other, False)
                self.load(yes)
                self.put("JUMP", end)
                self.label(other)
                self.load(no)
                self.label(end)
            case t.Op(name, (operand,)):
                self.load(operand)
                self.put(_UNARY[name])
            case t.Op(name, (left, right)):
                self.combine(name, left, right)
        if isinstance(value, t.Num | t.Var):
            self._in_a.add(value)

    def combine(self, name: str, left: t.Expr, right: t.Expr) -> None:
        """Emit a binary operation with one operand in A and the other in a slot."""
        turned = _TURNED.get(name)
        left_is, right_is = (
            isinstance(s, t.Num | t.Var) and (not isinstance(s, t.Num) or t.is_single(s.value))
            for s in (left, right)
        )
        if left_is and turned and (not right_is or right in self._in_a) and left not in self._in_a:
            self.load(right)
            self.put(turned, left)
        elif right_is:
            self.load(left)
            self.put(_BINARY[name], right)
        else:
            slot = self.in_slot(right)
            self.load(left)
            self.put(_BINARY[name], slot)

    # --- optimisation
    def optimise(self) -> None:
        """Optimise jumps and remove dead code until the code stays the same."""
        size = -1
        while size != len(self.code):
            size = len(self.code)
            self._thread_jumps()
            self._drop_dead()
            # a loop whose end is unreachable runs only once
            turned = {id(c.operands[-1]) for c in self.code if c.name == "NEXT"}
            self.code = [c for c in self.code if c.name != "LOOP" or id(self._starts[id(c)]) in turned]
            self._coalesce_copies()

    def _thread_jumps(self) -> None:
        """Thread jumps; remove unreachable code and jumps to the next instruction."""
        after: dict[Label, Code] = {}
        last: Code | None = None
        for code in reversed(self.code):
            if code.name == "LABEL":
                if last is not None:
                    after[code.operands[0]] = last
            else:
                last = code
        aims: set[Label] = set()
        remaining: list[Code] = []
        dead = False
        for code in self.code:
            if code.name == "LABEL":
                dead = dead and code.operands[0] not in aims
            if dead:
                continue
            if code.name in _FORWARD:
                aim = after.get(code.operands[-1])
                if aim is not None and aim.name == "JUMP":
                    code.operands = (*code.operands[:-1], aim.operands[0])
                elif code.name == "JUMP" and aim is not None and aim.name == "RETURN":
                    code = Code("RETURN", line=code.line)
            if code.name in _FORWARD:
                aims.add(code.operands[-1])
            remaining.append(code)
            dead = code.name in _ENDING
        self.code = [
            c for i, c in enumerate(remaining) if not (c.name == "JUMP" and _jumps_to_next(remaining, i))
        ]
        aims = {o for c in self.code if c.name != "LABEL" for o in c.operands if isinstance(o, Label)}
        self.code = [c for c in self.code if c.name != "LABEL" or c.operands[0] in aims]

    def _drop_dead(self) -> None:
        """Remove stores of values that are never read (dead-store elimination)."""
        live, remaining = self.live(), []
        for i, code in enumerate(self.code):
            if code.name == "STORE" and not live[i + 1] & self.bit(code.operands[0]):
                continue
            following = next((c.name for c in self.code[i + 1 :] if c.name != "LABEL"), "")
            if code.name in _LOAD_ONLY and following in ("LOAD", "CALL"):
                continue
            remaining.append(code)
        self.code = remaining

    def _coalesce_copies(self) -> None:
        """Coalesce copies: two variables share a slot if one is only a copy of the other."""
        clashes: dict[int, int] | None = None
        for at in range(len(self.code) - 1):
            first, second = self.code[at], self.code[at + 1]
            if (first.name, second.name) != ("LOAD", "STORE") or not isinstance(first.operands[0], t.Var):
                continue
            a, b = first.operands[0], second.operands[0]
            old, new = (a, b) if self.is_local(a) else (b, a)
            if a == b or not self.is_local(old) or a.name in ("x", "v"):
                continue
            clashes = clashes or self.clashes()
            if clashes.get(self.bit(old), 0) & self.bit(new):
                continue
            for code in self.code:
                code.operands = tuple(new if o == old else o for o in code.operands)
            clashes = None
        self.code = [c for i, c in enumerate(self.code) if not self._is_idle(i)]

    def _is_idle(self, at: int) -> bool:
        """Return True if an instruction stores a value into the variable from which it was just loaded."""
        code, before = self.code[at], self.code[at - 1]
        return code.name == "STORE" and at > 0 and before.name == "LOAD" and code.operands == before.operands

    def is_local(self, variable: t.Expr) -> bool:
        """Return True if a variable is local to this section."""
        if not isinstance(variable, t.Var) or variable.name in ("x", "v") or variable.name.startswith("s["):
            return False
        functions = [*self.called, *([self.function] if self.function else [])]
        return not any(variable.name in f.lasting for f in functions)

    def bit(self, variable: t.Expr | str) -> int:
        name = variable.name if isinstance(variable, t.Var) else variable
        return 1 << self._numbers.setdefault(name, len(self._numbers))  # type: ignore[arg-type]

    def _bits(self, variables: Iterable[t.Expr | str]) -> int:
        return sum({self.bit(v) for v in variables})

    def written(self, code: Code) -> int:
        """Return the variables that an instruction writes, as bits."""
        if code.name == "STORE":
            return self.bit(code.operands[0])
        return self._bits(code.operands[0].results) if code.name == "CALL" else 0

    def read(self, code: Code) -> int:
        """Return the variables that an instruction reads, as bits, without indexed state."""
        if code.name == "CALL":
            return self._bits(code.operands[0].parameters)
        if code.name == "STORE" or not code.operands or not isinstance(code.operands[0], t.Var):
            return 0
        return self.bit(code.operands[0])

    def clashes(self) -> dict[int, int]:
        """Return the interference graph: for each variable's bit, the bits that are live at its writes."""
        live, found = self.live(), dict[int, int]()
        for i, code in enumerate(self.code):
            if code.name not in ("STORE", "STORE_AT", "CALL"):
                continue
            before = self.code[i - 1]
            is_copy = code.name == "STORE" and before.name == "LOAD" and isinstance(before.operands[0], t.Var)
            copied = self.bit(before.operands[0]) if is_copy else 0
            for name in self.overwritten(code):
                bit = self.bit(name)
                others = live[i + 1] & ~bit & ~copied
                found[bit] = found.get(bit, 0) | others
        # make the graph symmetric at the end; inside the loop this would dominate the run time
        for bit, others in list(found.items()):
            while others:
                other = others & -others
                found[other] = found.get(other, 0) | bit
                others ^= other
        return found

    def overwritten(self, code: Code) -> list[str]:
        """Return the variables that an instruction may write; a call leaves its own arguments unchanged."""
        if code.name == "STORE":
            name = code.operands[0].name
            # arguments and results of different functions may share slots
            others = [f for f in self.called if name not in f.lasting]
            others = others if len(others) < len(self.called) else []
            return [name, *(n for f in others for n in f.lasting)]
        if code.name == "STORE_AT":
            _, first, size = code.operands
            return [f"s[{first - FIRST + i}]" for i in range(size)]
        found = {n for f in self.called for n in f.lasting}
        return sorted(found - set(code.operands[0].parameters))

    def live(self) -> list[int]:
        """Return the variables, as bits, that are live before each instruction and at the end."""
        # arguments stay live, because a caller may reuse the arguments of its previous call
        lasting = self._bits(self.function.lasting) if self.function else 0
        used = {o.name for c in self.code for o in c.operands if isinstance(o, t.Var)}
        states = self._bits(name for name in used if name.startswith("s["))
        places = {c.operands[0]: i for i, c in enumerate(self.code) if c.name == "LABEL"}
        steps = [(self.written(c), self.read(c)) for c in self.code]
        live = [0] * (len(self.code) + 1)
        changed = True
        while changed:
            changed = False
            for i in range(len(self.code) - 1, -1, -1):
                code = self.code[i]
                if code.name == "RETURN":
                    out = lasting | states
                elif code.name == "JUMP":
                    out = live[places[code.operands[0]]]
                else:
                    out = live[i + 1]
                    if code.name in ("COMPARE", "TEST", "NEXT"):
                        out |= live[places[code.operands[-1]]]
                if code.name in _ENDING_MAYBE:
                    out |= states
                written, read = steps[i]
                out = (out & ~written) | read
                if out != live[i]:
                    live[i] = out
                    # only the end of a loop jumps backwards
                    changed = changed or any(c.name == "NEXT" for c in self.code[i:])
        return live


# All states are live at these instructions: they may end the law, which preserves its state, or they access
# the state by index.
_ENDING_MAYBE = frozenset(
    ("DIVIDE", "DIVIDE_INTO", "FLOOR_DIVIDE", "MODULO", "REMAINDER", "LOAD_AT", "STORE_AT")
)


def _jumps_to_next(codes: Sequence[Code], at: int) -> bool:
    """Return True if a jump leads to the next instruction."""
    for code in codes[at + 1 :]:
        if code.name != "LABEL":
            return False
        if code.operands[0] is codes[at].operands[0]:
            return True
    return False


def _lay_out(sections: Sequence[_Section]) -> None:
    """Assign slots to local variables; these slots come after those of the constants.

    Variables that are live at the same time do not share a slot.

    The variables of a function come after those of its callees.
    """
    by_name = {s.function.name: s for s in sections if s.function is not None}
    for section in sections:
        below = [by_name[f.name] for f in section.called]
        section.base = max((s.top for s in below), default=0)
        section.depth = max((s.depth + 1 for s in below), default=0)
        inner = max((s.counter for s in below), default=0)
        if inner:
            for code in section.code:
                if code.name in ("LOOP", "NEXT"):
                    code.operands = (code.operands[0] + inner, *code.operands[1:])
            section.counter += inner
        for other in below:
            section.places |= {n: other.places[n] for n in other.function.lasting}  # type: ignore[union-attr]
        _colour(section)


def _colour(section: _Section) -> None:
    """Graph colouring: assign slots to the section's variables, starting at its base."""
    lasting = section.function.lasting if section.function else ()
    section.places |= {name: section.base + i for i, name in enumerate(lasting)}
    section.top = place = section.base + len(lasting)
    clashes = section.clashes()
    own = dict.fromkeys(
        o.name for code in section.code for o in code.operands if isinstance(o, t.Var) and section.is_local(o)
    )
    for name in own:
        near = clashes.get(section.bit(name), 0)
        taken = {at for n, at in section.places.items() if n in own and section.bit(n) & near}
        section.places[name] = next(n for n in range(place, place + len(own)) if n not in taken)
        section.top = max(section.top, section.places[name] + 1)


# --- bytes
class _Encoder:
    """Encodes sections as bytes.

    ``numbers`` contains the slots of constants and tables, and ``first`` is the slot of the first variable.
    """

    def __init__(self, numbers: Mapping[str, int], first: int):
        self.numbers, self.first = numbers, first
        self.starts: dict[str, int] = {}  # offset of each function in the code

    def encoded(self, sections: Sequence[_Section]) -> tuple[bytes, tuple[int, ...]]:
        """Return the code of all sections, the law's body last, and the source line of each instruction."""
        out, lines = bytearray(), list[int]()
        for section in sections:
            if section.function is not None:
                self.starts[section.function.name] = len(out)
            out += bytes([_OPERATIONS["MAIN" if section.function is None else "SUBROUTINE"].code])
            pieces = self.section(section)
            out += b"".join(piece for piece, _ in pieces)
            lines += [0, *(line for piece, line in pieces for _ in instructions(piece))]
        return bytes(out), tuple(lines)

    def section(self, section: _Section) -> list[tuple[bytes, int]]:
        """Return bytes and line of each instruction; a jump too far for one byte becomes two jumps."""
        far: set[int] = set()
        while True:
            ends = list(accumulate(_size(code, i in far) for i, code in enumerate(section.code)))
            places = {
                c.operands[0]: end for c, end in zip(section.code, ends, strict=True) if c.name == "LABEL"
            }
            out: list[tuple[bytes, int]] = []
            longer: set[int] = set()
            for i, (code, end) in enumerate(zip(section.code, ends, strict=True)):
                piece = self.instruction(section, code, places, end, i in far)
                if piece is None:
                    longer.add(i)
                elif piece:
                    out.append((piece, code.line))
            if not longer:
                return out
            far |= longer

    def instruction(
        self, section: _Section, code: Code, places: Mapping[Label, int], end: int, far: bool
    ) -> bytes | None:
        """Return an instruction's bytes, empty for a label; None if a jump is too far for one byte."""
        if code.name == "LABEL":
            return b""
        operation = _OPERATIONS[code.name]
        if far:
            distance = places[code.operands[-1]] - end
            jump = bytes([_OPERATIONS["FAR_JUMP"].code]) + struct.pack("<H", distance)
            if code.name == "JUMP":
                return jump
            # on the opposite outcome, skip the long jump
            near = [self.slot(section, o) for o in code.operands[:-1]]
            return bytes([operation.code | (_ALL ^ code.mask), *near, 3]) + jump
        out = bytes([operation.code | code.mask])
        for kind, operand in zip(operation.operands, code.operands, strict=True):
            match operand:
                case Label():
                    number = end - places[operand] if code.name == "NEXT" else places[operand] - end
                    if kind == "d" and number > 255:
                        return None
                case t.Function():
                    number = self.starts[operand.name]
                case str():  # the name of a table
                    number = self.numbers[operand]
                case int():
                    number = operand
                    if number > 0xFFFF:
                        raise LawError(
                            "A loop of this law repeats more than 65,535 times, the maximum on the board. "
                            "Use fewer repetitions."
                        )
                case _:
                    number = self.slot(section, operand)
            out += struct.pack("<H" if kind == "w" else "B", number)
        return out

    def slot(self, section: _Section, operand: t.Expr) -> int:
        if isinstance(operand, t.Num):
            return self.numbers[operand.key]
        assert isinstance(operand, t.Var)
        if operand.name in ("x", "v"):
            return X if operand.name == "x" else V
        if operand.name.startswith("s["):
            return FIRST + int(operand.name[2:-1])
        return self.first + section.places[operand.name]


def _size(code: Code, far: bool) -> int:
    if code.name == "LABEL":
        return 0
    size = _OPERATIONS[code.name].size
    return size if not far else 3 if code.name == "JUMP" else size + 3

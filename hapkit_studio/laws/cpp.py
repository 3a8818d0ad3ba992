"""Translates a law to C++ in single precision: for the board, and for a sketch that renders one law alone.

It starts from the same checked tree as the loop's machine code, so there is one law language.
"""

import ast
import zlib
from dataclasses import dataclass
from functools import cached_property

from hapkit_studio.laws.cpp_expressions import Places, helper_name, parameter_names
from hapkit_studio.laws.cpp_program import Program, Routine, collect
from hapkit_studio.laws.cpp_statements import Statements, watched
from hapkit_studio.laws.cpp_words import comment, mangled, number, wrapped
from hapkit_studio.laws.law import Law, StateValue
from hapkit_studio.parameters import Choice

# More turns of loops and calls than this do not fit into a tick of the board; a law that may take more is
# watched, and refused where it does.
BOARD_TURNS = 1000


@dataclass(frozen=True)
class CppLaw:
    """A law in C++: its own namespace, and the studio's numbers that it uses, by name, callees first."""

    law: Law
    namespace: str

    @cached_property
    def program(self) -> Program:
        return collect(self.law)

    @cached_property
    def numbers(self) -> dict[str, str]:
        """Return each shared helper's text by its name."""
        shared = (r for r in self.program.helpers.values() if r.shared)
        return {helper_name(r): self._function(r) for r in shared}

    @cached_property
    def body(self) -> str:
        """Return what stands in the law's namespace, the fingerprint left out."""
        parts = [self._indices()]
        parts += [self._function(r) for r in self.program.helpers.values() if not r.shared]
        return "\n\n".join([*filter(None, parts), self._start(), self._force()])

    @property
    def fingerprint(self) -> int:
        """Return the CRC-32 of everything that the law runs."""
        return zlib.crc32("\n".join([*self.numbers.values(), self.body]).encode())

    def text(self) -> str:
        """Return the law's namespace as a header has it."""
        counts = f"constexpr uint8_t kParameters = {len(self.law.parameters)}, kStates = {self._states};"
        mark = f"constexpr uint32_t kFingerprint = 0x{self.fingerprint:08x};"
        head = f"namespace laws {{\nnamespace {self.namespace} {{"
        tail = f"}}  // namespace {self.namespace}\n}}  // namespace laws\n"
        return "\n\n".join([head, f"{counts}\n{mark}", self.body, tail])

    @property
    def _states(self) -> int:
        return len(self.law.state_names)

    @property
    def places(self) -> Places:
        keys = parameter_names(tuple(p.key for p in self.law.parameters))
        states: list[str] = []
        for key, value in self.law.state.items():
            first = f"State::{mangled(key)}"
            states += [first] + [f"{first} + {i}" for i in range(1, _size(value))]
        return Places(keys, tuple(states))

    def _indices(self) -> str:
        """Return the names of parameters and states as indices."""
        lines = []
        for name, p in zip(self.places.parameters, self.law.parameters, strict=True):
            what = ", ".join(f"{i} {o}" for i, o in enumerate(p.options)) if isinstance(p, Choice) else p.unit
            lines += [*comment(what, "  "), f"  {name},"]
        found = ["enum Parameter : uint8_t {", *lines, "};"] if lines else []
        place, names = 0, []
        for key, value in self.law.state.items():
            names.append(f"{mangled(key)} = {place}")
            place += _size(value)
        if names:
            found += ["namespace State {", *wrapped(f"enum : uint8_t {{ {', '.join(names)} }};"), "}"]
        return "\n".join(found)

    def _start(self) -> str:
        values = self.law.initial_state.tolist()
        lines = [f"  s[{name}] = {number(v)};" for name, v in zip(self.places.states, values, strict=True)]
        if not lines:
            return "inline void start(float*) {}"
        return "\n".join(["// Set the first state.", "inline void start(float* s) {", *lines, "}"])

    def _force(self) -> str:
        routine = self.program.law
        routines = [routine, *self.program.helpers.values()]
        guarded = self.burns or any(watched(r.tree) for r in routines)
        body = Statements(routine, self.program.helpers, self.places, self.burns, guarded)
        lines = body.block(routine.tree.body)
        if guarded:
            lines.insert(0, f"  laws::begin({BOARD_TURNS});" if self.burns else "  laws::begin();")
        used = {n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name)}
        kinds = {"p": "const float*", "s": "float*", "x": "float", "v": "float", "dt": "float"}
        given = ", ".join(f"{kind} {name}" if name in used else kind for name, kind in kinds.items())
        head = [*comment(routine.function.__doc__ or "Return the force in N, positive to the right.")]
        return _joined([*head, f"inline float force({given}) {{", *_statics(body), *lines, "}"])

    @cached_property
    def burns(self) -> bool:
        """Return whether the law may take more turns than a tick of the board has time for."""
        return self._turns(self.program.law) > BOARD_TURNS

    def _turns(self, routine: Routine) -> int:
        return 0 if routine.shared else 1 + self._turns_of(routine.tree.body)

    def _turns_of(self, statements: list[ast.stmt]) -> int:
        turns = 0
        for node in statements:
            if isinstance(node, ast.For):
                assert isinstance(node.iter, ast.Call)
                times = len(range(*map(ast.literal_eval, node.iter.args)))
                turns += times * (1 + self._turns_of(node.body))
            elif isinstance(node, ast.If):
                turns += self._turns_of([ast.Expr(node.test)])
                turns += max(self._turns_of(node.body), self._turns_of(node.orelse))
            else:
                names = (n.func.id for n in ast.walk(node) if _is_plain_call(n))  # type: ignore[attr-defined]
                turns += sum(self._turns(self.program.helpers[n]) for n in names if n in self.program.helpers)
        return turns

    def _function(self, routine: Routine) -> str:
        body = Statements(routine, self.program.helpers, Places(), not routine.shared and self.burns)
        lines = body.block(routine.tree.body)
        used = {n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name)}
        names = [a.arg for a in routine.tree.args.args if a.arg != "_fault"]
        given = ", ".join(f"float {mangled(n)}" if n in used else "float" for n in names)
        kind = "float" if routine.values == 1 else f"laws::Several<{routine.values}>"
        name = helper_name(routine).removeprefix("numbers::")
        head = [*comment(routine.function.__doc__), f"inline {kind} {name}({given}) {{"]
        return _joined([*head, *_statics(body), *lines, "}"])


def _is_plain_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name)


def _statics(body: Statements) -> list[str]:
    return [f"  static laws::Inverse inverse{i + 1}_ = LAWS_NO_INVERSE;" for i in range(len(body.inverses))]


def _joined(lines: list[str]) -> str:
    return "\n".join(words for line in lines for words in wrapped(line))


def _size(value: StateValue) -> int:
    return len(value) if isinstance(value, tuple) else 1


def shared_text(numbers: dict[str, str]) -> str:
    """Return the namespace of the studio's numbers, "" where a law uses none."""
    if not numbers:
        return ""
    body = "\n\n".join(numbers.values())
    return f"namespace laws {{\nnamespace numbers {{\n\n{body}\n\n}}  // namespace numbers\n}}  // namespace laws\n"


def translate_cpp(law: Law, namespace: str) -> str:
    """Return a bound law's C++: the studio's numbers that it uses, then its own namespace in ``laws``.

    It needs fast.h and laws/law.h before it. Raise LawError where the law leaves the law language.
    """
    made = CppLaw(law, namespace)
    return "\n".join(part for part in (shared_text(made.numbers), made.text()) if part)

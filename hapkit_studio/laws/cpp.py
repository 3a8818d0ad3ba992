"""Translates a law to C++ in single precision: for the board, and for a sketch that renders one law alone.

It starts from the same checked tree as the loop's machine code, so there is one law language.
"""

import ast
import zlib
from functools import cached_property

from hapkit_studio.laws.cpp_expressions import Places, parameter_names
from hapkit_studio.laws.cpp_functions import Numbers, helper_text, joined, statics
from hapkit_studio.laws.cpp_program import Routine, collect
from hapkit_studio.laws.cpp_small import Small, choice_places, small
from hapkit_studio.laws.cpp_statements import Statements, watched
from hapkit_studio.laws.cpp_words import comment, mangled, number, wrapped
from hapkit_studio.laws.law import Law, StateValue
from hapkit_studio.parameters import Choice

# More turns of loops and calls than this do not fit into a tick of the board; a law that may take more is
# watched, and refused where it does.
BOARD_TURNS = 1000


_GIVEN = {"p": "const float*", "s": "float*", "x": "float", "v": "float", "dt": "float"}
_GUARD = """\
inline float force(const float* p, float* s, float x, float v, float dt) {{
  laws::begin({});
  return laws::checked(unwatched(p, s, x, v, dt));
}}"""


class CppLaw:
    """A law in C++, in a namespace of its own beside the numbers that it shares with others."""

    def __init__(self, law: Law, namespace: str):
        self.law, self.namespace = law, namespace
        self.program = collect(law)
        self.alone = Numbers([(self.program, law.parameters)])

    @cached_property
    def fingerprint(self) -> int:
        """Return the CRC-32 of everything that the law runs, as it is written where it is the only one."""
        return zlib.crc32((self.alone.text() + self.body(self.alone)).encode())

    def text(self, numbers: Numbers) -> str:
        """Return the law's namespace as a header has it."""
        counts = f"constexpr uint8_t kParameters = {len(self.law.parameters)}, kStates = {self._states};"
        mark = f"constexpr uint32_t kFingerprint = 0x{self.fingerprint:08x};"
        head = f"namespace laws {{\nnamespace {self.namespace} {{"
        tail = f"}}  // namespace {self.namespace}\n}}  // namespace laws\n"
        return "\n\n".join([head, f"{counts}\n{mark}", self.body(numbers), tail])

    def body(self, numbers: Numbers) -> str:
        """Return what stands in the law's namespace, the fingerprint left out."""
        own = (r for r in self.program.helpers.values() if not r.shared)
        small_here = small(self.program, numbers.small, choice_places(self.law.parameters))
        helpers = [helper_text(r, self.program.helpers, small_here, self.burns, "static") for r in own]
        return "\n\n".join(
            [*filter(None, [self._indices()]), *helpers, self._start(), *self._force(small_here)]
        )

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
        if not values:
            return "inline void start(float*) {}"
        named = zip(self.places.states, values, strict=True)
        lines = ["  laws::clear(s, kStates);", *(f"  s[{name}] = {number(v)};" for name, v in named if v)]
        return "\n".join(["// Set the first state.", "inline void start(float* s) {", *lines, "}"])

    def _force(self, small_here: Small) -> list[str]:
        """Return the law's function; where it can have a fault, inside one that looks for it."""
        routine = self.program.law
        guarded = self.burns or any(watched(r.tree) for r in (routine, *self.program.helpers.values()))
        body = Statements(routine, self.program.helpers, self.places, small_here, self.burns)
        lines = body.block(routine.tree.body)
        used = {n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name)}
        given = ", ".join(f"{kind} {name}" if name in used else kind for name, kind in _GIVEN.items())
        head = comment(routine.function.__doc__ or "Return the force in N, positive to the right.")
        name = "unwatched" if guarded else "force"
        lines = [*body.take_over(), *lines]
        hurries = body.inverses and not self._states
        ends = ["  LAWS_OWN_ENDS;"] if hurries else []
        text = joined([*head, f"inline float {name}({given}) {{", *ends, *statics(body), *lines, "}"])
        return [text, _GUARD.format(BOARD_TURNS if self.burns else "")] if guarded else [text]

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


def _is_plain_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name)


def _size(value: StateValue) -> int:
    return len(value) if isinstance(value, tuple) else 1


def translate_cpp(law: Law, namespace: str) -> str:
    """Return a bound law's C++: the studio's numbers that it uses, then its own namespace in ``laws``.

    It needs fast.h and laws/law.h before it. Raise LawError where the law leaves the law language.
    """
    made = CppLaw(law, namespace)
    return "\n".join(part for part in (made.alone.text(), made.text(made.alone)) if part)

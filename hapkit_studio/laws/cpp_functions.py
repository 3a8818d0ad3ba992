"""Writes whole functions in C++: helpers, and the numbers that all laws share."""

import ast
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from hapkit_studio.laws.cpp_expressions import Places, kept_name
from hapkit_studio.laws.cpp_kept import arguments, kept
from hapkit_studio.laws.cpp_program import Program, Routine
from hapkit_studio.laws.cpp_small import Small, choice_places, small_numbers
from hapkit_studio.laws.cpp_statements import Statements, kind_of_result
from hapkit_studio.laws.cpp_words import comment, mangled, wrapped
from hapkit_studio.parameters import AnyParameter


def helper_text(routine: Routine, routines: dict[str, Routine], small: Small, burns: bool, how: str) -> str:
    """Return a helper's definition after the words `how`; burns says whether its turns are counted."""
    body = Statements(routine, routines, Places(), small, burns)
    lines = body.block(routine.tree.body)
    used = {n.id for n in ast.walk(routine.tree) if isinstance(n, ast.Name)}
    names = [name for name in arguments(routine) if name not in body.own]
    kinds = {n: "int8_t" if n in small.names[routine.name] else "float" for n in names}
    given = ", ".join(f"{kind} {mangled(n)}" if n in used else kind for n, kind in kinds.items())
    kind = kind_of_result(small.results[routine.name])
    name = routine.word.removeprefix("numbers::")
    head = [*comment(routine.function.__doc__), f"{how} {kind} {name}({given}) {{"]
    return joined([*head, *statics(body), *lines, "}"])


def statics(body: Statements) -> list[str]:
    """Return the lines of the inverses that a function keeps."""
    return [f"  static laws::Inverse inverse{i + 1}_ = LAWS_NO_INVERSE;" for i in range(len(body.inverses))]


def joined(lines: Iterable[str]) -> str:
    """Return lines as a text, broken where they are too long."""
    return "\n".join(words for line in lines for words in wrapped(line))


class Numbers:
    """The studio's own functions that some laws use, once for all of them."""

    def __init__(self, laws: Iterable[tuple[Program, Sequence[AnyParameter]]]):
        self.routines: dict[str, Routine] = {}
        self.callers: Counter[str] = Counter()
        programs, choices = [], []
        for program, parameters in laws:
            programs.append(program)
            choices.append(choice_places(parameters))
            self.routines |= {name: r for name, r in program.helpers.items() if r.shared}
        for routine in [r for program in programs for r in program.outside] + [*self.routines.values()]:
            self.callers.update(() if routine.by_hand else routine.called())
        self.kept = kept(self.routines)
        self.small = small_numbers(programs, choices, self.kept)

    def texts(self) -> Mapping[str, str]:
        """Return each function's definition by its name, callees first."""
        found = {}
        for name, routine in self.routines.items():
            if not routine.by_hand:
                # what is called from one place may stand there, what is called from several stands once
                how = "static" if self.callers[name] == 1 else "FAST_ONCE"
                found[name] = helper_text(routine, self.routines, self.small, False, how)
        return found

    @property
    def headers(self) -> list[str]:
        """Return the headers of what is written by hand."""
        return sorted({r.by_hand for r in self.routines.values()} - {""})

    def _names(self) -> list[str]:
        """Return the kept arguments; a header by hand declares its own."""
        own = (self.kept[n] for n, r in self.routines.items() if r.by_hand)
        return sorted(set().union(*self.kept.values()) - set().union(*own))

    def text(self) -> str:
        """Return their namespace, "" where there are none."""
        if not self.routines:
            return ""
        names = self._names()
        kept = ", ".join(kept_name(name) for name in names)
        parts = [*wrapped(f"static float {kept};")] if names else []
        body = "\n\n".join([*(["\n".join(parts)] if parts else []), *self.texts().values()])
        head, tail = (
            "namespace laws {\nnamespace numbers {",
            "}  // namespace numbers\n}  // namespace laws\n",
        )
        return "\n\n".join([head, body, tail])

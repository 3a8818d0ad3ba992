"""A law as a sketch has it: the translator's C++ with the tuned values by name, and its helpers."""

import re
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from hapkit_studio import resources
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import LawError
from hapkit_studio.laws.cpp import CppLaw, translate_cpp
from hapkit_studio.laws.cpp_words import WIDTH, comment, constant_name, mangled, number, wrapped
from hapkit_studio.parameters import Choice, Parameter
from hapkit_studio.workshop.sketch_calls import plain

_NAMED = re.compile(r"\b(?:fast|laws)::(\w+)")
_WITHIN = re.compile(r"\b(?:fast|laws)::(?=\w)")
_LEFT_OUT = (
    re.compile(r"^enum Parameter[^}]*};\n", re.MULTILINE),
    re.compile(r"^constexpr uint32_t kFingerprint = .*\n", re.MULTILINE),
    re.compile(r"^ *LAWS_OWN_ENDS;\n", re.MULTILINE),
    re.compile(r"kParameters = \d+, "),
    re.compile(r"const float\*(?: p)?, |(?<=\()p, "),
)
_OF_STATE = (
    re.compile(r"^constexpr uint8_t kStates = 0;\n", re.MULTILINE),
    re.compile(r"^inline void start\(float\*\) {}\n", re.MULTILINE),
    re.compile(r"float\*(?: s)?, |(?<=\()s, "),
)
_COMMENT_WIDTH, _MOST = 105, 110
_GOES_ON = re.compile(r" +(?:&&|\|\||[-+*?:]) ")
_DIRECTIVE = re.compile(r"^#(?:pragma|include).*\n", re.MULTILINE)
_INCLUDED = re.compile(r'^#include "(\w+\.h)"', re.MULTILINE)
_INVERSE = re.compile(r"static laws::Inverse (\w+) ")
_RESULTS = re.compile(r"\bResults<([^<>]*)>")


def constants(environment: Environment, values: Mapping[str, float]) -> str:
    """Return the tuned values as named constants, each with its unit and label."""
    if not environment.parameters:
        return "// This environment has nothing to tune."
    codes = [_constant(p, values[p.key]) for p in environment.parameters]
    width = max(map(len, codes))
    rows = []
    for parameter, code in zip(environment.parameters, codes, strict=True):
        if isinstance(parameter, Choice):
            rows += [*comment(_options(parameter)), code]
        else:
            rows.append(
                f"{code:<{width}}  // {one_line(': '.join(filter(None, (parameter.unit, parameter.label))))}"
            )
    return "\n".join(["namespace tuned {", *rows, "}  // namespace tuned"])


def _constant(parameter: Parameter | Choice, value: float) -> str:
    """Return one tuned value; a choice is a whole number."""
    kind, text = ("int", str(int(value))) if isinstance(parameter, Choice) else ("float", number(value))
    return f"constexpr {kind} {mangled(parameter.key)} = {text};"


def one_line(words: str) -> str:
    """Return a person's words so that they cannot end a comment or go on into the next line."""
    return " ".join(words.split()).replace("\\", "/").replace("·", "*")


def _options(choice: Choice) -> str:
    return f"{choice.label}: {', '.join(f'{i} {option}' for i, option in enumerate(choice.options))}"


def law_text(environment: Environment, values: Mapping[str, float]) -> str:
    """Return the law with its helpers; raise LawError where it uses what a sketch does not have."""
    name = namespace(environment)
    text = _by_hand(CppLaw(environment.force, name).alone.headers) + translate_cpp(environment.force, name)
    for parameter in environment.parameters:
        name = f"tuned::{mangled(parameter.key)}"
        text = text.replace(f"p[{constant_name(parameter.key)}]", name)
        if values[parameter.key] != 0.0:  # what never changes is divided by once, by the compiler
            text = re.sub(rf"inverse\d+_\.(?:of|watched)\({name}\)", f"(1.0f / {name})", text)
    text = _without_idle(text)
    for pattern in (*_LEFT_OUT, *(() if environment.force.state_names else _OF_STATE)):
        text = pattern.sub("", text)
    text = (
        plain(text)
        .replace("FAST_ONCE ", "inline ")
        .replace("FAST_APART ", "")
        .replace("LAWS_NO_INVERSE", "{NAN, NAN}")
    )
    for choice in (p for p in environment.parameters if isinstance(p, Choice)):
        text = re.sub(rf"(\btuned::{mangled(choice.key)} (?:[=!<>]=|[<>]) -?\d+)\.0f", r"\1", text)
    text = "\n".join(_joined(text.split("\n")))
    text = _helpers(text) + _WITHIN.sub("", text)
    text = text.replace("}  // namespace laws\n\nnamespace laws {\n", "")
    whole = re.sub(r"\n{3,}", "\n\n", text)
    return "\n".join(words for line in whole.split("\n") for words in _lines(line))


def _joined(lines: list[str]) -> list[str]:
    """Return lines with what goes on after an operator back on its line, if it has room there by now."""
    made: list[str] = []
    for line in lines:
        before = made[-1] if made else ""
        goes_on = _GOES_ON.match(line) and "//" not in before + line
        if goes_on and len(before) + 1 + len(line.lstrip()) <= WIDTH:
            made[-1] = f"{before} {line.lstrip()}"
        else:
            made.append(line)
    return made


def _lines(line: str) -> list[str]:
    """Return a line that has become too long in several."""
    if len(line) <= WIDTH or (own := line.find("//")) < 0:
        return wrapped(line)
    if line[:own].strip() or len(line) <= _MOST:  # a comment behind code, or short enough
        return [line]
    return textwrap.wrap(line, _COMMENT_WIDTH, subsequent_indent=line[:own] + "// ")


def _by_hand(headers: Sequence[str]) -> str:
    """Return what the firmware has of a law that nobody translated, headers after those they include."""
    found: dict[str, str] = {}
    for name in headers:
        _include(name, found)
    return "".join(f"{_DIRECTIVE.sub('', text).strip()}\n\n" for text in found.values())


def _include(name: str, found: dict[str, str]) -> None:
    """Add a header's text; raise LawError where it is missing."""
    if name in found:
        return
    shipped, own = (
        resources.path("sketch", name),
        Path(__file__).parents[2] / "firmware/hapkit/laws" / name,
    )
    path = shipped if shipped.is_file() else own
    if not path.is_file():
        raise LawError(f"A sketch cannot render this law: {name} is missing. Install the studio again.")
    text = path.read_text("utf-8")
    for inner in _INCLUDED.findall(text):
        if inner != "law.h":
            _include(inner, found)
    found[name] = text


def _without_idle(text: str) -> str:
    """Return a law without the inverses that nobody asks for any more."""
    functions = re.split(r"(?<=\n)(?=inline |FAST_ONCE )", text)
    for at, function in enumerate(functions):
        for name in set(_INVERSE.findall(function)):
            if f"{name}." not in function:
                function = re.sub(rf"^ *static laws::Inverse {name} .*\n", "", function, flags=re.MULTILINE)
        functions[at] = function
    return "".join(functions)


def namespace(environment: Environment) -> str:
    """Return the name that the law has in the sketch."""
    return mangled(environment.key)


def _helpers(text: str) -> str:
    """Return the helpers that a law uses, in the file's order; raise LawError for one that is not there."""
    wanted = set(_NAMED.findall(text)) - {"Results"}
    wanted |= {"Inverse"} if "Inverse " in text else set()  # by hand it is named without where it stands
    wanted |= {"divisor"} if "Inverse" in wanted else set()
    wanted |= {"checked"} if wanted & {"divisor", "index", "spent"} else set()
    whole = resources.path("sketch", "helpers.txt").read_text("utf-8")
    parts = re.split(r"^=== (.*)\n", whole, flags=re.MULTILINE)
    known = list(zip(parts[1::2], parts[2::2], strict=True))
    missing = wanted - {name for names, _ in known for name in names.split()}
    if missing:
        raise LawError(f"A sketch cannot render this law: it has no {', '.join(sorted(missing))}.")
    used = [_results(text)] + [words.strip() for names, words in known if wanted & set(names.split())]
    used = [words for words in used if words]
    return "\n\n".join(["namespace laws {", *used, "}  // namespace laws\n\n"]) if used else ""


def _results(text: str) -> str:
    """Return what gives back several numbers at once, for as many as the law gives back."""
    counts = sorted({len(kinds.split(",")) for kinds in _RESULTS.findall(text)})
    if not counts:
        return ""
    lines = ["// What a function gives back that returns several numbers: .a, .b and so on."]
    lines += ["template <class... Kinds>", "struct Results;"]
    for count in counts:
        kinds = "ABCDEFGH"[:count]
        members = " ".join(f"{kind} {kind.lower()};" for kind in kinds)
        heads = ", ".join(f"class {kind}" for kind in kinds)
        lines += [f"template <{heads}>", f"struct Results<{', '.join(kinds)}> {{ {members} }};"]
    return "\n".join(lines)

"""A law as a sketch has it: its C with the tuned values by name, and the helpers that it needs."""

import re
from collections.abc import Mapping

from hapkit_studio import resources
from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import c_source
from hapkit_studio.laws.c_source import Source, mangled, number
from hapkit_studio.parameters import Choice


def translated(environment: Environment, values: Mapping[str, float]) -> Source:
    """Return a law's C; raise LawError where it leaves the law language."""
    return c_source.translate(environment.force, [values[p.key] for p in environment.force.parameters])


def constants(environment: Environment, values: Mapping[str, float], law: Source) -> str:
    """Return the values that the law uses as named constants with unit and label, its choices in words."""
    rows, lines = [], []
    for place, parameter in enumerate(environment.force.parameters):
        if isinstance(parameter, Choice):
            chosen = parameter.text(values[parameter.key])
            lines.append(f"// {one_line(parameter.label)}: {chosen}")
        elif place in law.parameters:
            about = ": ".join(filter(None, (parameter.unit, parameter.label)))
            code = f"  float {mangled(parameter.key)} = {number(values[parameter.key])};"
            rows.append((code, one_line(about)))
    width = max((len(code) for code, _ in rows), default=0)
    if rows:
        commented = [f"{code:<{width}}  // {about}" for code, about in rows]
        lines += ["constexpr struct {", *commented, "} p = {};"]
    return "\n".join(lines) or "// This environment has nothing to tune."


def one_line(words: str) -> str:
    """Return a person's words so that they cannot end a comment or go on into the next line."""
    return " ".join(words.split()).replace("\\", "/").replace("·", "*")


def text(law: Source) -> str:
    """Return the law in its namespace, behind the helpers that it needs."""
    pieces = re.split(r"^=== (.*)\n", resources.path("sketch", "helpers.txt").read_text("utf-8"), flags=re.M)
    known = zip(pieces[1::2], pieces[2::2], strict=True)
    helpers = [words.strip() for names, words in known if law.helpers & set(names.split())]
    return "\n\n".join(["namespace law {", *helpers, law.text, "}  // namespace law\n"])

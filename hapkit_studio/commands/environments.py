"""The command that lists the environments."""

import argparse

from hapkit_studio import environments as library
from hapkit_studio.commands.base import Command, Result, option
from hapkit_studio.environments.base import Environment
from hapkit_studio.parameters import AnyParameter, Choice

_HEAD = "| key | environment | what it does | state | modelled for it |\n|---|---|---|---|---|"
_COLUMNS = "| parameter | default | limits | what it is |\n|---|---|---|---|"


OPTIONS = (option("--markdown", action="store_true", help="as a page with pictures and explanations"),)


def environments(options: argparse.Namespace) -> Result:
    """List the environments with their parameters, units and limits, or print their reference page."""
    listed, lines = [], []
    for e in library.discover().values():
        lines.append(f"{e.key:<19} {e.summary}")
        described = []
        for p in e.parameters:
            word = p.options if p.discrete else [p.low, p.high]  # type: ignore[union-attr]
            default = p.text(p.default) if p.discrete else p.default
            described.append(
                {"key": p.key, "label": p.label, "unit": p.unit, "default": default, "range": word}
            )
            limits = " | ".join(p.options) if p.discrete else f"{p.low:,g} to {p.high:,g} {p.unit}"  # type: ignore[union-attr]
            lines.append(f"    {p.key:<19} {p.text(p.default):<12} [{limits}]")
        listed.append({"key": e.key, "title": e.title, "summary": e.summary, "parameters": described})
    text = page().rstrip() if options.markdown else "\n".join(lines)
    return Result(text, {"environments": listed})


def page() -> str:
    """Return the reference page of every discovered environment as Markdown."""
    head = f"# Environments\n\n{_HEAD}"
    for e in library.discover().values():
        state = ", ".join(f"`{name}`" for name in e.state_names) or "none"
        needs = ", ".join(e.needs) or "nothing"
        head += f"\n| `{e.key}` | {e.title} | {e.summary} | {state} | {needs} |"
    return "\n\n".join([head, *map(_section, library.discover().values())]) + "\n"


def _section(e: Environment) -> str:
    parts = [f"## {e.title}", f"![{e.title}](../pictures/{e.key}.png)", e.explained_formula, e.explanation]
    if e.parameters:
        parts.append("\n".join([_COLUMNS, *map(_parameter, e.parameters)]))
    return "\n\n".join([*parts, e.restless] if e.restless else parts)


def _parameter(p: AnyParameter) -> str:
    limits = ", ".join(p.options) if isinstance(p, Choice) else f"{p.low:,g} to {p.text(p.high)}"
    return f"| `{p.key}` | {p.text(p.default)} | {limits} | {p.help} |"


COMMAND = Command("environments", "list the environments and their parameters", environments, OPTIONS, 20)

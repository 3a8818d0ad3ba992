"""The library of environments as a page to read: what each does, its parameters, what it needs."""

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.parameters import AnyParameter, Choice

_HEAD = "| key | environment | what it does | state | modelled for it |\n|---|---|---|---|---|"
_COLUMNS = "| parameter | default | limits | what it is |\n|---|---|---|---|"


def markdown() -> str:
    """Return the page of every discovered environment, in Markdown."""
    library = environments.discover().values()
    rows = [_row(e) for e in library]
    head = f"# Environments\n\n{_HEAD}\n" + "\n".join(rows)
    return "\n\n".join([head, *map(_section, library)]) + "\n"


def _row(e: Environment) -> str:
    state = ", ".join(f"`{name}`" for name in e.state_names) or "none"
    return f"| `{e.key}` | {e.title} | {e.summary} | {state} | {', '.join(e.needs) or 'nothing'} |"


def _section(e: Environment) -> str:
    parts = [
        f"## {e.title}",
        f"![{e.title}](../pictures/{e.key}.png)",
        e.formula,
        e.explanation,
    ]
    if e.parameters:
        parts.append(_COLUMNS + "\n" + "\n".join(map(_parameter, e.parameters)))
    if e.restless:
        parts.append(e.restless)
    return "\n\n".join(parts)


def _parameter(p: AnyParameter) -> str:
    limits = ", ".join(p.options) if isinstance(p, Choice) else f"{p.low:g} to {p.text(p.high)}"
    return f"| `{p.key}` | {p.text(p.default)} | {limits} | {p.help} |"

"""The command that lists the environments."""

import argparse

from hapkit_studio import catalogue
from hapkit_studio import environments as library
from hapkit_studio.commands.base import Command, Result


def options(command: argparse.ArgumentParser) -> None:
    """Declare what ``environments`` takes."""
    command.add_argument("--markdown", action="store_true", help="as a page with pictures and explanations")


def environments(options: argparse.Namespace) -> Result:
    """List the environments with their parameters, units and limits, or print the page about them."""
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
            limits = " | ".join(p.options) if p.discrete else f"{p.low:g} to {p.high:g} {p.unit}"  # type: ignore[union-attr]
            lines.append(f"    {p.key:<19} {p.text(p.default):<12} [{limits}]")
        listed.append({"key": e.key, "title": e.title, "summary": e.summary, "parameters": described})
    text = catalogue.markdown().rstrip() if options.markdown else "\n".join(lines)
    return Result(text, {"environments": listed})


COMMAND = Command(
    "environments", "list the environments and their parameters", environments, options, order=20
)

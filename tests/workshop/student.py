"""Complete files as a student writes them, and functions that find their lines."""

import textwrap

from hapkit_studio.workshop.source import read

HEAD = '''"""A file of mine."""

import math

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter
'''
END = """
ENVIRONMENT = Environment(
    key="mine",
    title="Mine",
    summary="A law of mine",
    parameters=(
        Parameter("stiffness", "Stiffness", "N/m", 200.0, 0.0, 2000.0),
        Parameter("mass", "Mass", "kg", 0.1, 0.0, 1.0),
        Choice("side", "Side", ("right", "left")),
    ),
    force=force,
)
"""


def text(body="return -p.stiffness * x", state="", beside="", end=END):
    """Return a complete file: the law with this body, the code ``beside`` it, and the ENVIRONMENT.

    The code ``beside`` is below the law, because a law on other lines would be compiled again.
    """
    decorator = f"@law(state={state})" if state else "@law"
    body = textwrap.indent(textwrap.dedent(body).strip("\n"), "    ")
    return f"{HEAD}\n\n{decorator}\ndef force(p, s, x, v, dt):\n{body}\n\n\n{textwrap.dedent(beside)}{end}"


def line_of(whole, part):
    """Return the number of the first line that contains these words."""
    return next(n for n, line in enumerate(whole.split("\n"), 1) if part in line)


def write(folder, whole, name="mine.py"):
    """Write a file and return its path."""
    path = folder / name
    path.write_text(whole, encoding="utf-8", newline="")
    return path


def saved(folder, whole, name="mine.py"):
    """Write a file and return its content as a Source."""
    return read(write(folder, whole, name))

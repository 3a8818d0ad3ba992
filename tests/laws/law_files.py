"""Laws in files, as students write them, because a law's source is read from its file."""

import importlib.util
import itertools
import sys
import textwrap

from hapkit_studio import simulate
from hapkit_studio.dynamics.hand import Prescribed
from hapkit_studio.environments.base import Environment
from hapkit_studio.parameters import Choice, Parameter

PARAMETERS = (
    Parameter("stiffness", "Stiffness", "N/m", 200.0, -1e300, 1e300),
    Parameter("damping", "Damping", "N·s/m", 2.0, -1e300, 1e300),
    Choice("side", "Side", ("right", "left")),
)
HEAD = "import math\n\nfrom hapkit_studio.laws import law\n\n\n"
_names = itertools.count()


def module(folder, text):
    """Return the module of a file that has this text after HEAD."""
    return written(folder / f"student_{next(_names)}.py", HEAD + textwrap.dedent(text))


def written(path, text):
    """Write a file and return its module."""
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"{path.stem}_{path.parent.name}", path)
    made = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = made
    spec.loader.exec_module(made)
    return made


def environment(folder, text, parameters=PARAMETERS):
    """Return an environment of the law ``force`` in this text, or raise LawError if the law is invalid."""
    return Environment("student", "Student", "", parameters, module(folder, text).force)


def law_text(body, state="", beside=""):
    """Return a file's text, which has the code ``beside`` before the law with this body."""
    decorator = f"@law(state={state})" if state else "@law"
    lines = [textwrap.dedent(beside), decorator, "def force(p, s, x, v, dt):"]
    return "\n".join(lines) + "\n" + textwrap.indent(textwrap.dedent(body).strip("\n"), "    ") + "\n"


def line_of(text, part):
    """Return the number of the first line in the file that contains these words."""
    whole = HEAD + textwrap.dedent(text)
    return next(n for n, line in enumerate(whole.splitlines(), 1) if part in line)


def held(environment, **given):
    """Return a run of 50 ms with the handle held at 10 mm."""
    return simulate(environment, given, hand=Prescribed(lambda t: 0.010), seconds=0.05)

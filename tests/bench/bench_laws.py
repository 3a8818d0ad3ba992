"""Time of a tick with each law and option, relative to a tick with the free law."""

import numpy as np

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics import headless
from hapkit_studio.parameters import Choice
from tests.bench.bench_tick import TICKS, many_ticks, nanoseconds
from tests.bench.frame import Row

NAME, ORDER = "laws", 21
STATIC, ANY = 60.0, 250.0
# positions in m of a handle that moves to and fro, fast enough to slip and slowly enough for the cat to purr
SWEEP = 0.045 * np.sin(2.0 * np.pi * 0.3e-3 * np.arange(TICKS))


def per_tick(environment: Environment, values: dict[str, float]) -> float:
    """Return the time in ns of a tick with its law, while the handle moves across the rail."""
    r, _ = headless.Scene(environment, values).prepare()
    out = headless.new_rows(TICKS)
    return nanoseconds(lambda: many_ticks(r, SWEEP, 1e-3, out), TICKS)


def forms(environment: Environment) -> list[tuple[str, dict[str, float]]]:
    """Return (name, values) for the defaults, and for every option of every choice."""
    defaults = environment.values()
    found = [("", defaults)]
    for p in environment.parameters:
        if isinstance(p, Choice):
            others = [o for o in p.options if p.check(o) != p.default]
            found += [(option, {**defaults, p.key: p.check(option)}) for option in others]
    return found


def run() -> list[Row]:
    """Return one row per law, with its slowest option."""
    library = environments.discover()
    reference = per_tick(library["free"], {})
    found = []
    for key, environment in library.items():
        slowest, name = max((per_tick(environment, values), name) for name, values in forms(environment))
        limit = ANY if environment.state_names else STATIC
        label = f"tick, {key}" + (f" ({name})" if name else "")
        goal = f"< {limit:g} ns"
        found.append(
            Row(label, slowest, "ns", "tick, free", reference, slowest / reference, goal, slowest < limit)
        )
    return found

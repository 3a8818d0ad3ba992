"""An environment that a person wrote: its law only ever runs compiled, its words can raise nothing."""

import math
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.workshop import calls


@dataclass(frozen=True, kw_only=True)
class OwnEnvironment(Environment):
    """An environment read from a person's file: the file, and the text it had."""

    file: Path
    text: str

    def curve(self, values: Values, position: np.ndarray, velocity: float = 0.0) -> np.ndarray:
        """Return the compiled law's force (n,) in N, its state at the start; nan where it faults."""
        force = calls.once(self.force.compiled())
        p = np.array([values[q.key] for q in self.parameters] + [0.0])
        return np.array([force(p, x, velocity) for x in map(float, position)])


@cache
def built_in() -> Mapping[str, Environment]:
    """Return the studio's own environments by key, without those of other packages."""
    here = environments.__name__ + "."
    return {k: e for k, e in environments.discover().items() if e.force.function.__module__.startswith(here)}


def taken_keys() -> set[str]:
    """Return the keys of the studio's own environments: the names of their files, none of them loaded."""
    return {module.name for module in pkgutil.iter_modules(environments.__path__)}


def owned(environment: Environment, file: Path, text: str) -> OwnEnvironment:
    """Return an environment marked as a person's own; it has no shortcut."""
    given = {f.name: getattr(environment, f.name) for f in fields(Environment) if f.init}
    given |= {"parameters": tuple(environment.parameters), "shortcut": ""}
    given["check"] = _guarded(environment.check, str, lambda values: "")
    given["unused"] = _guarded(environment.unused, dict, lambda values: {})
    given["warnings"] = _guarded(environment.warnings, _lines, lambda values, conditions: ())
    if environment.impedance:
        given["impedance"] = _guarded(environment.impedance, pair, lambda values: (0.0, 0.0))
    for name in ("over_position", "over_velocity"):
        if given[name]:
            given[name] = _guarded(given[name], numbers, lambda values, along: np.full(len(along), math.nan))
    return OwnEnvironment(**given, file=file, text=text)


def pair(found) -> tuple[float, float]:
    """Return an impedance as two finite numbers; raise TypeError or ValueError."""
    stiffness, damping = map(float, found)
    if not (math.isfinite(stiffness) and math.isfinite(damping)):
        raise ValueError
    return stiffness, damping


def numbers(found) -> np.ndarray:
    """Return a curve's values as floats; raise TypeError or ValueError."""
    return np.asarray(found, dtype=float)


def _lines(found) -> tuple[str, ...]:
    return tuple(map(str, found))


def _guarded(function: Callable, convert: Callable, otherwise: Callable) -> Callable:
    """Return a function that gives something harmless where a person's own raises or gives nonsense."""

    def guarded(*args):
        try:
            return convert(function(*args))
        except Exception:  # whatever a person's function raises
            return otherwise(*args)

    return guarded

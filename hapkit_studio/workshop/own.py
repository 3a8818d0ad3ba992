"""An environment that a person wrote: its law only ever runs compiled, its functions in a program apart."""

import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache, partial

import numpy as np

from hapkit_studio import environments
from hapkit_studio.environments.base import Conditions, Environment, Values
from hapkit_studio.workshop import calls
from hapkit_studio.workshop.functions import Functions, brought
from hapkit_studio.workshop.source import Source


@dataclass(frozen=True, kw_only=True)
class OwnEnvironment(Environment):
    """An environment read from a person's file, and that file as it was read."""

    source: Source
    functions: Functions | None = None

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


def owned(environment: Environment, source: Source) -> OwnEnvironment:
    """Return an environment marked as a person's own; it has no shortcut."""
    given = {f.name: getattr(environment, f.name) for f in fields(Environment) if f.init}
    given |= {"parameters": tuple(environment.parameters), "shortcut": "", "terms": None}
    names = brought(environment)
    functions = Functions(source) if names else None
    if functions:
        given |= {name: partial(functions.call, name) for name in names}
        given["warnings"] = partial(_warnings, functions, given["warnings"])
    return OwnEnvironment(**given, source=source, functions=functions)


def switched_off(environment: Environment) -> list[str]:
    """Return the line that says which function of a person's file was switched off, if one was."""
    functions = environment.functions if isinstance(environment, OwnEnvironment) else None
    return [functions.off] if functions and functions.off else []


def _warnings(
    functions: Functions, theirs: Callable, values: Values, conditions: Conditions
) -> tuple[str, ...]:
    """Return a person's own warnings, and which function was switched off."""
    found = theirs(values, conditions)
    return (*found, functions.off) if functions.off else tuple(found)

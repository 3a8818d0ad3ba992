"""The library of virtual environments: one file each, found by the name ``ENVIRONMENT``."""

import importlib
import pkgutil
import sys
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from string import ascii_uppercase
from types import MappingProxyType, ModuleType

from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError

ENTRY_POINTS = "hapkit_studio.environments"
RESERVED = "ABFGHRT"
"""Letters that the window uses, or keeps for itself."""


@cache
def discover() -> Mapping[str, Environment]:
    """Return every environment by its key: this folder's, then those of installed packages."""
    found: list[object] = []
    for info in pkgutil.iter_modules(__path__, __name__ + "."):
        found.append(getattr(importlib.import_module(info.name), "ENVIRONMENT", None))
    found += [_from_elsewhere(point) for point in entry_points(group=ENTRY_POINTS)]
    known = sorted((e for e in found if isinstance(e, Environment)), key=lambda e: (e.order, e.title))
    return MappingProxyType({e.key: e for e in with_shortcuts(known)})


def with_shortcuts(known: Sequence[Environment]) -> list[Environment]:
    """Give environments that name no key a free letter, one of their title where there is one."""
    free = {c for c in ascii_uppercase if c not in RESERVED} - {e.shortcut for e in known}
    found = []
    for environment in known:
        if not environment.shortcut and free:
            letters = [c for c in environment.title.upper() if c in free] + sorted(free)
            free.discard(letters[0])
            environment = replace(environment, shortcut=letters[0])
        found.append(environment)
    return found


def _from_elsewhere(point: EntryPoint) -> object:
    """Load another package's environment; a broken one is left out with a warning, the studio goes on."""
    try:
        return point.load()
    except Exception as error:  # whatever a stranger's module raises
        warnings.warn(f"Environment {point.name!r} ({point.value}) cannot be loaded: {error}", stacklevel=3)
        return None


def named(key: str) -> Environment:
    """Return the environment of a key; raise ParameterError listing those there are."""
    library = discover()
    if not isinstance(key, str) or key not in library:
        raise ParameterError(f"There is no environment {key!r}; there are: {', '.join(library)}.")
    return library[key]


class _Library(ModuleType):
    """Lets ``hapkit_studio.environments()`` be the library and ``hapkit_studio.environments`` its folder."""

    def __call__(self) -> Mapping[str, Environment]:
        return discover()


sys.modules[__name__].__class__ = _Library

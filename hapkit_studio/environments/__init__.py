"""The library of virtual environments; each module with an ``ENVIRONMENT`` defines one."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from string import ascii_uppercase
from types import MappingProxyType, ModuleType

from hapkit_studio import discovery
from hapkit_studio.environments.base import Environment

ENTRY_POINTS = "hapkit_studio.environments"
RESERVED = "ABFGHLRT"
"""Letters reserved for the window's shortcuts."""


@cache
def discover() -> Mapping[str, Environment]:
    """Return every environment by its key: those of this folder, then those of installed packages."""
    found = discovery.declared(__name__, "ENVIRONMENT", Environment, group=ENTRY_POINTS)
    known = sorted(found, key=lambda e: (e.order, e.title))
    return MappingProxyType({e.key: e for e in with_shortcuts(known)})


def with_shortcuts(known: Sequence[Environment]) -> list[Environment]:
    """Assign a free shortcut to environments that have none, preferably a letter of their title."""
    free = {c for c in ascii_uppercase if c not in RESERVED} - {e.shortcut for e in known}
    found = []
    for environment in known:
        if not environment.shortcut and free:
            letters = [c for c in environment.title.upper() if c in free] + sorted(free)
            free.discard(letters[0])
            environment = replace(environment, shortcut=letters[0])
        found.append(environment)
    return found


def named(key: str) -> Environment:
    """Return an environment by its key; raise ParameterError for an unknown key."""
    return discovery.named(discover(), key, "environment")


class _Library(ModuleType):
    """Makes ``hapkit_studio.environments()`` return the library, although the name is a package."""

    def __call__(self) -> Mapping[str, Environment]:
        return discover()


sys.modules[__name__].__class__ = _Library

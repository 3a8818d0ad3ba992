"""The library of virtual environments: one file each, found by the name ``ENVIRONMENT``."""

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
"""Letters that the window uses, or keeps for itself."""


@cache
def discover() -> Mapping[str, Environment]:
    """Return every environment by its key: this folder's, then those of installed packages."""
    found = discovery.declared(__name__, "ENVIRONMENT", Environment, group=ENTRY_POINTS)
    known = sorted(found, key=lambda e: (e.order, e.title))
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


def named(key: str) -> Environment:
    """Return the environment of a key; raise ParameterError listing those there are."""
    return discovery.named(discover(), key, "environment")


class _Library(ModuleType):
    """Lets ``hapkit_studio.environments()`` be the library and ``hapkit_studio.environments`` its folder."""

    def __call__(self) -> Mapping[str, Environment]:
        return discover()


sys.modules[__name__].__class__ = _Library

"""The library of virtual environments: one file each, found by the name ``ENVIRONMENT``."""

import sys
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType, ModuleType

from hapkit_studio import discovery
from hapkit_studio.environments.base import Environment

ENTRY_POINTS = "hapkit_studio.environments"


@cache
def discover() -> Mapping[str, Environment]:
    """Return every environment by its key: this folder's, then those of installed packages."""
    found = discovery.declared(__name__, "ENVIRONMENT", Environment, group=ENTRY_POINTS)
    return MappingProxyType({e.key: e for e in sorted(found, key=lambda e: (e.order, e.title))})


def named(key: str) -> Environment:
    """Return the environment of a key; raise ParameterError listing those there are."""
    return discovery.named(discover(), key, "environment")


class _Library(ModuleType):
    """Lets ``hapkit_studio.environments()`` be the library and ``hapkit_studio.environments`` its folder."""

    def __call__(self) -> Mapping[str, Environment]:
        return discover()


sys.modules[__name__].__class__ = _Library

"""Failures of rendering methods beyond a limit. Each module with a ``FAILURE`` defines one failure."""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from hapkit_studio import discovery
from hapkit_studio.analysis.failures.base import Failure
from hapkit_studio.discovery import declared


@cache
def failures() -> Mapping[str, Failure]:
    """Return every failure by its key, in order."""
    found = declared(__name__, "FAILURE", Failure)
    return MappingProxyType({f.key: f for f in sorted(found, key=lambda f: (f.order, f.title))})


def named(key: str) -> Failure:
    """Return a failure by its key; for an unknown key, raise ParameterError with a list of the keys."""
    return discovery.named(failures(), key, "failure")

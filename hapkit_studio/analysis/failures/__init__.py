"""Where methods fail: one file a failure, found by the name ``FAILURE``."""

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from hapkit_studio.analysis.failures.base import Case, Chart, Evidence, Failure, Line, Live, Mark
from hapkit_studio.errors import ParameterError

__all__ = ["Case", "Chart", "Evidence", "Failure", "Line", "Live", "Mark", "failures", "named"]


@cache
def failures() -> Mapping[str, Failure]:
    """Return every failure by its key, in their order."""
    modules = [importlib.import_module(info.name) for info in pkgutil.iter_modules(__path__, __name__ + ".")]
    found = [m.FAILURE for m in modules if isinstance(getattr(m, "FAILURE", None), Failure)]
    return MappingProxyType({f.key: f for f in sorted(found, key=lambda f: (f.order, f.title))})


def named(key: str) -> Failure:
    """Return the failure of a key; raise ParameterError listing those there are."""
    library = failures()
    if not isinstance(key, str) or key not in library:
        raise ParameterError(f"There is no failure {key!r}; there are: {', '.join(library)}.")
    return library[key]

"""Finds declarations in a package's modules, so that a new feature needs only a new module."""

import warnings
from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from pkgutil import iter_modules
from typing import TypeVar

from hapkit_studio.errors import ParameterError

T = TypeVar("T")


def declared(package: str, name: str, kind: type[T], *, group: str = "") -> list[T]:
    """Import all modules of a package; return the objects declared under a name, in the modules' order.

    Modules without the name, or with an object of another type, are ignored. Objects of other installed
    packages follow; ``group`` is the group of their entry points.
    """
    found = [
        getattr(import_module(info.name), name, None)
        for info in iter_modules(import_module(package).__path__, package + ".")
    ]
    if group:
        found += [_loaded(point) for point in entry_points(group=group)]
    return [one for one in found if isinstance(one, kind)]


def assigning(folder: Path, name: str) -> list[str]:
    """Return the modules in a folder whose text assigns a name, sorted; the modules are not imported."""
    files = (*folder.glob("*.py"), *folder.glob("*/__init__.py"))
    found = [file for file in files if f"\n{name} = " in file.read_text(encoding="utf-8")]
    return sorted(file.parent.name if file.stem == "__init__" else file.stem for file in found)


def _loaded(point: EntryPoint) -> object:
    """Load an object of another package; if this fails, warn and return None."""
    try:
        return point.load()
    except Exception as error:  # another package's module can raise any exception
        warnings.warn(f"{point.name!r} ({point.value}) cannot be loaded: {error}", stacklevel=4)
        return None


def named(library: Mapping[str, T], key: object, what: str) -> T:
    """Return the entry with a key.

    ``what`` is the kind of the entry, for the message. Raise ParameterError for an unknown key; its message
    lists the known keys.
    """
    if not isinstance(key, str) or key not in library:
        raise ParameterError(f"There is no {what} {key!r}; available: {', '.join(library)}.")
    return library[key]

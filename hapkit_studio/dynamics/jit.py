"""numba options: compiled code is cached, runs without the GIL, and cannot raise exceptions.

numba's reference counting is off: compiled code allocates nothing, and counting the references to a loop's
arrays at each call took ten times as long as a tick. No C wrapper is compiled, because none is used.
"""

import atexit
import functools
import os
import shutil
import tempfile
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import platformdirs
from numba import config, njit
from numba.core import caching
from numba.np import linalg

from hapkit_studio import program
from hapkit_studio.resources import PACKAGE, sources_stamp

UNUSED_SECONDS = 60 * 86_400.0  # a cache folder of other sources is removed if it is unused for this time
# folders of the package with compiled functions; a law's compiled file needs no entry, because its name
# contains a hash of the law
_COMPILED = ("analysis", "devices", "dynamics", "haptics", "laws", "protocol")


def _probe():
    """Do nothing; this function is used to find numba's cache."""


def forget_outdated(package: Path = PACKAGE) -> None:
    """Remove the compiled code next to the sources if it belongs to outdated sources.

    numba checks only the file of the function itself. After an update it would call an outdated version from
    another file, or fail because of a missing module.
    """
    folder = package / "__pycache__"
    mark = folder / f"compiled-{sources_stamp(*_COMPILED, package=package)}"
    try:
        folder.mkdir(exist_ok=True)
        mark.touch(exist_ok=False)
        for old in folder.glob("compiled-*"):
            if old != mark:
                old.unlink(missing_ok=True)
        for old in package.rglob("__pycache__/*.nb[ci]"):
            old.unlink(missing_ok=True)
    except OSError:
        return  # this was already done, or the folder is read-only and numba's cache is elsewhere


class ShippedCacheLocator(caching._CacheLocator):
    """Finds the machine code of functions in a bundle, which may be read-only."""

    def __init__(self, py_func, py_file):
        self._line = py_func.__code__.co_firstlineno
        self._folder = program.machine_code_folder(py_file)

    def get_cache_path(self):
        return str(self._folder)

    def get_source_stamp(self):
        return _shipped_stamp()

    def get_disambiguator(self):
        return str(self._line)

    @classmethod
    def from_function(cls, py_func, py_file):
        locator = cls(py_func, py_file)
        if locator._folder is None:
            return None
        name = py_func.__qualname__.replace("<", "").replace(">", "")  # numba names its files in this way
        index = f"{Path(py_file).stem}.{name}-{locator._line}.*.nbi"
        return locator if program.FILLING or any(locator._folder.glob(index)) else None


@functools.cache
def _shipped_stamp() -> str:
    return program.STAMP.read_text(encoding="ascii")


def configure(**options: str) -> None:
    """Set options of numba here and in child processes.

    The options are also set in the environment, because numba reads all options again at the next compilation
    if the environment has changed.
    """
    for name, value in options.items():
        setattr(config, name, value)
        os.environ[f"NUMBA_{name}"] = value


def set_cache(folder: str) -> None:
    """Set the folder for machine code, and mark it as chosen by the studio."""
    configure(CACHE_DIR=folder)
    os.environ[program.OWN_CACHE] = folder


def use_user_cache() -> None:
    """Write machine code to the user's cache, in a folder for these sources; remove folders unused for long.

    Machine code next to the sources would remain after the package was uninstalled.
    """
    folders = Path(platformdirs.user_cache_dir("hapkit-studio", appauthor=False)) / "machine-code"
    folder = folders / sources_stamp(*_COMPILED)
    set_cache(str(folder))
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        for other in folders.iterdir():
            if time.time() - other.stat().st_mtime > UNUSED_SECONDS:
                shutil.rmtree(other, ignore_errors=True)


def use_bundle() -> None:
    """Compile for the bundle's baseline processor, and read the bundle's machine code."""
    baseline = program.baseline()
    if baseline is not None:
        configure(CPU_NAME=baseline, CPU_FEATURES="")
    if program.uses_shipped_code():
        own = f"{__name__}.{ShippedCacheLocator.__name__}"
        configure(CACHE_LOCATOR_CLASSES=f"{own},UserProvidedCacheLocator")


def allow_unsaved() -> None:
    """Allow compiled code that cannot be saved, e.g. on a full disk or in a read-only bundle."""
    save = caching.Cache.save_overload

    def save_if_possible(cache, signature, data):
        with suppress(OSError):
            save(cache, signature, data)

    caching.Cache.save_overload = save_if_possible


def find_cache() -> None:
    """Set a temporary cache folder for numba if none of numba's folders is writable.

    Otherwise numba caches compiled code next to the source or in the user's cache. Child processes inherit
    the folder.
    """
    try:
        njit(cache=True)(_probe)
    except RuntimeError:
        set_cache(tempfile.mkdtemp(prefix="hapkit-studio-"))
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def _no_blas() -> None:
    raise ImportError("No compiled function here uses BLAS.")


def skip_blas() -> None:
    """Keep numba from importing scipy's linear algebra, which makes each start 0.1 s faster.

    Functions that need linear algebra import it when they are compiled.
    """
    linalg.ensure_blas, ensure = _no_blas, linalg.ensure_blas
    import numba.np.arraymath  # noqa: F401

    linalg.ensure_blas = ensure


skip_blas()
allow_unsaved()
if program.BUNDLED:
    use_bundle()
if not config.CACHE_DIR:
    if program.INSTALLED:
        use_user_cache()
    else:
        forget_outdated()
find_cache()
_options = partial(njit, cache=True, nogil=True, error_model="numpy", _nrt=False, no_cfunc_wrapper=True)

compiled = _options()
# for functions that only compiled code calls: a Python wrapper takes as long to compile as the function
internal = _options(no_cpython_wrapper=True)
# for functions that every tick calls: passing the loop's arrays copies about a hundred words per call
inlined = _options(forceinline=True, no_cpython_wrapper=True)
# the same for functions that Python also calls
inlined_and_called = _options(forceinline=True)

"""numba options: cached, without the GIL, nothing that can raise.

Without numba's reference counting: compiled code allocates nothing, and counting a loop's arrays at each call
took ten times as long as a tick. No C wrapper is made, as none is used.
"""

import atexit
import os
import shutil
import tempfile
from functools import partial
from pathlib import Path

from numba import config, njit
from numba.np import linalg

from hapkit_studio.resources import PACKAGE, sources_stamp

# folders of the package with compiled functions; a law's file is named by its hash
_COMPILED = ("analysis", "devices", "dynamics", "haptics", "laws", "protocol")


def _probe():
    """Placeholder for any cached function."""


def forget_outdated(package: Path = PACKAGE) -> None:
    """Remove compiled code of other sources, next to the source.

    numba checks a function's own file only: after an update it would call an outdated version of another
    file, or fail on a missing module.
    """
    kept = package / "__pycache__"
    mark = kept / f"compiled-{sources_stamp(*_COMPILED, package=package)}"
    try:
        kept.mkdir(exist_ok=True)
        mark.touch(exist_ok=False)
        for old in kept.glob("compiled-*"):
            if old != mark:
                old.unlink(missing_ok=True)
        for old in package.rglob("__pycache__/*.nb[ci]"):
            old.unlink(missing_ok=True)
    except OSError:
        return  # already checked, or read-only, and numba's cache is elsewhere


def find_cache() -> None:
    """Set a temporary cache folder for numba if none of its own is writable.

    Otherwise it caches compiled code next to the source or in the user's cache. Child processes inherit the
    folder.
    """
    try:
        njit(cache=True)(_probe)
    except RuntimeError:
        config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = tempfile.mkdtemp(prefix="hapkit-studio-")
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def _no_blas() -> None:
    raise ImportError("No compiled function here uses BLAS.")


def skip_blas() -> None:
    """Keep numba from importing scipy's linear algebra, which saves 0.1 s of each start.

    Functions that need it import it at compile time.
    """
    linalg.ensure_blas, ensure = _no_blas, linalg.ensure_blas
    import numba.np.arraymath  # noqa: F401

    linalg.ensure_blas = ensure


skip_blas()
if not config.CACHE_DIR:
    forget_outdated()
find_cache()
_options = partial(njit, cache=True, nogil=True, error_model="numpy", _nrt=False, no_cfunc_wrapper=True)

compiled = _options()
# for functions called from compiled code only: a Python wrapper costs as much compile time as the function
internal = _options(no_cpython_wrapper=True)
# for functions called in every tick: passing the loop's arrays costs about a hundred words per call
inlined = _options(forceinline=True, no_cpython_wrapper=True)
# the same for functions that Python calls, too
inlined_and_called = _options(forceinline=True)

"""How compiled code is compiled: cached, without the GIL, and with nothing in it that can raise.

Without numba's reference counting too: it allocates nothing, and counting the arrays of a loop at every
call took ten times as long as a tick itself. Nothing calls it as a C function, so none is made.
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

# The package's folders with compiled functions; a law's file is named by what is in it.
_COMPILED = ("analysis", "devices", "dynamics", "haptics", "laws", "protocol")


def _probe():
    """Stand in for any function that is to be cached."""


def forget_outdated(package: Path = PACKAGE) -> None:
    """Remove what was compiled from other sources, beside the source.

    numba looks at a function's own file alone: after an update it would call what another file had, or fail
    on a module that is gone.
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
        return  # known already, or nothing may be written here and numba keeps it elsewhere


def find_cache() -> None:
    """Give numba a folder for as long as this program runs where it finds none that it may write to.

    Otherwise it keeps compiled code beside the source or in the user's cache. Programs started from here use
    the same folder.
    """
    try:
        njit(cache=True)(_probe)
    except RuntimeError:
        config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = tempfile.mkdtemp(prefix="hapkit-studio-")
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def _no_blas() -> None:
    raise ImportError("No compiled function here uses BLAS.")


def skip_blas() -> None:
    """Keep numba from importing scipy's linear algebra as it loads its own modules: 0.1 s of each start.

    A function that needs it imports it when it is compiled.
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
# For what only compiled code calls: a way in from Python costs as much compiling as the function itself.
internal = _options(no_cpython_wrapper=True)
# A call hands over every array of a loop, a hundred words: what runs at every tick is copied into its caller.
inlined = _options(forceinline=True, no_cpython_wrapper=True)
# The same for what Python calls too.
inlined_and_called = _options(forceinline=True)

"""How compiled code is compiled: cached, without the GIL, and with nothing in it that can raise.

Without numba's reference counting too: it allocates nothing, and counting the arrays of a loop at every
call took ten times as long as a tick itself. Nothing calls it as a C function, so none is made.
"""

import atexit
import os
import shutil
import tempfile
from functools import partial

from numba import config, njit


def _probe():
    """Stand in for any function that is to be cached."""


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


find_cache()
_options = partial(njit, cache=True, nogil=True, error_model="numpy", _nrt=False, no_cfunc_wrapper=True)

compiled = _options()
# For what only compiled code calls: a way in from Python costs as much compiling as the function itself.
internal = _options(no_cpython_wrapper=True)
# A call hands over every array of a loop, a hundred words: what runs at every tick is copied into its caller.
inlined = _options(forceinline=True)

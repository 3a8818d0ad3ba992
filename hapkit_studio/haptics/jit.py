"""How the loop's code is compiled: cached, without the GIL, and with nothing in it that can raise.

Without numba's reference counting too: it allocates nothing, and counting the arrays of a rig at every
call took ten times as long as the tick itself.
"""

from numba import njit

compiled = njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
# A call hands over every array of a rig, a hundred words: what runs at every tick is copied into its caller.
inlined = njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)

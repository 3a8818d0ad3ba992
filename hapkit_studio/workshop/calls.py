"""Calls of a compiled law: many in a row from compiled code, or one at a time without compiling anything."""

import ctypes
import math
from collections.abc import Callable

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.laws import native
from hapkit_studio.laws.law import CompiledLaw
from hapkit_studio.laws.native import FAULT_WORDS

# what `run` returns where every call gave a force
ALL = -1
_DT = 1e-3

_real, _reals = ctypes.c_double, ctypes.POINTER(ctypes.c_double)
_Function = ctypes.CFUNCTYPE(_real, _reals, _reals, _real, _real, _real, ctypes.POINTER(ctypes.c_int64))


@compiled
def run(address, p, s, x, v, dt, fault, force):
    """Call a law at every x (n,) m and v (n,) m/s into force (n,) N; return the call that failed, or ALL.

    fault holds FAULT_WORDS words, the code being 0 where there is none.
    """
    for i in range(len(x)):
        force[i] = native.call(address, p, s, x[i], v[i], dt, fault)
        if fault[0] != 0:
            return i
    return ALL


def memory(law: CompiledLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return a law's state at its start, with a spare value where it has none, and its fault words."""
    return np.append(law.initial_state, 0.0), np.zeros(FAULT_WORDS, dtype=np.int64)


def once(law: CompiledLaw) -> Callable[[np.ndarray, float, float], float]:
    """Return a law as a function (parameters, x m, v m/s) -> N, its state at the start; nan where it faults.

    numba would compile a way in from Python, for a tenth of a second in which a window stands still.
    """
    if not native.INTERPRETED:
        function = _Function(law.address)

    def force(p: np.ndarray, x: float, v: float) -> float:
        state, fault = memory(law)
        if native.INTERPRETED:
            found = native.call(law.address, p, state, x, v, _DT, fault)
        else:
            found = function(
                p.ctypes.data_as(_reals),
                state.ctypes.data_as(_reals),
                x,
                v,
                _DT,
                fault.ctypes.data_as(ctypes.POINTER(ctypes.c_int64)),
            )
        return math.nan if fault[0] else float(found)

    return force

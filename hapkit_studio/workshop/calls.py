"""Calls of a compiled law in a row, from compiled code."""

import math

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.laws import native

# what `run` returns where every call gave a force
ALL = -1
NOT_FINITE = 1


@compiled
def run(address, p, s, x, v, dt, fault, force):
    """Call a law at every x (n,) m and v (n,) m/s into force (n,) N; return the call that failed, or ALL.

    fault is the law's two words: the code, 0 for none, and the line.
    """
    for i in range(len(x)):
        force[i] = native.call(address, p, s, x[i], v[i], dt, fault)
        if fault[0] != 0 or not math.isfinite(force[i]):
            if fault[0] == 0:
                fault[0] = NOT_FINITE
                fault[1] = 0
            return i
    return ALL


def memory(initial_state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a law's state at its start, with a spare value where it has none, and two fault words."""
    return np.append(initial_state, 0.0), np.zeros(2, dtype=np.int64)

"""Calls an environment's compiled law, sample by sample."""

import numpy as np

from hapkit_studio import environments
from hapkit_studio.laws import native

LIBRARY = environments.discover()


def call(environment, values, x, v, state=None):
    """Return (force, state, fault code) of the compiled law."""
    law = environment.force.compiled()
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    s = np.append(law.initial_state, 0.0) if state is None else state
    fault = np.zeros(3, dtype=np.int64)
    return native.call(law.address, p, s, x, v, 1e-3, fault), s, fault[0]

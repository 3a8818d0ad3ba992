"""Calls an environment's compiled law, sample by sample, with values at every corner or anywhere."""

import itertools
import math

import numpy as np

from hapkit_studio import environments
from hapkit_studio.laws import native
from hapkit_studio.parameters import Choice

LIBRARY = environments.discover()


def call(environment, values, x, v, state=None):
    """Return (force, state, fault code) of the compiled law."""
    law = environment.force.compiled()
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    s = np.append(law.initial_state, 0.0) if state is None else state
    fault = np.zeros(native.FAULT_WORDS, dtype=np.int64)
    return native.call(law.address, p, s, x, v, 1e-3, fault), s, fault[0]


def corners(environment):
    """Return every combination of the least, the default and the largest value of each parameter.

    Those that do not go together are left out; of more than 800 every so manieth is taken.
    """
    each = []
    for p in environment.parameters:
        some = range(len(p.options)) if isinstance(p, Choice) else (p.low, p.default, p.high)
        each.append([(p.key, float(value)) for value in some])
    count = math.prod(map(len, each))
    taken = itertools.islice(itertools.product(*each), 0, None, max(count // 800, 1))
    return [values for values in map(dict, taken) if not environment.check(values)]


def anywhere(environment, rng):
    """Return values anywhere within the limits that go together."""
    while True:
        values = {
            p.key: float(rng.integers(len(p.options)))
            if isinstance(p, Choice)
            else rng.uniform(p.low, p.high)
            for p in environment.parameters
        }
        if not environment.check(values):
            return values

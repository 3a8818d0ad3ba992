"""Functions that call an environment's compiled law once or along a path, or run an imposed motion."""

import itertools
import math

import numpy as np

import hapkit_studio as hs
from hapkit_studio import environments
from hapkit_studio.environments.base import Conditions
from hapkit_studio.laws import native
from hapkit_studio.parameters import Choice

LIBRARY = environments.discover()


def call(environment, values, x, v, state=None):
    """Return (force, state, fault code) of one call of the compiled law, by default in its initial state."""
    law = environment.force.compiled()
    p = np.array([values[q.key] for q in environment.parameters] + [0.0])
    s = np.append(law.initial_state, 0.0) if state is None else state
    fault = np.zeros(native.FAULT_WORDS, dtype=np.int64)
    return native.call(law.address, p, s, x, v, 1e-3, fault), s, fault[0]


def corners(environment):
    """Return every combination of the smallest, default and largest value of each parameter.

    Incompatible combinations are left out. If more than 800 remain, an evenly spaced subset is returned.
    """
    each = []
    for p in environment.parameters:
        some = range(len(p.options)) if isinstance(p, Choice) else (p.low, p.default, p.high)
        each.append([(p.key, float(value)) for value in some])
    count = math.prod(map(len, each))
    taken = itertools.islice(itertools.product(*each), 0, None, max(count // 800, 1))
    return [values for values in map(dict, taken) if not environment.check(values)]


def drawn(environment, rng):
    """Return random values within the limits, which may be incompatible."""
    return {
        p.key: float(rng.integers(len(p.options))) if isinstance(p, Choice) else rng.uniform(p.low, p.high)
        for p in environment.parameters
    }


def anywhere(environment, rng):
    """Return random compatible values within the limits."""
    while environment.check(values := drawn(environment, rng)):
        pass
    return values


def warned(key, conditions=None, **given):
    """Return an environment's warnings for values that differ from the defaults."""
    environment = LIBRARY[key]
    return list(environment.warnings(environment.values(given), conditions or Conditions()))


def force(key, x, v=0.0, **given):
    """Return the force in N at one position and velocity, in the law's initial state."""
    return call(LIBRARY[key], LIBRARY[key].values(given), x, v)[0]


def forces(key, positions, **given):
    """Return the forces (n,) in N on a handle at rest at positions (n,) in m."""
    return np.array([force(key, x, **given) for x in positions])


def along(key, positions, velocities=None, **given):
    """Return forces (n,) and states (n, values) at consecutive positions (n,) in m, 1 ms apart."""
    values, state, out, states = LIBRARY[key].values(given), None, [], []
    velocities = np.zeros(len(positions)) if velocities is None else velocities
    for x, v in zip(positions, velocities, strict=True):
        asked, state, fault = call(LIBRARY[key], values, x, v, state)
        assert fault == 0
        out.append(asked)
        states.append(state[:-1].copy())
    return np.array(out), np.array(states)


def frequency(signal, rate):
    """Return the strongest frequency in Hz of a signal (n,), after its mean is removed."""
    spectrum = np.abs(np.fft.rfft(signal - np.mean(signal)))
    return np.fft.rfftfreq(len(signal), 1.0 / rate)[np.argmax(spectrum)]


IDEAL = hs.SimulatedHapkit(quantum=0.0, max_force=math.inf)


def imposed(key, values, position, seconds, rate=1000.0):
    """Return a run whose handle follows an imposed motion."""
    return hs.simulate(key, values, hand=hs.Prescribed(position), device=IDEAL, rate=rate, seconds=seconds)


def column(run, name):
    return run.state[:, run.state_names.index(name)]


def smoothly(t, start, end, seconds):
    share = min(max(t / seconds, 0.0), 1.0)
    return start + (end - start) * (0.5 - 0.5 * math.cos(math.pi * share))

"""Asks compiled laws by their environment's key: one sample, or a whole path with the law's memory."""

import numpy as np

from tests.environments.calling import LIBRARY, call


def force(key, x, v=0.0, **given):
    """Return the force in N at one position and velocity, the law's state at its start."""
    return call(LIBRARY[key], LIBRARY[key].values(given), x, v)[0]


def forces(key, positions, **given):
    """Return the forces (n,) in N at rest at positions (n,) in m."""
    return np.array([force(key, x, **given) for x in positions])


def along(key, positions, velocities=None, **given):
    """Return forces (n,) and states (n, values) at positions (n,) in m, one after the other, 1 ms apart."""
    values, state, out, states = LIBRARY[key].values(given), None, [], []
    velocities = np.zeros(len(positions)) if velocities is None else velocities
    for x, v in zip(positions, velocities, strict=True):
        asked, state, fault = call(LIBRARY[key], values, x, v, state)
        assert fault == 0
        out.append(asked)
        states.append(state[:-1].copy())
    return np.array(out), np.array(states)


def frequency(signal, rate):
    """Return the strongest frequency in Hz of a signal (n,), its mean left out."""
    spectrum = np.abs(np.fft.rfft(signal - np.mean(signal)))
    return np.fft.rfftfreq(len(signal), 1.0 / rate)[np.argmax(spectrum)]

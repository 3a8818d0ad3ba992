"""Runs of the cat: a handle that is led whatever the cat does, and one way to make it purr."""

import numpy as np

import hapkit_studio as hs
from hapkit_studio.dynamics.hand import SCRIPTS, Prescribed

IDEAL = hs.SimulatedHapkit(quantum=0.0)


def column(run, name):
    return run.state[:, run.state_names.index(name)]


def moved(position, seconds, device=IDEAL, rate=1000.0, **values):
    """Return the run of a handle that is led along position(t), whatever the cat does."""
    return hs.simulate("cat", values, hand=Prescribed(position), device=device, seconds=seconds, rate=rate)


def contented(t):
    """Move as five pets and a half, end on a stroke with the nap and stay there."""
    return SCRIPTS["pet"].target(np.minimum(t, 0.6 + 11 * 1.2))


RESTED = 0.6 + 11 * 1.2 + 0.2  # s, when the hand has been still for long enough

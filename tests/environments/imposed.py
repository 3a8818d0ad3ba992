"""Runs of a moving object under a handle whose motion is imposed."""

import math

import hapkit_studio as hs

IDEAL = hs.SimulatedHapkit(quantum=0.0, max_force=math.inf)


def imposed(key, values, position, seconds, rate=1000.0):
    """Return a run in which the handle moves as told."""
    return hs.simulate(key, values, hand=hs.Prescribed(position), device=IDEAL, rate=rate, seconds=seconds)


def column(run, name):
    return run.state[:, run.state_names.index(name)]


def smoothly(t, start, end, seconds):
    share = min(max(t / seconds, 0.0), 1.0)
    return start + (end - start) * (0.5 - 0.5 * math.cos(math.pi * share))

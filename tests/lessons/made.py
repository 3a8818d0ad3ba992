"""Samples computed from formulas, and functions that return wrong variants of given samples."""

from dataclasses import replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.lessons import Samples
from hapkit_studio.sessions import settings_events

RATE = 1000.0


def samples(key, values, position, force, energy=None, state=None, **settings):
    """Return samples at 1 kHz of a scene, with positions (n,) in m and forces (n,) in N."""
    environment = environments.named(key)
    n = len(position)
    time = np.arange(n) / RATE
    event = {
        **settings_events.of_scene(environment, environment.values(values)),
        "rate_Hz": RATE,
        "delay_s": 0.0,
        "estimator": "difference",
        "quantum_m": 1e-6,
        **settings,
    }
    return Samples(
        time,
        np.asarray(position, float),
        np.gradient(position, time),
        np.asarray(force, float),
        np.asarray(force, float),
        np.zeros(n) if energy is None else energy,
        np.zeros(n, int),
        np.zeros((n, 4)) if state is None else state,
        [(0.0, event)],
    )


def stronger(found, factor):
    """Return samples whose forces are larger by a factor."""
    return replace(
        found,
        force=factor * found.force,
        applied_force=factor * found.applied_force,
        energy=factor * found.energy,
    )


def larger(found, factor):
    """Return samples whose movement is larger by a factor."""
    return replace(found, position=factor * found.position, velocity=factor * found.velocity)


def still(found):
    """Return samples of a handle that stays in the middle, without force."""
    zero = np.zeros(len(found))
    return replace(
        found, position=zero, velocity=zero, force=zero, applied_force=zero, energy=zero,
        state=np.zeros_like(found.state),
    )  # fmt: skip


def elsewhere(found, key="free"):
    """Return samples that were recorded in another environment."""
    environment = environments.named(key)
    log = [
        (when, {**event, **settings_events.of_scene(environment, environment.values()), "state_names": []})
        for when, event in found.log
    ]
    return replace(found, log=log)


def slower(found, factor):
    """Return samples whose duration is longer by a factor."""
    log = [(factor * when, event) for when, event in found.log]
    return replace(found, time=factor * found.time, log=log)


def slowing(found):
    """Return samples whose time steps grow by 6 % per second, so that the speeds decrease."""
    steps = np.diff(found.time, prepend=found.time[0]) * np.exp(0.06 * (found.time - found.time[0]))
    return replace(found, time=np.cumsum(steps))


def other_state(found, factor):
    """Return samples with the law's state multiplied by a factor."""
    return replace(found, state=factor * found.state)


def shifted(found, far):
    """Return samples shifted to the right by a distance in m."""
    return replace(found, position=found.position + far)


def pushed(found, force):
    """Return samples with an additional force in N."""
    return replace(found, force=found.force + force, applied_force=found.applied_force + force)

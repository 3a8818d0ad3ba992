"""Motions of the hand that excite every term, and recordings of them."""

import math

import numpy as np

import hapkit_studio as hs
from hapkit_studio.analysis.identify import from_run, identify
from hapkit_studio.dynamics.hand import Hand, Prescribed

HAND = (0.05, 4.0, 200.0)


def several_sines(seed, amplitude=0.0125):
    """Return a target of four sines of 0.7 to 6 Hz, with larger amplitudes at lower frequencies."""
    random = np.random.default_rng(seed)
    hertz, phase = random.uniform(0.7, 6.0, 4), random.uniform(0.0, 2.0 * math.pi, 4)
    size = amplitude / hertz**0.7 * random.uniform(0.5, 1.0, 4)
    return lambda t: sum(
        a * np.sin(2.0 * math.pi * f * np.asarray(t) + p) for a, f, p in zip(size, hertz, phase, strict=True)
    )


def shaken(seed, environment="spring", values=None, *, quantum=20.7e-6, seconds=3.0, **loop):
    """Identify a handle of 44 g with 0.5 N·s/m and 0.1 N of friction from a run in which a hand shakes it."""
    hand = Hand(*HAND, several_sines(seed), vectorised=True)
    device = hs.SimulatedHapkit(quantum=quantum)
    run = hs.simulate(environment, values, hand=hand, device=device, seconds=seconds, **loop)
    return identify(from_run(run, hand))


def sine_run(stiffness, damping, hertz, amplitude, phase=0.0, *, quantum=20.7e-6, seconds=3.0, **loop):
    """Return a run in which the handle follows a sine in a spring, without a force limit."""
    motion = Prescribed(lambda t: amplitude * math.sin(2.0 * math.pi * hertz * t + phase))
    device = hs.SimulatedHapkit(quantum=quantum, max_force=math.inf)
    values = {"stiffness": stiffness, "damping": damping}
    return hs.simulate("spring", values, hand=motion, device=device, seconds=seconds, **loop)


def impedance(stiffness, damping, hertz, rate, delay):
    """Return (K, B) at one frequency of a spring with backward-difference damping.

    Its force is held for a period and delayed.

    Z = (K + B (1 - e^-jwT) / T) e^-jw(td + T/2) sin(wT/2) / (wT/2): K = Re Z, B = Im Z / w.
    """
    w, period = 2.0 * math.pi * hertz, 1.0 / rate
    difference = (1.0 - np.exp(-1j * w * period)) / period
    half = 0.5 * w * period
    z = (stiffness + damping * difference) * np.exp(-1j * w * (delay + 0.5 * period)) * math.sin(half) / half
    return z.real, z.imag / w

"""Aliasing of ridges: above half the sampling rate, a different texture is felt."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base, spring, stroking
from hapkit_studio.formatting import with_unit
from hapkit_studio.haptics import rows

SAMPLES = 400
# largest relative frequency error of a correctly rendered texture
TRUE_WITHIN = 0.005


def limit(case: base.Case) -> float:
    """Return the limit λ/(2 T) in m/s, at which each ridge has two samples."""
    return 0.5 * case["wavelength"] * case["rate"]


def probe(speed: float, case: base.Case) -> base.Evidence:
    """Stroke the grating at one speed and measure the frequency."""
    wavelength, rate = case["wavelength"], case["rate"]
    force = stroking.stroke(wavelength, speed, rate, 0.0, SAMPLES, 0.13 * wavelength)[:, rows.FORCE]
    # a sampled sine satisfies F_k+1 + F_k-1 = 2 cos(2 π f/rate) F_k
    cosine = force[1:-1] @ (force[2:] + force[:-2]) / (2.0 * force[1:-1] @ force[1:-1])
    frequency, there = rate * math.acos(min(max(float(cosine), -1.0), 1.0)) / math.tau, speed / wavelength
    holds = abs(frequency - there) <= TRUE_WITHIN * there
    felt, passed = with_unit(frequency, "Hz", 4), with_unit(there, "Hz", 4)
    text = f"the force vibrates at {felt}; the ridges pass at {passed}"
    return base.Evidence(force[:80], 1.0 / rate, "force", "N", holds, frequency, "Hz", text, held=True)


def folded(speed: float, case: base.Case) -> float:
    """Return the alias frequency in Hz of the ridges."""
    there = speed / case["wavelength"]
    return abs(there - case["rate"] * round(there / case["rate"]))


FAILURE = base.Failure(
    key="texture_speed",
    title="Ridges crossed too fast",
    summary="If more ridges pass per second than half the servo rate, a faster stroke feels slower",
    formula="v < λ/(2T), with speed v, wavelength λ and period T; for a smooth force v ≤ λ/(10T)",
    explanation="Ridges with wavelength λ, crossed at speed v, should be felt v/λ times a second. The loop "
    "samples 1/T times a second, and at least two samples for each ridge are needed to tell its frequency "
    "(Nyquist). With fewer than two, the samples are the same as those of a slower vibration of frequency "
    "1/T − v/λ (aliasing), and the motor vibrates at this frequency: the faster you move, the lower it is.",
    knob=stroking.SPEED,
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "speed, m/s",
        np.linspace(0.1, 1.95, 38),
        (
            base.Curve("ridges per second, v/λ", lambda speed, case: speed / case["wavelength"], base.OTHER),
            base.Curve("theory with aliasing", folded, base.THEORY),
            base.Curve("simulation"),
        ),
        "λ/(2T)",
        lambda case: {"λ/(10T)": 0.2 * limit(case)},
        y_label="frequency of the vibration, Hz",
        level=None,
    ),
    options=(replace(stroking.WAVELENGTH, default=0.001), spring.RATE),
    live=stroking.live,
    span=(0.1, 1.9),
    order=11,
)

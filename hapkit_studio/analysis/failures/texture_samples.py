"""Ridges with too few samples: below ten per ridge, some peaks are never rendered."""

import math

import numpy as np

from hapkit_studio.analysis.failures import base, spring, stroking

SAMPLES = 4000


def stroke(speed: float, case: base.Case) -> np.ndarray:
    """Return the rows of a stroke over hundreds of ridges."""
    return stroking.stroke(case["wavelength"], speed, case["rate"], 0.0, SAMPLES)


def probe(speed: float, case: base.Case) -> base.Evidence:
    """Stroke the grating at one speed; the ridge with the fewest samples decides."""
    return stroking.ridges(stroke(speed, case), case, "samples", 4 * stroking.WANTED + 1)


def peak(speed: float, case: base.Case) -> float:
    """Return the smallest peak force of a ridge, in %."""
    return 100.0 * stroking.least_peak(stroke(speed, case), case["wavelength"])


FAILURE = base.Failure(
    key="texture_samples",
    title="Ridges with too few samples",
    summary="With fewer than ten samples for each ridge, the ridges become weak and uneven",
    formula="v ≤ λ/(10T), with speed v, wavelength λ and period T",
    explanation="The loop renders a ridge only where it takes a sample. With n samples for each ridge, the "
    "nearest sample can be 1/(2n) of a wavelength away from the top. So the weakest ridge gets cos(π/n) of "
    "its force: 95 % with ten samples, 81 % with five. Which ridge is weak changes along the stroke, and "
    "this is felt as a slow beat that is not part of the texture.",
    knob=stroking.SPEED,
    limit=lambda case: case["wavelength"] * case["rate"] / stroking.WANTED,
    probe=probe,
    plot=base.Plot(
        "speed, m/s",
        np.geomspace(0.2, 3.7, 24),
        (
            base.Curve(
                "cos(π v T/λ)",
                lambda v, case: 100.0 * math.cos(math.pi * v / (case["wavelength"] * case["rate"])),
                base.THEORY,
            ),
            base.Curve("simulation", peak),
        ),
        "λ/(10T)",
        level=100.0 * math.cos(math.pi / stroking.WANTED),
        level_label="ten samples for each ridge",
        log_x=True,
        y_label="force in the worst ridge, % of its amplitude",
    ),
    options=(stroking.WAVELENGTH, spring.RATE),
    live=stroking.live,
    span=(0.2, 3.0),
    order=12,
)

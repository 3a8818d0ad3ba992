"""Ridges with too few sensor counts: the force has steps, and some peaks are not rendered."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base, spring, stroking
from hapkit_studio.dynamics import nominal
from hapkit_studio.haptics import rows

RIDGES, TO_SEE = 200, 80


def stroke(quantum: float, case: base.Case) -> np.ndarray:
    """Return the rows of a stroke over many ridges, with TO_SEE samples in each ridge."""
    speed = case["wavelength"] * case["rate"] / TO_SEE
    return stroking.stroke(case["wavelength"], speed, case["rate"], quantum, RIDGES * TO_SEE)


def probe(quantum: float, case: base.Case) -> base.Evidence:
    """Stroke the grating slowly; the ridge with the fewest readings decides."""
    return stroking.ridges(stroke(quantum, case), case, "readings", 4 * TO_SEE)


def step(quantum: float, case: base.Case) -> float:
    """Return the largest step of the rendered force in % of its amplitude."""
    force = stroke(quantum, case)[:, rows.FORCE]
    return 100.0 * float(np.abs(np.diff(force)).max()) / stroking.AMPLITUDE


FAILURE = base.Failure(
    key="texture_counts",
    title="Ridges with too few sensor steps",
    summary="With fewer than ten sensor steps for each ridge, the force becomes a staircase instead of a "
    "wave",
    formula="Δ ≤ λ/10, with sensor step Δ and wavelength λ. At each step the force jumps by up to "
    "2π A Δ/λ, with amplitude A",
    explanation="The force is computed from the sensor's reading, which has steps Δ. With ten steps for "
    "each ridge the force jumps by up to 62 % of its amplitude A from one step to the next. Each jump is "
    "felt as a small knock, and the knocks are finer and sharper than the ridges. The Hapkit's steps of "
    "20.7 µm are fine enough for ridges of 0.2 mm. A paddle with steps of 0.78 mm needs ridges of 8 mm.",
    knob=base.Parameter(
        "quantum",
        "Sensor step",
        "m",
        1e-4,
        1e-7,
        0.02,
        "Smallest distance that the sensor measures: one count",
        "Δ",
    ),
    limit=lambda case: case["wavelength"] / stroking.WANTED,
    probe=probe,
    plot=base.Plot(
        "sensor step, mm",
        np.geomspace(0.2, 4.0, 24),
        (
            base.Curve(
                "2 sin(π Δ/λ)",
                lambda q, case: 200.0 * math.sin(math.pi * q / case["wavelength"]),
                base.THEORY,
            ),
            base.Curve("simulation", step),
        ),
        "λ/10",
        lambda case: {"sensor step of a Hapkit": nominal.QUANTUM},
        level=200.0 * math.sin(math.pi / stroking.WANTED),
        level_label="ten steps for each ridge",
        log_x=True,
        factor=1e3,
        y_label="largest jump of the force, % of the amplitude",
    ),
    options=(replace(stroking.WAVELENGTH, default=0.001), spring.RATE),
    span=(0.2, 3.0),
    order=13,
)

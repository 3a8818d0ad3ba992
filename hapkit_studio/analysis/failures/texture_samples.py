"""Ridges with too few samples: ten for each, or the strongest part of some ridges is never rendered."""

import math

import numpy as np

from hapkit_studio.analysis.failures import base, spring, stroking
from hapkit_studio.haptics import rows

WANTED = 10
SAMPLES = 4000
_SHARES = np.geomspace(0.2, 3.7, 24)


def limit(case: base.Case) -> float:
    """Return λ/(10 T) in m/s."""
    return case["wavelength"] * case["rate"] / WANTED


def stroke(speed: float, case: base.Case) -> np.ndarray:
    """Return the rows of a stroke over hundreds of ridges."""
    return stroking.stroke(case["wavelength"], speed, case["rate"], 0.0, SAMPLES)


def probe(speed: float, case: base.Case) -> base.Evidence:
    """Stroke the grating at one speed; the ridge with the fewest samples decides."""
    out = stroke(speed, case)
    least = stroking.least_in_a_ridge(out, case["wavelength"])
    words, force = stroking.ridge_words(out, case, least), out[: 4 * WANTED + 1, rows.ASKED]
    return stroking.counted(force, "N", case, least >= WANTED, least, words)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return over the speed how much of a ridge's force the worst ridge gets: rendered, and by theory."""

    def peak(speed: float) -> float:
        return 100.0 * stroking.least_peak(stroke(speed, case), case["wavelength"])

    speeds = limit(case) * _SHARES
    theory = 100.0 * np.cos(np.pi * speeds / (case["wavelength"] * case["rate"]))
    lines = (
        base.Line("cos(π v T/λ)", speeds, theory, base.THEORY),
        base.Line("rendered", speeds, base.swept(speeds, peak, progress)),
    )
    level = 100.0 * math.cos(math.pi / WANTED)
    marks = (base.Mark("λ/(10T)", limit(case)),)
    return base.Chart(
        "speed, m/s", "force in the worst ridge, % of A", lines, marks, level, "ten samples", log_x=True
    )


FAILURE = base.Failure(
    key="texture_samples",
    title="Ridges with too few samples",
    summary="With fewer than ten samples for each, ridges come out weak, uneven and late",
    formula="v ≤ λ/(10T)",
    explanation="The loop renders a ridge only where it happens to look. With n samples for each the "
    "strongest may lie 1/(2n) of a wavelength beside the top, so the worst ridge gets cos(π/n) of "
    "its force: 95 % of it with ten samples, 81 % with five. Which ridge is weak changes from one to "
    "the next, and that is felt as a slow beat that is not in the texture.",
    knob=stroking.SPEED,
    limit=limit,
    probe=probe,
    curve=curve,
    options=(stroking.WAVELENGTH, spring.RATE),
    live=stroking.live,
    span=(0.2, 3.0),
    order=12,
)

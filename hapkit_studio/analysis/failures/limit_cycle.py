"""A spring felt through sensor steps: where half a count's force is more than friction holds, it buzzes."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.formatting import with_unit

# The handle is let go this many counts away.
START = 3.3
SHOWN = 0.2
_SHARES = np.array([0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.01, 1.05, 1.1, 1.2, 1.3, 1.5, 1.7, 1.9])


def limit(case: base.Case) -> float:
    """Return 2 F_c/Δ in N/m."""
    return 2.0 * case["coulomb"] / case["quantum"]


def swing(stiffness: float, case: base.Case) -> tuple[np.ndarray, str, float]:
    """Return the handle's place (n,) in counts, what becomes of it, and the p-p of its tail in counts."""
    start, quantum = START * case["quantum"], case["quantum"]
    x = spring.released_with_friction(**case, stiffness=stiffness, start=start)
    word, size = spring.judged(x, start, case["rate"])
    return x / quantum, word, size / quantum


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Let the handle go a few counts from where it would rest."""
    x, word, counts = swing(stiffness, case)
    buzz = f"keeps buzzing by {with_unit(counts, 'counts', 2)}"
    words = {spring.RESTS: "comes to rest", spring.GROWS: "grows", spring.CYCLES: buzz}[word]
    label = "position"
    if word == spring.CYCLES:
        x = x[-round(SHOWN * case["rate"]) :]
        x, label = x - x.mean(), f"position in the last {with_unit(SHOWN, 's')}"
    holds = word == spring.RESTS
    return base.Evidence(x, 1.0 / case["rate"], label, "counts", holds, counts, "counts", words)


def buzz(stiffness: float, case: base.Case) -> float:
    """Return the size of the buzz in counts; 0 is exact rest, nan where it grows."""
    _, word, size = swing(stiffness, case)
    return math.nan if word == spring.GROWS else size


FAILURE = base.Failure(
    key="limit_cycle",
    title="A buzz smaller than one count",
    summary="Where the force of half a count exceeds dry friction, the handle never comes to rest",
    formula="k < 2 F_c/Δ, while k < 2 b₀/T (Abbott and Okamura; σ = F_c/(k Δ) > ½ in Diolaiti's plane)",
    explanation="A sensor with steps Δ turns the spring's force into steps of k Δ. If the handle would "
    "rest at the edge between two counts, the force there is +½ k Δ on one side and −½ k Δ on the other, "
    "never 0. Dry friction F_c holds the handle as long as ½ k Δ is smaller. Beyond that the handle is "
    "pushed back and forth across the edge for ever. This limit cycle is bounded, often smaller than a "
    "count, and can be felt.",
    knob=spring.STIFFNESS,
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "stiffness, N/m",
        _SHARES,
        (base.Curve("rendered", buzz),),
        "2 F_c/Δ",
        lambda case: {"2 b₀/T": 2.0 * case["viscous"] * case["rate"]},
        y_label="buzz, counts p-p",
        level=None,
    ),
    options=(
        spring.MASS,
        replace(spring.VISCOUS, default=1.0),
        replace(spring.COULOMB, default=0.01, low=1e-4),
        spring.QUANTUM,
        spring.RATE,
    ),
    span=(0.6, 1.9),
    order=7,
)

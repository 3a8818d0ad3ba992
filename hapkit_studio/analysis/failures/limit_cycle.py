"""A spring felt through sensor steps: where half a count's force is more than friction holds, it buzzes."""

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.spring import MASS, RATE
from hapkit_studio.analysis.failures.traces import thinned
from hapkit_studio.formatting import with_unit

# The handle is let go this many counts away.
START = 3.3
SHOWN = 0.2
_SHARES = np.array([0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.01, 1.05, 1.1, 1.2, 1.3, 1.5, 1.7, 1.9])


def limit(case: base.Case) -> float:
    """Return 2 F_c/Δ in N/m."""
    return 2.0 * case["coulomb"] / case["quantum"]


def swing(stiffness: float, case: base.Case) -> np.ndarray:
    """Return the handle's place (n,) in m."""
    device = (case["mass"], case["viscous"], case["coulomb"], case["quantum"], case["rate"])
    return spring.released_with_friction(*device, stiffness, START * case["quantum"])


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Let the handle go a few counts from where it would rest."""
    x = swing(stiffness, case)
    word, size = spring.judged(x, START * case["quantum"], case["rate"])
    counts = size / case["quantum"]
    holds = word == spring.RESTS
    words = "rests, quite still"
    if not holds:
        words = "grows" if word == spring.GROWS else f"buzzes by {with_unit(counts, 'counts', 2)} for good"
    n = round(SHOWN * case["rate"])
    time, trace = thinned(np.arange(len(x)) / case["rate"], x / case["quantum"])
    label = "position"
    if word == spring.CYCLES:
        time, trace = np.arange(n) / case["rate"], (x[-n:] - x[-n:].mean()) / case["quantum"]
        label = f"position in the last {with_unit(SHOWN, 's')}"
    return base.Evidence(time, trace, label, "counts", holds, counts, "counts", words)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the size of the buzz over the stiffness; 0 is exact rest."""
    stiffness, sizes = limit(case) * _SHARES, []
    for done, k in enumerate(stiffness, 1):
        x = swing(k, case)
        word, size = spring.judged(x, START * case["quantum"], case["rate"])
        sizes.append(np.nan if word == spring.GROWS else size / case["quantum"])
        progress(done, len(stiffness))
    marks = (base.Mark("2 F_c/Δ", limit(case)), base.Mark("2 b/T", 2.0 * case["viscous"] * case["rate"]))
    lines = (base.Line("rendered", stiffness, np.array(sizes)),)
    return base.Chart("stiffness, N/m", "buzz, counts p-p", lines, marks)


FAILURE = base.Failure(
    key="limit_cycle",
    title="A buzz of less than a count",
    summary="Where half a count's force is more than dry friction holds, the handle never rests",
    formula="K < 2 F_c/Δ, while K < 2 b/T (Abbott and Okamura; σ = F_c/(K Δ) > ½ in Diolaiti's plane)",
    explanation="A sensor of steps Δ makes the spring's force a staircase of steps K Δ. Where the handle "
    "ought to rest on the edge of a step, the force is +½ K Δ on one side and −½ K Δ on the other, "
    "never 0. Dry friction F_c can hold that as long as ½ K Δ stays below it. Above, the handle is "
    "pushed back and forth over the edge for good: bounded, often below a count, and felt.",
    knob=base.Parameter(
        "stiffness", "Stiffness", "N/m", 900.0, 1.0, 200_000.0, "Of the rendered spring", "K"
    ),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(
        MASS,
        base.Parameter("viscous", "Handle's damping", "N·s/m", 1.0, 0.01, 10.0, "Of the handle itself", "b"),
        base.Parameter(
            "coulomb", "Dry friction", "N", 0.01, 1e-4, 2.0, "Coulomb friction of the handle", "F_c"
        ),
        base.Parameter("quantum", "Sensor step", "m", 20.7e-6, 1e-6, 1e-3, "One count", "Δ"),
        RATE,
    ),
    span=(0.6, 1.9),
    order=7,
)

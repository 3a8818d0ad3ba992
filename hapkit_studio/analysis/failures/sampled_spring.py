"""A spring too stiff for its loop: the force is held for a period, and pushes longer than it resisted."""

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.filters import bound


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m: where a root of the sampled loop leaves the unit circle."""
    return bound(case, case["damping"], "difference")


def rule(case: base.Case) -> dict[str, float]:
    """Return the limit in N/m by the rule of thumb."""
    return {"(b₀ + b)/(T/2 + td)": (case["viscous"] + case["damping"]) / (0.5 / case["rate"] + case["delay"])}


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring in the window; there the handle has friction, which holds it far beyond the limit."""
    given = {"damping": case["damping"]}
    return spring.live(stiffness, limit(case), spring.STIFFNESS, given, spring.loop_of(case))


FAILURE = base.Failure(
    key="sampled_spring",
    title="A spring too stiff for its loop",
    summary="Above a certain stiffness the sampled spring gives the handle more energy than damping takes "
    "away",
    formula="k < (b₀ + b)/(T/2 + td), approximately; exact: from the roots of the sampled loop",
    explanation="The loop reads the position once in each period T and holds the force until the next "
    "reading. On average the force is late by T/2 and by the delay td. A late spring force resists too "
    "little on the way in and pushes too long on the way out. So every oscillation gains energy in "
    "proportion to k (T/2 + td), and loses energy in proportion to the damping b₀ of the handle and b of "
    "the spring. Where it gains more than it loses, it grows.",
    knob=spring.STIFFNESS,
    limit=limit,
    probe=lambda k, case: spring.evidence(spring.setting(case), case["damping"], k),
    plot=base.Plot(
        "stiffness, N/m",
        np.linspace(0.5, 2.0, 31),
        (
            base.Curve("largest root", lambda k, case: spring.exact(case, k).real, base.THEORY),
            base.Curve("rendered"),
        ),
        "exact limit",
        rule,
    ),
    options=(*spring.HANDLE, spring.DAMPING),
    live=live,
    span=(0.5, 2.0),
    order=1,
)

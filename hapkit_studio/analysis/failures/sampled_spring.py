"""A spring too stiff for its loop: the force is held for a period, and pushes longer than it resisted."""

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.filters import bound


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m: where a root of the sampled loop leaves the unit circle."""
    return bound(case, case["damping"], "difference")


def rule(case: base.Case) -> dict[str, float]:
    """Return the limit in N/m by the rule of thumb."""
    return {"(b + B)/(T/2 + td)": (case["viscous"] + case["damping"]) / (0.5 / case["rate"] + case["delay"])}


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring in the window; there the handle has friction, which holds it far beyond the limit."""
    given = {"damping": case["damping"]}
    return spring.live(stiffness, limit(case), spring.STIFFNESS, given, spring.loop_of(case))


FAILURE = base.Failure(
    key="sampled_spring",
    title="A spring too stiff for its loop",
    summary="Above a stiffness the held force gives more energy than the handle's damping takes",
    formula="K < (b + B)/(T/2 + td), a little more or less: exact from the roots of the sampled loop",
    explanation="The loop looks once a period T and holds its force until it looks again, so the spring "
    "acts half a period late, and a delay td later still. Late, it pushes longer on the way out than "
    "it resisted on the way in, and at every swing gives energy in proportion to K (T/2 + td). The "
    "damping b of the handle and B of the spring take energy in proportion to b + B. Where giving "
    "wins, the swing grows.",
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

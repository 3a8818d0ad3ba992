"""A spring too stiff for its loop: the force is held for a period, and pushes longer than it resisted."""

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.in_window import pulled
from hapkit_studio.analysis.stability.limits import stiffness_limit

_SHARES = np.linspace(0.5, 2.0, 31)


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m: where a root of the sampled loop leaves the unit circle."""
    rate, delay = case["rate"], case["delay"]
    return stiffness_limit(case["mass"], case["viscous"], damping=case["damping"], rate=rate, delay=delay)


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Let the handle go 1 mm from the centre of the rendered spring."""
    return spring.evidence(spring.setting(case), case["damping"], stiffness)


def exact(stiffness: float, case: base.Case) -> float:
    """Return the growth in 1/s from the loop's largest root."""
    period = 1.0 / case["rate"]
    matrix = spring.step_matrix(
        case["mass"], case["viscous"], stiffness, case["damping"], period, case["delay"]
    )
    return spring.exact_rate(matrix, period)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the growth over the stiffness: of the rendered spring, and of the loop's largest root."""
    bound = limit(case)
    stiffness, where, measured = bound * _SHARES, spring.setting(case), []
    for done, k in enumerate(stiffness, 1):
        measured.append(spring.rate_of(where, k, spring.released(where, case["damping"], k)))
        progress(done, len(stiffness))
    rule = (case["viscous"] + case["damping"]) / (0.5 / case["rate"] + case["delay"])
    lines = (
        base.Line("largest root", stiffness, np.array([exact(k, case) for k in stiffness]), base.THEORY),
        base.Line("rendered", stiffness, np.array(measured)),
    )
    marks = (base.Mark("exact limit", bound), base.Mark("(b + B)/(T/2 + td)", rule))
    return base.Chart("stiffness, N/m", "growth, 1/s", lines, marks, 0.0, "neither grows nor decays")


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring in the window; there the handle has friction, which holds it far beyond the limit."""
    bound = limit(case)
    loop_ = {"rate": case["rate"], "delay": case["delay"], "estimator": "difference", "options": ()}

    def make(value: float) -> base.Live:
        arguments = {"stiffness": base.short(value, bound), "damping": case["damping"], "center": 0.0}
        return base.Live("spring", base.within("spring", arguments), loop_)

    return pulled(make, stiffness, bound, "stiffness", "N/m")


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
    knob=base.Parameter(
        "stiffness", "Stiffness", "N/m", 900.0, 1.0, 200_000.0, "Of the rendered spring", "K"
    ),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(spring.MASS, spring.VISCOUS, spring.DAMPING, spring.RATE, spring.DELAY),
    live=live,
    span=(0.5, 2.0),
    order=1,
)

"""A spring that is too stiff: dry friction stops it after a small push, but not after a large push."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.checks import bisected
from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.in_window import SEEN, behind, let_go
from hapkit_studio.analysis.stability.limits import stiffness_limit
from hapkit_studio.formatting import on_screen, with_unit

_HALVINGS = 16
# The simulated time as a multiple of 1/σ, with the growth rate σ: a push that differs from the limit by 1 ‰
# diverges or settles in this time. The largest number of samples, after which the trend decides.
_TIMES, _SAMPLES = 10.0, 300_000


def amplitude(case: base.Case, stiffness: float) -> float:
    """Return the push F_c/k coth(π σ/2ω) in m above which the motion grows, from the half-cycle map."""
    root = spring.exact(case, stiffness)
    if root.real <= 0.0:
        return math.inf
    return case["coulomb"] / stiffness / math.tanh(0.5 * math.pi * root.real / root.imag)


def swing(push: float, case: base.Case) -> tuple[np.ndarray, str]:
    """Return the position (n,) in m of a handle released after a push, and the outcome.

    The sensor is ideal.
    """
    growth = max(spring.exact(case, case["stiffness"]).real, 1e-9)
    seconds = min(max(spring.FRICTION_SECONDS, _TIMES / growth), _SAMPLES / case["rate"])
    x = spring.released_with_friction(**case, quantum=0.0, start=push, seconds=seconds)
    return x, spring.judged(x, push, case["rate"], seconds)[0]


def measured(case: base.Case, stiffness: float) -> float:
    """Return the push in m at the boundary between settling and growing, by bisection near ``amplitude``."""
    middle, case = amplitude(case, stiffness), {**case, "stiffness": stiffness}
    ends = math.log(0.5 * middle), math.log(2.0 * middle)

    def settles(push: float) -> bool:
        return swing(math.exp(push), case)[1] != spring.GROWS

    return math.exp(0.5 * sum(bisected(settles, *ends, _HALVINGS)))


def probe(push: float, case: base.Case) -> base.Evidence:
    """Displace the handle and let it go."""
    x, word = swing(push, case)
    moving = np.flatnonzero(np.abs(np.diff(x)) > 0.0)
    samples = int(moving[-1]) + 1 if len(moving) else len(x)
    ends = {
        spring.RESTS: "the handle comes to rest within",
        spring.CYCLES: "the oscillation shrinks for",
        spring.GROWS: "the oscillation grows for",
    }
    text = f"{ends[word]} {with_unit(samples / case['rate'], 's', 2)}"
    shown, most = 1e3 * x[: round(1.2 * samples)], 1e3 * float(np.abs(x).max())
    holds = word != spring.GROWS
    return base.Evidence(shown, 1.0 / case["rate"], "position", "mm", holds, most, "mm", text)


def edge(case: base.Case) -> float:
    """Return the stiffness in N/m above which sampling adds more energy than viscous damping removes."""
    return stiffness_limit(case["mass"], case["viscous"], rate=case["rate"])


def live(push: float, case: base.Case) -> base.Live:
    """Return the live settings of the spring. In the window, the handle has 0.1 N of dry friction."""
    values = base.within("spring", {"stiffness": case["stiffness"], "damping": 0.0, "center": 0.0})
    found = base.Live("spring", values, spring.loop_of(case))
    pointer = behind(push, values["stiffness"])
    outcome = "keeps oscillating" if let_go(found, pointer) > SEEN else "comes to rest"
    drag = (
        f"Drag to {on_screen(pointer, 'm', 3)}: this moves the handle by {on_screen(push, 'm', 3)}. "
        "Then let go."
    )
    return replace(found, advice=f"{drag} With the sensor steps of the window, the handle {outcome}.")


FAILURE = base.Failure(
    key="large_push",
    title="Stable after a small push, unstable after a large one",
    summary="Dry friction keeps a spring stable above its stiffness limit, but only up to a certain "
    "amplitude",
    formula="Stable if A < (F_c/k) coth(π σ/2ω), about 4 F_c/(π ω (k T/2 − b₀)), with amplitude A, dry "
    "friction F_c, stiffness k, period T, damping b₀, and growth rate σ and frequency ω of the oscillation",
    explanation="Beyond k = 2 b₀/T sampling adds more energy in an oscillation than viscous damping "
    "removes. This surplus, π ω A² (k T/2 − b₀), grows with the square of the amplitude A. Dry friction "
    "removes 4 F_c A, in proportion to A only. So small oscillations die out and large ones grow "
    "(Diolaiti's locally stable region). A wall that is stable under a light touch can start to buzz after "
    "one hard hit.",
    knob=base.Parameter(
        "push", "Push", "m", 2e-3, 1e-6, 1.0, "Distance by which the handle is displaced", "A"
    ),
    limit=lambda case: amplitude(case, case["stiffness"]),
    probe=probe,
    plot=base.Plot(
        "stiffness, N/m",
        lambda case: edge(case) * np.array([1.15, 1.25, 1.4, 1.6, 1.9, 2.3, 3.0, 4.0]),
        (
            base.Curve(
                "theory",
                lambda k, case: 1e3 * amplitude(case, k),
                base.THEORY,
                lambda case: edge(case) * np.geomspace(1.15, 4.0, 60),
            ),
            base.Curve("simulation", lambda k, case: 1e3 * measured(case, k)),
        ),
        marks=lambda case: {"present stiffness": case["stiffness"], "limit without friction": edge(case)},
        level=lambda case: 1e3 * amplitude(case, case["stiffness"]),
        level_label="limit at the present stiffness",
        log_y=True,
        y_label="largest push in mm after which the handle comes to rest",
    ),
    options=(
        replace(spring.STIFFNESS, default=2000.0, high=50_000.0),
        spring.MASS,
        spring.VISCOUS,
        spring.COULOMB,
        spring.RATE,
    ),
    live=live,
    span=(0.2, 2.0),
    order=8,
)

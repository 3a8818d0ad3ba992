"""Stable for a small push, lost after a large one: dry friction holds a spring beyond its limit so far."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.checks import bisected
from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.in_window import SEEN, behind, let_go
from hapkit_studio.formatting import on_screen, with_unit

_HALVINGS = 16


def amplitude(case: base.Case, stiffness: float) -> float:
    """Return 4 F_c/(π ω (K T/2 − b)) in m: friction's work over a swing against what sampling gives."""
    spare = 0.5 * stiffness / case["rate"] - case["viscous"]
    if spare <= 0.0:
        return math.inf
    return 4.0 * case["coulomb"] / (math.pi * math.sqrt(stiffness / case["mass"]) * spare)


def swing(push: float, case: base.Case) -> tuple[np.ndarray, bool]:
    """Return the place (n,) in m of a handle let go after a push, and whether it settles; ideal sensor."""
    x = spring.released_with_friction(**case, quantum=0.0, start=push)
    return x, spring.judged(x, push, case["rate"])[0] == spring.RESTS


def measured(case: base.Case, stiffness: float) -> float:
    """Return the push in m between settling and growing, by bisection about the formula."""
    middle, case = amplitude(case, stiffness), {**case, "stiffness": stiffness}
    ends = math.log(0.5 * middle), math.log(2.0 * middle)
    return math.exp(0.5 * sum(bisected(lambda push: swing(math.exp(push), case)[1], *ends, _HALVINGS)))


def probe(push: float, case: base.Case) -> base.Evidence:
    """Pull the handle aside by so much and let it go."""
    x, holds = swing(push, case)
    moving = np.flatnonzero(np.abs(np.diff(x)) > 0.0)
    samples = int(moving[-1]) + 1 if len(moving) else len(x)
    words = (
        f"{'settles within' if holds else 'grows, lost after'} {with_unit(samples / case['rate'], 's', 2)}"
    )
    shown, most = 1e3 * x[: round(1.2 * samples)], 1e3 * float(np.abs(x).max())
    return base.Evidence(shown, 1.0 / case["rate"], "position", "mm", holds, most, "mm", words)


def edge(case: base.Case) -> float:
    """Return 2 b/T in N/m, above which sampling gives more than viscous damping takes."""
    return 2.0 * case["viscous"] * case["rate"]


def live(push: float, case: base.Case) -> base.Live:
    """Return the spring in the window; the handle has 0.1 N of dry friction there."""
    values = base.within("spring", {"stiffness": case["stiffness"], "damping": 0.0, "center": 0.0})
    found = base.Live("spring", values, spring.loop_of(case))
    pointer = behind(push, values["stiffness"])
    said = "It swings on." if let_go(found, pointer) > SEEN else "It comes to rest."
    drag = f"Drag to {on_screen(pointer, 'm', 3)}, the handle comes {on_screen(push, 'm', 3)}, and let go."
    return replace(found, advice=f"{drag} {said}")


FAILURE = base.Failure(
    key="large_push",
    title="Calm after a small push, lost after a large one",
    summary="Dry friction holds a spring beyond its limit, but only up to an amplitude",
    formula="A < 4 F_c/(π ω (K T/2 − b)), ω = √(K/m) (Diolaiti's locally stable region)",
    explanation="Beyond K = 2 b/T sampling gives more energy in a swing than viscous damping takes; the "
    "surplus π ω A² (K T/2 − b) grows with the square of the amplitude A. Dry friction takes 4 F_c "
    "A, in proportion to A only. So small swings lose and settle, large ones win and grow. A wall "
    "that seems quite stable under a light touch can be thrown into a buzz by one hard knock.",
    knob=base.Parameter("push", "Push", "m", 2e-3, 1e-6, 1.0, "How far the handle is pulled aside", "A"),
    limit=lambda case: amplitude(case, case["stiffness"]),
    probe=probe,
    plot=base.Plot(
        "stiffness, N/m",
        lambda case: edge(case) * np.array([1.15, 1.25, 1.4, 1.6, 1.9, 2.3, 3.0, 4.0]),
        (
            base.Curve(
                "balance of energy",
                lambda k, case: 1e3 * amplitude(case, k),
                base.THEORY,
                lambda case: edge(case) * np.geomspace(1.15, 4.0, 60),
            ),
            base.Curve("rendered", lambda k, case: 1e3 * measured(case, k)),
        ),
        marks=lambda case: {"this spring": case["stiffness"], "2 b/T": edge(case)},
        level=lambda case: 1e3 * amplitude(case, case["stiffness"]),
        level_label="its largest push",
        log_y=True,
        y_label="largest push that settles, mm",
    ),
    options=(
        replace(spring.STIFFNESS, default=2000.0, high=50_000.0),
        spring.MASS,
        spring.VISCOUS,
        spring.COULOMB,
        spring.RATE,
    ),
    live=live,
    margin=0.04,
    span=(0.2, 2.0),
    order=8,
)

"""A spring with sensor quantisation has a limit cycle if the force of half a count exceeds friction."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.plane import (
    BOUNDED,
    PUSHED,
    STABLE,
    UNSTABLE,
    Boundary,
    Field,
    Panel,
    Plane,
    Points,
)
from hapkit_studio.formatting import with_unit

# counts: displacement from which the handle is released
START = 3.3
SHOWN = 0.2
_SHARES = np.array([0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.01, 1.05, 1.1, 1.2, 1.3, 1.5, 1.7, 1.9])


def limit(case: base.Case) -> float:
    """Return the limit 2 F_c/Δ in N/m, with the friction F_c in N and the sensor count Δ in m."""
    return 2.0 * case["coulomb"] / case["quantum"]


def swing(stiffness: float, case: base.Case) -> tuple[np.ndarray, str, float]:
    """Return the handle's position (n,) in counts, the outcome, and the final peak-to-peak motion."""
    start, quantum = START * case["quantum"], case["quantum"]
    x = spring.released_with_friction(**case, stiffness=stiffness, start=start)
    word, size = spring.judged(x, start, case["rate"])
    return x / quantum, word, size / quantum


def probe(stiffness: float, case: base.Case) -> base.Evidence:
    """Release the handle a few counts from its equilibrium."""
    x, word, counts = swing(stiffness, case)
    buzz = f"the handle keeps buzzing by {with_unit(counts, 'counts', 2)}"
    text = {spring.RESTS: "the handle comes to rest", spring.GROWS: "the motion grows", spring.CYCLES: buzz}[
        word
    ]
    label = "position"
    if word == spring.CYCLES:
        x = x[-round(SHOWN * case["rate"]) :]
        x, label = x - x.mean(), f"position in the last {with_unit(SHOWN, 's')}"
    holds = word == spring.RESTS
    return base.Evidence(x, 1.0 / case["rate"], label, "counts", holds, counts, "counts", text)


def buzz(stiffness: float, case: base.Case) -> float:
    """Return the size of the limit cycle in counts; 0 if the handle rests, NaN if the motion grows."""
    _, word, size = swing(stiffness, case)
    return math.nan if word == spring.GROWS else size


# For the chart of outcomes: simulated values of b₀/(kT) and of F_c/(kΔ), none of them on a boundary; a small
# and a large push in counts.
_BETAS = (0.2, 0.3, 0.4, 0.6, 0.9, 1.5, 2.5)
_SIGMAS = (0.15, 0.25, 0.4, 0.6, 0.9, 1.5, 2.5)
LARGE = 200.3
_LOW, _HIGH = 0.12, 4.0
_WORDS = {
    STABLE: "comes to rest",
    BOUNDED: "keeps buzzing",
    PUSHED: "grows after a large push",
    UNSTABLE: "grows",
}


def edges(case: base.Case) -> tuple[float, float]:
    """Return the boundary of b₀/(kT), which depends on the delay, and the boundary of F_c/(kΔ)."""
    return 0.5 + case["delay"] * case["rate"], 0.5


def outcome(case: base.Case, stiffness: float, beta: float, sigma: float) -> str:
    """Return the outcome after a small and a large push, for b₀/(kT) = ``beta`` and F_c/(kΔ) = ``sigma``."""
    given = {
        **case,
        "viscous": beta * stiffness / case["rate"],
        "coulomb": sigma * stiffness * case["quantum"],
    }
    ends = []
    for counts in (START, LARGE):
        start = counts * case["quantum"]
        ends.append(
            spring.judged(
                spring.released_with_friction(**given, stiffness=stiffness, start=start), start, case["rate"]
            )[0]
        )
    if spring.GROWS in ends:
        return UNSTABLE if ends[0] == spring.GROWS else PUSHED
    return STABLE if ends[0] == spring.RESTS else BOUNDED


def plane(case: base.Case) -> Plane:
    """Return the diagram of F_c/(kΔ) over b₀/(kT) by Diolaiti et al. (2006), with simulated springs."""
    stiffness = spring.STIFFNESS.default
    found: dict[str, list[tuple[float, float]]] = {word: [] for word in _WORDS}
    enough, steady = edges(case)
    for beta in np.array(_BETAS) * enough / 0.5:
        for sigma in _SIGMAS:
            found[outcome(case, stiffness, beta, sigma)].append((beta, sigma))
    low, high = _LOW * enough / 0.5, _HIGH * enough / 0.5
    across, up = np.geomspace(low, high, 120), np.geomspace(_LOW, _HIGH, 120)
    damped, hidden = across > enough, up[:, np.newaxis] > steady
    z = np.where(damped & hidden, 0.5, np.where(damped | hidden, 1.5, 2.5))
    panel = Panel(
        Field(across, up, z),
        boundaries=(
            Boundary(
                "b₀/(kT) = ½ + td/T" if case["delay"] else "b₀/(kT) = ½", np.full(2, enough), up[[0, -1]]
            ),
            Boundary("$F_c$/(kΔ) = ½", across[[0, -1]], np.full(2, steady)),
        ),
        points=tuple(
            Points(f"simulation: {_WORDS[word]}", word, *np.array(at).T) for word, at in found.items() if at
        ),
    )
    return Plane(
        "The handle comes to rest with enough friction (top) and enough damping (right)",
        "b₀/(k T): damping relative to sampling",
        "$F_c$/(k Δ): friction relative to the force of a sensor step",
        (panel,),
        partial(_place, case=dict(case)),
    )


def _place(stiffness: float, case: base.Case) -> tuple[float, float]:
    return case["viscous"] * case["rate"] / stiffness, case["coulomb"] / (stiffness * case["quantum"])


FAILURE = base.Failure(
    key="limit_cycle",
    title="A buzz smaller than one sensor step",
    summary="If half a sensor step changes the spring's force by more than dry friction, the handle never "
    "rests",
    formula="No buzz if k < 2 F_c/Δ and k < b₀/(T/2 + td), with stiffness k, dry friction F_c, sensor step "
    "Δ, damping b₀, period T and delay td (Abbott and Okamura); in the chart F_c/(k Δ) > ½ (Diolaiti)",
    explanation="A sensor with steps Δ turns the spring's force into steps of k Δ. If the handle would rest "
    "at the edge between two sensor steps, the force there is +½ k Δ on one side and −½ k Δ on the other, "
    "never 0. Dry friction F_c holds the handle as long as ½ k Δ is smaller. Beyond that the handle is "
    "pushed back and forth across the edge for ever. This buzz (a limit cycle) does not grow and is often "
    "smaller than a sensor step, but you can feel it.",
    knob=spring.STIFFNESS,
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "stiffness, N/m",
        _SHARES,
        (base.Curve("simulation", buzz),),
        "2 F_c/Δ",
        lambda case: {"b₀/(T/2 + td)": case["viscous"] * case["rate"] / edges(case)[0]},
        y_label="buzz, peak to peak, sensor steps",
        level=None,
    ),
    options=(
        spring.MASS,
        replace(spring.VISCOUS, default=1.0),
        replace(spring.COULOMB, default=0.01, low=1e-4),
        spring.QUANTUM,
        spring.RATE,
        spring.DELAY,
    ),
    plane=plane,
    span=(0.6, 1.9),
    order=7,
)

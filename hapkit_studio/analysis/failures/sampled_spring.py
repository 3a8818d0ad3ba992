"""A spring that is too stiff for its loop: the zero-order hold releases more energy than it stored."""

from functools import partial

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.filters import bound
from hapkit_studio.analysis.failures.plane import STABLE, UNSTABLE, Boundary, Field, Panel, Plane, Points
from hapkit_studio.analysis.stability.limits import checked_loop
from hapkit_studio.dynamics import sampled_loop
from hapkit_studio.formatting import compact, with_unit


def limit(case: base.Case) -> float:
    """Return the exact limit in N/m, at which a root of the sampled loop leaves the unit circle."""
    return bound(case, case["damping"], "difference")


def rule(case: base.Case) -> dict[str, float]:
    """Return the limit in N/m by the rule of thumb."""
    return {"(b₀ + b)/(T/2 + td)": (case["viscous"] + case["damping"]) / (0.5 / case["rate"] + case["delay"])}


def live(stiffness: float, case: base.Case) -> base.Live:
    """Return the spring's live settings. In the window, friction calms the handle far beyond the limit."""
    given = {"damping": case["damping"]}
    return spring.live(stiffness, limit(case), spring.STIFFNESS, given, spring.loop_of(case))


# b₀T/m of two further handles, whose free motion decays quickly and slowly
_OTHER_HANDLES = (0.1, 0.001)
_CURVE_POINTS, _MEASURED_POINTS = 120, 9
_GRID = 80
# relative distance of the measured points from the boundary, on either side
_BESIDE = 0.03


def boundary(mass: float, case: base.Case, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the ratio of total to physical damping (n,), and the largest stable k T/b₀ (n,)."""
    loop = checked_loop(mass, case["viscous"], rate=case["rate"], delay=case["delay"])
    highest = sampled_loop.damping_limit(loop)
    total = np.geomspace(1.0, 1.0 + 0.999 * highest / case["viscous"], points)
    stiffness = sampled_loop.stiffness_limits(loop, (total - 1.0) * case["viscous"])
    return total, stiffness / (case["viscous"] * case["rate"])


def plane(case: base.Case) -> Plane:
    """Return the diagram of k T/b₀ (vertical) and (b₀ + b)/b₀: boundaries, rule of thumb, simulations."""
    viscous, rate, delay = case["viscous"], case["rate"], case["delay"]
    where, scale = spring.setting(case), viscous * rate
    total, exact = boundary(case["mass"], case, _CURVE_POINTS)
    others = []
    for number in _OTHER_HANDLES:
        others.append(
            Boundary(
                f"b₀T/m = {number:g}", *boundary(viscous / rate / number, case, _CURVE_POINTS), strong=False
            )
        )
    reach = np.array([1.0, total[-1]])
    rule = Boundary("rule (b₀ + b)/(T/2 + td)", reach, reach / (0.5 + delay * rate), strong=False)

    at, limits = boundary(case["mass"], case, _MEASURED_POINTS)
    outcomes: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for x, limit_here in zip(at.tolist(), limits.tolist(), strict=True):
        for y in ((1.0 - _BESIDE) * limit_here, (1.0 + _BESIDE) * limit_here):
            holds = spring.evidence(where, (x - 1.0) * viscous, y * scale).holds
            outcomes[holds].append((x, y))
    points = [
        Points(text, outcome, *np.array(outcomes[holds]).reshape(-1, 2).T)
        for holds, outcome, text in (
            (True, STABLE, "simulation: decays"),
            (False, UNSTABLE, "simulation: grows"),
        )
    ]
    across = np.geomspace(0.9, 1.3 * total[-1], _GRID)
    up = np.geomspace(0.2 * exact[0], 2.0 * exact.max(), _GRID)
    top = np.interp(across, total, exact, right=0.0)
    own = f"this handle, b₀T/m = {compact(viscous / (rate * case['mass']), 3)}"
    panel = Panel(
        Field(across, up, np.where(up[:, np.newaxis] <= top, 0.5, 2.5)),
        boundaries=(Boundary(own, total, exact), *others, rule),
        points=tuple(points),
    )
    return Plane(
        f"One chart for every handle and loop, with a delay of {with_unit(delay * rate, 'periods')}",
        "(b₀ + b)/b₀: total damping relative to the handle's damping",
        "k T/b₀: stiffness without unit",
        (panel,),
        partial(_place, damping=case["damping"], viscous=viscous, rate=rate),
    )


def _place(stiffness: float, damping: float, viscous: float, rate: float) -> tuple[float, float]:
    return 1.0 + damping / viscous, stiffness / (viscous * rate)


FAILURE = base.Failure(
    key="sampled_spring",
    title="A spring too stiff for the loop",
    summary="Above a certain stiffness the sampled spring gives the handle more energy than damping takes "
    "away",
    formula="Stable if about k < (b₀ + b)/(T/2 + td), with stiffness k, damping b₀ of the handle and b of "
    "the spring, period T and delay td. The exact limit is computed from the equation "
    "of the sampled loop",
    explanation="The loop reads the position once in each period T and holds the force until the next "
    "reading. On average the force is late by T/2 plus the delay td. A late spring force resists too "
    "little on the way in and pushes too long on the way out. So every oscillation gains energy in "
    "proportion to k (T/2 + td), and loses energy in proportion to the damping b₀ of the handle and b of "
    "the spring. If an oscillation gains more than it loses, it grows.",
    knob=spring.STIFFNESS,
    limit=limit,
    probe=lambda k, case: spring.evidence(spring.setting(case), case["damping"], k),
    plot=base.Plot(
        "stiffness, N/m",
        np.linspace(0.5, 2.0, 31),
        (
            base.Curve("theory", lambda k, case: spring.exact(case, k).real, base.THEORY),
            base.Curve("simulation"),
        ),
        "exact limit",
        rule,
    ),
    options=(*spring.HANDLE, spring.DAMPING),
    live=live,
    plane=plane,
    span=(0.5, 2.0),
    order=1,
)

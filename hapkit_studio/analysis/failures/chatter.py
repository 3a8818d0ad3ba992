"""Friction computed from the sign of a quantised velocity: large friction makes the handle chatter."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio.analysis.failures import base, spring
from hapkit_studio.analysis.failures.in_window import let_go
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.friction import COULOMB, PROJECTION
from hapkit_studio.formatting import compact, on_screen, with_unit
from hapkit_studio.haptics import rows

# ratio F_c T²/(m Δ) up to which the chatter stays within one count, for a delay of 0 and of 1 period
RATIOS = (1.5, 0.7)
# counts: a larger oscillation is felt as chatter
FLICKER = 1.5
# initial positions in counts and speeds in m/s; the start with the largest chatter decides
STARTS = ((0.0, 0.1234), (0.15, 0.05), (0.35, 0.2), (0.65, -0.08))
SECONDS, LAST = 3.0, 0.5
_PLACES = (0.01, 0.02, 0.03, 0.04)  # m: positions at which the mouse releases the handle
_SHARES = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0, 1.15, 1.33, 1.5, 1.75, 2.0])


def count_force(case: base.Case) -> float:
    """Return m Δ/T² in N: the force that moves the handle by a count within a period."""
    return case["mass"] * case["quantum"] * case["rate"] ** 2


def limit(case: base.Case) -> float:
    """Return the friction force in N above which the handle chatters over several counts, by simulation."""
    return RATIOS[int(case["late"])] * count_force(case)


def peak_to_peak(friction: float, case: base.Case, model: int = COULOMB) -> tuple[float, np.ndarray]:
    """Slide to rest from each of STARTS; return the largest peak-to-peak motion and its samples.

    Only the last 0.5 s are evaluated. Motion and samples are in counts.
    """
    given = {"model": float(model), "kinetic_force": friction, "static_force": friction, "viscous": 0.0}
    # Models with a tether get half the largest stable stiffness of a handle with this damping.
    given["tether_stiffness"] = case["viscous"] * case["rate"] / (1.0 + 2.0 * case["late"])
    loop, tails = LoopSettings(case["rate"], case["late"] / case["rate"]), []
    for place, speed in STARTS:
        start = (place * case["quantum"], speed)
        device = SimulatedHapkit(case["mass"], case["viscous"], 0.0, case["quantum"], math.inf, *start)
        out = base.render("friction", given, device, loop, round(SECONDS * case["rate"]))
        tails.append(out[-round(LAST * case["rate"]) :, rows.TRUE_POSITION] / case["quantum"])
    worst = max(tails, key=np.ptp)
    return float(np.ptp(worst)), worst


def probe(friction: float, case: base.Case) -> base.Evidence:
    """Let the handle slide to rest against friction computed from the sign of its velocity."""
    size, tail = peak_to_peak(friction, case)
    holds, shown = size <= FLICKER, compact(size, 2)
    steps = f"{shown} sensor step{'' if shown == '1' else 's'}"
    text = f"the handle {'flickers' if holds else 'shakes'} by {steps}"
    x = tail - tail.mean()
    return base.Evidence(x, 1.0 / case["rate"], "position", "counts", holds, size, "counts", text)


def live(friction: float, case: base.Case) -> base.Live:
    """Return the live settings of the friction scene, with friction from the sign of the velocity.

    The force after the release depends on the position within a count.
    """
    force = base.short(friction, limit(case))
    values = base.within("friction", {"kinetic_force": force, "static_force": force, "viscous": 0.0})
    loop = {**spring.loop_of(case), "delay": case["late"] / case["rate"]}
    found = base.Live("friction", {**values, "model": float(COULOMB)}, loop)
    size = {place: let_go(found, place, rows.APPLIED_FORCE) for place in _PLACES}
    place = max(size, key=lambda one: size[one])
    if size[place] >= values["kinetic_force"]:
        flips = f"The force jumps by {with_unit(size[place], 'N', 2)} and the handle never rests"
        outcome = f"{flips}. With the model Projection the handle comes to rest."
    else:
        further = "" if friction < limit(case) else " because it has friction of its own. Increase F further"
        outcome = f"The handle comes to rest{further}."
    return replace(
        found, advice=f"Drag to {on_screen(place, 'm')}, let go, and look at the force plot. {outcome}"
    )


FAILURE = base.Failure(
    key="chatter",
    title="Friction from the sign of the velocity",
    summary="Friction that follows the sign of the measured velocity shakes the handle by several sensor "
    "steps for ever",
    formula="The handle shakes if F T²/(m Δ) > 1.5 without delay, or > 0.7 with a delay of one period T, "
    "with friction F, mass m and sensor step Δ (found by simulation)",
    explanation="Near rest, a sensor with steps Δ shows either no velocity or one count in a period, and "
    "the sign of this velocity is noise. The friction force changes sign with it. In a period T this force "
    "moves a handle of mass m by F T²/(2 m) and leaves it with a speed of F T/m. If this speed carries the "
    "handle over more than about one count before the next reading, each change of sign causes the next "
    "one. With a model that knows a position to hold, such as Projection, the handle comes to rest.",
    knob=base.Parameter(
        "friction",
        "Friction",
        "N",
        1.0,
        0.0,
        1e4,
        "Friction of the handle, the same at rest and in motion",
        "F",
    ),
    limit=limit,
    probe=probe,
    plot=base.Plot(
        "friction, N",
        _SHARES,
        (
            base.Curve("friction from the sign"),
            base.Curve(
                "model Projection",
                lambda force, case: peak_to_peak(force, case, PROJECTION)[0],
                base.OTHER,
            ),
        ),
        "limit, found by simulation",
        lambda case: {"m Δ/T²": count_force(case)},
        level=FLICKER,
        level_label="1.5 sensor steps",
        y_label="shaking, peak to peak, sensor steps",
    ),
    options=(
        base.Choice("late", "Delay", ("none", "one_period"), "none"),
        spring.MASS,
        spring.VISCOUS,
        spring.QUANTUM,
        spring.RATE,
    ),
    live=live,
    margin=0.4,
    span=(0.1, 2.0),
    order=9,
)

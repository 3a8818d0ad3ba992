"""Friction by the sign of a counted velocity: beyond a force it chatters over several counts."""

import math
from dataclasses import replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures import base
from hapkit_studio.analysis.failures.in_window import let_go
from hapkit_studio.analysis.failures.spring import MASS, RATE, VISCOUS
from hapkit_studio.analysis.failures.traces import thinned
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.environments.friction import COULOMB, PROJECTION
from hapkit_studio.formatting import on_screen, with_unit
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings_writer import LoopSettings

# The ratio F_c T²/(m Δ) up to which the force only flickers within a count, by the delay in periods.
RATIOS = (1.5, 0.7)
# More than this, in counts, is felt as chatter.
FLICKER = 1.5
# Places in counts and speeds in m/s that the handle starts with: the worst one counts.
STARTS = ((0.0, 0.1234), (0.15, 0.05), (0.35, 0.2), (0.65, -0.08))
SECONDS, LAST = 3.0, 0.5
_PLACES = (0.01, 0.02, 0.03, 0.04)  # m: where the pointer lets go
_SHARES = np.array([0.1, 0.2, 0.3, 0.45, 0.6, 0.75, 0.9, 1.0, 1.15, 1.33, 1.5, 1.75, 2.0])


def count_force(case: base.Case) -> float:
    """Return m Δ/T² in N: the force that moves the handle by a count within a period."""
    return case["mass"] * case["quantum"] * case["rate"] ** 2


def limit(case: base.Case) -> float:
    """Return the friction in N above which it chatters over several counts; found by simulation."""
    return RATIOS[int(case["late"])] * count_force(case)


def slides(friction: float, case: base.Case, model: int = COULOMB) -> list[np.ndarray]:
    """Return the place (n,) in counts of a handle that slides to rest, one for each of STARTS."""
    values = dict(environments.named("friction").values())
    values |= {"model": float(model), "kinetic_force": friction, "static_force": friction, "viscous": 0.0}
    # half the stiffest spring that a handle of this damping can be held by, for the models that hold
    values["tether_stiffness"] = case["viscous"] * case["rate"] / (1.0 + 2.0 * case["late"])
    loop = LoopSettings(case["rate"], case["late"] / case["rate"])
    found = []
    for place, speed in STARTS:
        start = (place * case["quantum"], speed)
        device = SimulatedHapkit(case["mass"], case["viscous"], 0.0, case["quantum"], math.inf, *start)
        scene = headless.Scene(environments.named("friction"), values, device, loop)
        out, _ = headless.render(scene, None, round(SECONDS * case["rate"]))
        found.append(out[:, rows.TRUE_POSITION] / case["quantum"])
    return found


def peak_to_peak(friction: float, case: base.Case, model: int = COULOMB) -> tuple[float, np.ndarray]:
    """Return the largest p-p of the last half second in counts, and the tail (n,) that has it."""
    last = round(LAST * case["rate"])
    tails = [x[-last:] for x in slides(friction, case, model)]
    worst = max(tails, key=np.ptp)
    return float(np.ptp(worst)), worst


def probe(friction: float, case: base.Case) -> base.Evidence:
    """Let the handle slide to rest against friction by the sign of its velocity."""
    size, tail = peak_to_peak(friction, case)
    holds = size <= FLICKER
    time, x = thinned(np.arange(len(tail)) / case["rate"], tail - tail.mean())
    words = f"{'flickers' if holds else 'chatters'} by {with_unit(size, 'counts p-p', 2)}"
    return base.Evidence(time, x, "position", "counts", holds, size, "counts", words)


def curve(case: base.Case, progress: base.Progress) -> base.Chart:
    """Return the chatter over the friction, beside that of the implicit projection."""
    levels = limit(case) * _SHARES
    plain, held = [], []
    for done, level in enumerate(levels, 1):
        plain.append(peak_to_peak(level, case)[0])
        held.append(peak_to_peak(level, case, PROJECTION)[0])
        progress(done, len(levels))
    lines = (
        base.Line("by the sign of the velocity", levels, np.array(plain)),
        base.Line("implicit projection", levels, np.array(held), base.OTHER),
    )
    marks = (
        base.Mark(f"{RATIOS[int(case['late'])]:g} m Δ/T²", limit(case)),
        base.Mark("m Δ/T²", count_force(case)),
    )
    return base.Chart("friction, N", "chatter, counts p-p", lines, marks, FLICKER, "more than a flicker")


def live(friction: float, case: base.Case) -> base.Live:
    """Return the friction scene in the window, by the sign of the velocity."""
    force = base.short(friction, limit(case))
    values = base.within("friction", {"kinetic_force": force, "static_force": force, "viscous": 0.0})
    loop = {
        "rate": case["rate"],
        "delay": case["late"] / case["rate"],
        "estimator": "difference",
        "options": (),
    }
    found = base.Live("friction", {**values, "model": float(COULOMB)}, loop)
    return replace(found, advice=_advice(found, friction < limit(case)))


def _advice(found: base.Live, inside: bool) -> str:
    """Say where the handle is let go, and what its force does then: it depends on the place in a count."""
    size = {place: let_go(found, place, rows.APPLIED) for place in _PLACES}
    place = max(size, key=lambda one: size[one])
    first = f"Drag to {on_screen(place, 'm')}, let go, look at the force below."
    if size[place] < found.values["kinetic_force"]:
        return f"{first} It rests{'' if inside else ': the handle has friction of its own. Turn further'}."
    flips = f"It flips by {with_unit(size[place], 'N', 2)} and never rests"
    return f"{first} {flips}; with the model Projection it does."


FAILURE = base.Failure(
    key="chatter",
    title="Friction by the sign of the velocity",
    summary="A force that flips with a counted velocity throws the handle over several counts, forever",
    formula="F T²/(m Δ) > 1.5 without delay, 0.7 with one period of it (found by simulation)",
    explanation="Near rest a sensor of steps Δ shows either no velocity or one count in a period, and "
    "the sign of that is noise. The friction force flips with it. In a period T it moves a handle of "
    "mass m by F T²/(2 m) and leaves it with F T/m of speed; once that carries it over more than a "
    "count or so before the next look, each flip causes the next. A model that knows a place to "
    "hold, such as the implicit projection, rests.",
    knob=base.Parameter("friction", "Friction", "N", 1.0, 0.0, 1e4, "Kinetic and static", "F"),
    limit=limit,
    probe=probe,
    curve=curve,
    options=(
        base.Choice("late", "Delay", ("none", "one_period"), "none"),
        MASS,
        VISCOUS,
        base.Parameter("quantum", "Sensor step", "m", 20.7e-6, 1e-6, 1e-3, "One count", "Δ"),
        RATE,
    ),
    live=live,
    margin=0.4,
    span=(0.1, 2.0),
    order=9,
)

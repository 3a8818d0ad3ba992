"""Dry friction by seven models, to compare their artefacts with correct sticking and slipping.

A device measures position and speed, not the hand's force. Sticking is rendered by a stiff spring to an
anchor, which is dragged along when the spring force exceeds the friction level.
"""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from hapkit_studio.dynamics import sampled_loop
from hapkit_studio.dynamics.estimators import USUAL_QUANTUM, count_response
from hapkit_studio.dynamics.friction import banded, bristle, sticking_tether, stribeck, tether
from hapkit_studio.environments.base import Conditions, Environment, ForceTerms, Values
from hapkit_studio.formatting import compact, with_unit
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter

MODELS = ("coulomb", "smoothed", "karnopp", "stribeck", "projection", "tether", "lugre")
LABELS = ("Coulomb", "Smoothed", "Karnopp", "Stribeck", "Projection", "Tether", "LuGre")
COULOMB, SMOOTHED, KARNOPP, STRIBECK, PROJECTION, TETHER, LUGRE = range(len(MODELS))
# N: smallest friction, because zero friction has no ratio of kinetic to static
LEAST = 1e-3

# LuGre's bristles are treated as sliding from this fraction of the kinetic force on, because they reach the
# kinetic force only asymptotically
SLIDING = 0.99

# m/s: a slower handle is at rest in curves over velocity
REST = 1e-6

# s: period assumed by functions that receive only the scene's values
USUAL_PERIOD = 1e-3
# just-noticeable relative difference of a force (Jones: 6 to 7 %)
NOTICED = 0.07
SMALL_LACK = 0.01  # a deviation by less than this fraction of the friction causes no warning


@law(state={"anchor": 0.0, "slides": 0.0, "before": 0.0, "started": 0.0})
def force(p, s, x, v, dt):
    if s.started == 0.0:
        s.started = 1.0
        s.before = x
        s.anchor = x
    kinetic = max(p.kinetic_force, LEAST)
    static = max(p.static_force, kinetic)
    stiffness = p.tether_stiffness
    if p.model == "tether" or p.model == "projection":
        damping = stiffness * dt if p.model == "projection" else 0.0
        dry, s.anchor, s.slides = sticking_tether(
            x, s.before, s.anchor, s.slides, stiffness, damping, static, kinetic, dt
        )
    elif p.model == "karnopp":
        dry, s.anchor, s.slides = banded(x, v, s.anchor, stiffness, static, kinetic, p.stick_velocity)
    elif p.model == "stribeck" or p.model == "lugre":
        level = stribeck(v, static, kinetic, p.stribeck_velocity)
        if p.model == "stribeck":
            dry, s.anchor = tether(x, s.anchor, stiffness, level)
        else:
            bend = bristle(s.before - s.anchor, x - s.before, level, stiffness)
            dry = -stiffness * bend
            s.anchor = x - bend
            level = SLIDING * kinetic
        s.slides = 0.0 if abs(dry) < level else math.copysign(1.0, dry)
    else:
        dry = 0.0
        if p.model == "smoothed":
            dry = -kinetic * math.tanh(v / p.stick_velocity)
        elif v != 0.0:
            dry = -math.copysign(kinetic, v)
        s.anchor = x
        s.slides = 0.0
    s.before = x
    return dry - p.viscous * v


def unused(values: Values) -> dict[str, str]:
    """Return the parameters that the chosen model ignores."""
    model = int(values["model"])
    without = {
        "static_force": (COULOMB, SMOOTHED),
        "stribeck_velocity": (COULOMB, SMOOTHED, KARNOPP, PROJECTION, TETHER),
        "stick_velocity": (COULOMB, STRIBECK, PROJECTION, TETHER, LUGRE),
        "tether_stiffness": (COULOMB, SMOOTHED),
    }
    return {
        key: f'Not used by the model "{LABELS[model]}"' for key, models in without.items() if model in models
    }


def levels(values: Values) -> tuple[float, float]:
    """Return the (static, kinetic) friction in N used by the law."""
    kinetic = max(values["kinetic_force"], LEAST)
    return max(values["static_force"], kinetic), kinetic


def over_velocity(values: Values, v: np.ndarray) -> np.ndarray:
    """Return the force (n,) in N of steady sliding at v (n,) in m/s; at rest it is the static friction."""
    static, kinetic = levels(values)
    model = values["model"]
    level = np.full_like(v, kinetic)
    if model in (STRIBECK, LUGRE):
        level = kinetic + (static - kinetic) * np.exp(-((v / values["stribeck_velocity"]) ** 2))
    elif model == KARNOPP:
        level[np.abs(v) < values["stick_velocity"]] = static
    elif model in (TETHER, PROJECTION):
        level[np.abs(v) < REST] = static
    share = np.tanh(v / values["stick_velocity"]) if model == SMOOTHED else np.sign(v)
    return -level * share - values["viscous"] * v


def over_position(values: Values, x: np.ndarray) -> np.ndarray:
    """Return the force (2, n) in N of slow sliding to the right and to the left."""
    static, kinetic = levels(values)
    level = static if values["model"] in (STRIBECK, LUGRE, KARNOPP) else kinetic
    return np.array([np.full_like(x, -level), np.full_like(x, level)])


def impedance(values: Values) -> tuple[float, float]:
    """Return the stiffness of sticking, or the initial damping of a model that uses only the speed.

    The damping of plain Coulomb friction is computed at the lowest speed that a usual sensor resolves, a
    count per period.
    """
    kinetic, viscous = levels(values)[1], values["viscous"]
    by_speed: dict[float, float] = {
        COULOMB: USUAL_QUANTUM / USUAL_PERIOD,
        SMOOTHED: values["stick_velocity"],
        KARNOPP: values["stick_velocity"],
    }
    model = values["model"]
    stiffness = values["tether_stiffness"] if model not in (COULOMB, SMOOTHED) else 0.0
    return stiffness, viscous + (kinetic / by_speed[model] if model in by_speed else 0.0)


def terms(values: Values) -> ForceTerms:
    """Return viscous and kinetic friction, and the distance from a reversal to the full friction."""
    model = values["model"]
    held = model not in (COULOMB, SMOOTHED)
    level = max(values["static_force"], values["kinetic_force"])
    return ForceTerms(
        damping=values["viscous"],
        friction=values["kinetic_force"],
        settle=2.0 * level / values["tether_stiffness"] if held else 0.0,
        simple=model == COULOMB,
        terms=("damping", "friction"),
    )


def slow_slide(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if quantisation makes the model mistake slow sliding for fast sliding.

    A bristle moves with the count itself; the other models respond to the highest estimated speed.
    """
    model = values["model"]
    seen = count_response(conditions.estimator, 1.0 / conditions.period, conditions.quantum)
    fastest = float(seen[0] if model == LUGRE else seen.max())
    step = f"One step of the sensor in one period looks like a speed of {compact(1e3 * fastest, 3)} mm/s"
    if model == KARNOPP:
        if values["stick_velocity"] < fastest:
            yield f"{step}. Raise the stick velocity above this speed, so that the handle can stick."
        return
    static, kinetic = levels(values)
    lack = (1.0 - kinetic / static) * -math.expm1(-((fastest / values["stribeck_velocity"]) ** 2))
    if lack > SMALL_LACK:
        advice = "Smooth the velocity" if lack > NOTICED else "A hand does not notice this difference"
        yield f"{step}, so in slow sliding the friction is up to {100.0 * lack:.0f} % too small. {advice}."


def creep_speed(pull: float, values: Values) -> float:
    """Return the steady creep speed in m/s of smoothed friction under a pull in N below the friction."""
    from scipy.optimize import brentq  # imported here because it is slow

    kinetic, width, viscous = levels(values)[1], values["stick_velocity"], values["viscous"]
    # the speed without viscous friction, with a margin for rounding errors
    fastest = 1.001 * width * math.atanh(pull / kinetic)
    return float(brentq(lambda v: kinetic * math.tanh(v / width) + viscous * v - pull, 0.0, fastest))


def _damping_limit(conditions: Conditions) -> float:
    """Return the damping limit in N·s/m of a released handle.

    A nonlinear filter has no exact limit, so the limit of the difference estimator is returned.
    """
    released = replace(conditions, hand="released", own_grip=None)
    return sampled_loop.damping_limit(
        released if released.linear else replace(released, estimator="difference")
    )


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if a model exceeds its stability limit, and if a model cannot stick."""
    model, period = values["model"], conditions.period
    kinetic = levels(values)[1]
    if model == COULOMB:
        most = 1.5 * conditions.mass * conditions.quantum / (period * (period + conditions.delay))
        if 0.0 < most < kinetic:
            above = with_unit(most, "N", 2)
            shakes = f"Coulomb friction above {above} shakes the handle by several sensor steps."
            yield f"{shakes} Try the model Projection."
        elif kinetic > LEAST:
            yield "Coulomb friction cannot hold the handle: under a pull it creeps. Try the model Projection."
        return
    if model == SMOOTHED:
        slope, most = kinetic / values["stick_velocity"], _damping_limit(conditions)
        if slope > most:
            steep = f"Near rest, smoothed friction acts as damping of {compact(slope, 3)} N·s/m"
            yield f"{steep}, above the stability limit of {compact(most, 3)} N·s/m. Raise the stick velocity."
        if kinetic > LEAST:
            pull = 0.5 * kinetic
            creep = 1e3 * creep_speed(pull, values)
            slow = f"under a pull of {compact(pull, 2)} N, the handle creeps at {compact(creep, 2)} mm/s"
            yield f"Smoothed friction cannot hold the handle: {slow}."
        return
    if model in (KARNOPP, STRIBECK, LUGRE):
        yield from slow_slide(values, conditions)
    if model == LUGRE and kinetic > LEAST and conditions.quantum > 0.0:
        yield "Under a steady pull, the handle creeps at about 0.5 mm/s with LuGre friction."
    if model == LUGRE and values["tether_stiffness"] * conditions.speed * period > 2.0 * kinetic:
        most = 2.0 * kinetic / (values["tether_stiffness"] * period)
        above = with_unit(most, "m/s", 2)
        yield f"Above {above}, LuGre friction only slides: its spring is fully bent within one period."


ENVIRONMENT = Environment(
    key="friction",
    title="Friction",
    summary="Holds, then slips",
    parameters=(
        Choice(
            "model",
            "Model",
            MODELS,
            "projection",
            "Model that computes the friction. Coulomb and Smoothed use only the speed, so they cannot hold "
            "the handle at rest. Karnopp holds the handle below a small speed. Tether (a virtual "
            "spring) and Projection (the same with a damper) hold it and then let go suddenly. "
            "Stribeck and LuGre hold it and then let go gradually.",
            labels=LABELS,
            method=True,
            exact="projection",  # the only model that sticks without oscillation, like dry friction
        ),
        Parameter(
            "kinetic_force", "Kinetic force", "N", 0.4, 0.0, 3.0, "Friction while the handle slides", "F_k"
        ),
        Parameter(
            "static_force",
            "Static force",
            "N",
            0.6,
            0.0,
            3.0,
            "Pull at which a resting handle begins to slide",
            "F_s",
        ),
        Parameter(
            "viscous",
            "Viscous damping",
            "N·s/m",
            1.0,
            0.0,
            20.0,
            "Force against the motion for each m/s of speed",
            "b",
        ),
        Parameter(
            "stribeck_velocity",
            "Stribeck velocity",
            "m/s",
            0.02,
            0.001,
            0.2,
            "For Stribeck and LuGre: speed at which friction has dropped 63 % of the way from static to "
            "kinetic friction",
            "v_S",
        ),
        Parameter(
            "stick_velocity",
            "Stick velocity",
            "m/s",
            0.03,
            0.001,
            0.2,
            (
                "For Karnopp: speed below which friction holds the handle. For Smoothed: speed at which "
                "friction is 76 % of its full force"
            ),
            "Δv",
        ),
        Parameter(
            "tether_stiffness",
            "Tether stiffness",
            "N/m",
            500.0,
            100.0,
            2e4,
            "Stiffness of the virtual spring that holds the handle at rest",
            "k",
        ),
    ),
    force=force,
    shortcut="4",
    formula="|<i>F</i>| ≤ <i>F</i><sub>s</sub> at rest, <i>F</i><sub>k</sub> + <i>b</i>|<i>v</i>| sliding",
    symbols="<i>F</i><sub>s</sub> static force, <i>F</i><sub>k</sub> kinetic force, "
    "<i>b</i> viscous damping, <i>v</i> velocity",
    explanation="Friction holds a resting handle against any pull up to the static force. While the handle "
    "slides, friction resists with less force. So a body that is pulled by a spring sticks, slips "
    "and sticks again. A law that uses only the speed cannot hold the handle: near rest, the sign of "
    "the measured speed is noise, and the force jumps to and fro. A virtual spring (the tether) can "
    "hold the handle: it ties the handle to a point. When you pull harder than friction can hold, this "
    "point moves along.",
    impedance=impedance,
    terms=terms,
    unused=unused,
    warnings=warnings,
    over_position=over_position,
    over_velocity=over_velocity,
    hands=("stroke", "pluck", "released"),
    needs=("mass", "viscous", "coulomb", "quantization", "sampling", "delay", "filter"),
    order=4,
)

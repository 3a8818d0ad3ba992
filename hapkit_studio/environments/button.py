"""Button: the force rises, drops at the snap and meets a stop; on release it follows a lower curve."""

from collections.abc import Iterable

import numpy as np

from hapkit_studio.dynamics.friction import tether
from hapkit_studio.environments.base import Conditions, Environment, ForceTerms, MovingObject, Values
from hapkit_studio.formatting import with_unit
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter

# N/m: stiffness of the hysteresis between press and release, as high as a paddle can render. The hysteresis
# fades in over the first half millimetre, so that contact causes no step of the force.
PLAY_STIFFNESS = 1500.0
FADE = 0.0005


def curve(s, peak, snap, snap_start, travel, stop):
    """Return the button's force in N (>= 0) at a travel ``s`` in m (>= 0), without hysteresis."""
    if s >= travel:
        return snap + stop * (s - travel)
    if s < snap_start:
        u = s / snap_start
        return peak * u * (2.0 - u)
    u = (s - snap_start) / (travel - snap_start)
    return peak + (snap - peak) * u * u * (3.0 - 2.0 * u)


@law(state={"anchor": 0.0, "held": 0.0, "pressed": 0.0, "downs": 0.0, "ups": 0.0})
def force(p, s, x, v, dt):
    if s.held < 0.5:
        s.held = 1.0
        s.anchor = x
    pull, s.anchor = tether(x, s.anchor, PLAY_STIFFNESS, p.hysteresis)
    depth = x - p.position
    if s.pressed < 0.5:
        if depth > 0.5 * (p.snap_start + p.travel):
            s.pressed = 1.0
            s.downs += 1.0
    elif depth < 0.5 * p.snap_start:
        s.pressed = 0.0
        s.ups += 1.0
    if depth <= 0.0:
        return 0.0
    push = curve(depth, p.peak_force, p.snap_force, p.snap_start, p.travel, p.stop_stiffness)
    return pull * min(depth / FADE, 1.0) - push


def check(values: Values) -> str:
    """Return why the snap cannot start at the chosen position; "" if it can."""
    start, travel = 1e3 * values["snap_start"], 1e3 * values["travel"]
    if start < travel:
        return ""
    return f"The snap start must be less than the press depth of {travel:g} mm, not {start:g} mm."


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if there is no snap."""
    if values["snap_force"] >= values["peak_force"]:
        yield (
            f"The button does not click: lower the snap force ({with_unit(values['snap_force'], 'N')}) "
            f"below the peak force ({with_unit(values['peak_force'], 'N')})."
        )


def over_position(values: Values, x: np.ndarray) -> np.ndarray:
    """Return the press and release curves (2, n) in N over x (n,) in m."""
    names = ("peak_force", "snap_force", "snap_start", "travel", "stop_stiffness")
    numbers = [values[name] for name in names]
    depth = np.maximum(x - values["position"], 0.0)
    push = np.array([curve(d, *numbers) for d in depth.tolist()])
    play = values["hysteresis"] * np.minimum(depth / FADE, 1.0)
    return np.array([-push - play, -push + play])


def impedance(values: Values) -> tuple[float, float]:
    """Return the steepest slope of the curve; the hysteresis adds its stiffness only within a few counts."""
    first = 2.0 * values["peak_force"] / values["snap_start"]
    drop = abs(values["peak_force"] - values["snap_force"]) / (values["travel"] - values["snap_start"])
    return max(first, 1.5 * drop, values["stop_stiffness"]), 0.0


ENVIRONMENT = Environment(
    key="button",
    title="Button",
    summary="Clicks when you press it",
    parameters=(
        Parameter(
            "peak_force", "Peak force", "N", 1.0, 0.2, 3.0, "Force at which the button snaps", "F<sub>1</sub>"
        ),
        Parameter(
            "snap_force", "Snap force", "N", 0.5, 0.0, 3.0, "Force right after the snap", "F<sub>2</sub>"
        ),
        Parameter(
            "snap_start",
            "Snap start",
            "m",
            0.004,
            0.001,
            0.01,
            "How far the button is pressed when the snap starts",
            "s<sub>1</sub>",
        ),
        Parameter(
            "travel",
            "Press depth",
            "m",
            0.007,
            0.002,
            0.015,
            "How far the button can be pressed until it meets the hard stop",
            "s<sub>2</sub>",
        ),
        Parameter(
            "stop_stiffness",
            "Stop stiffness",
            "N/m",
            500.0,
            0.0,
            2000.0,
            "Stiffness of the hard stop at the full press depth",
            "k<sub>e</sub>",
        ),
        Parameter(
            "hysteresis",
            "Hysteresis",
            "N",
            0.1,
            0.0,
            0.5,
            "Force added to the button's force while you press, and subtracted from it while you release",
            "h",
        ),
        Parameter(
            "position",
            "Position",
            "m",
            0.005,
            -0.04,
            0.04,
            "Position of the button's cap when not pressed",
            "x<sub>b</sub>",
        ),
    ),
    force=force,
    shortcut="8",
    formula="<i>F</i> = −[<i>f</i>(<i>s</i>) + <i>h</i>(<i>s</i>)]",
    symbols="<i>s</i> distance pressed, <i>f</i> spring force of the button, <i>h</i> hysteresis",
    explanation="A button is a hill of force, followed by a hard stop. The force rises to its peak, then "
    "drops while you keep pressing: your finger still presses as hard as at the peak, so it falls through "
    "to the stop. That is the click. On the way out, the force is lower by twice the hysteresis, so a full "
    "cycle absorbs energy, and the cap does not bounce.",
    impedance=impedance,
    terms=lambda p: ForceTerms(contact=True, simple=False),
    check=check,
    warnings=warnings,
    over_position=over_position,
    shades=True,
    moves=MovingObject("cap", rests="position"),
    counts=("downs", "ups"),
    hands=("press", "pluck", "released"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay", "saturation"),
    order=8,
)

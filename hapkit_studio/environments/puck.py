"""A puck that slides between two walls; the handle pushes it from either side."""

from collections.abc import Iterable

import numpy as np

from hapkit_studio.dynamics.integrators import step
from hapkit_studio.dynamics.moving_mass import flown_apart, pushed
from hapkit_studio.environments.base import Conditions, Environment, MovingObject, Values, no_terms
from hapkit_studio.environments.pushed import contact, growth, integrator
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter

START = 0.010
RADIUS = 0.005
# m: the largest distance of the puck from the middle, at which it touches a wall
REACH = 0.040 - RADIUS

STATE = dict.fromkeys(
    ("object", "object_velocity", "object_acceleration", "side", "started", "handle", "handle_velocity"), 0.0
)


def begin(x):
    """Return the puck's initial position: START, or beside the handle if the handle is at START."""
    gap = x - START
    if abs(gap) >= RADIUS:
        return START
    return x + RADIUS if gap < 0.0 else x - RADIUS


@law(state=STATE)
def force(p, s, x, v, dt):
    """Integrate the puck's motion over the last period, then return the puck's force on the handle."""
    if s.started == 0.0:
        s.started = 1.0
        s.object = begin(x)
        s.object_velocity = 0.0
        s.object_acceleration = 0.0
    elif dt > 0.0:
        touch = s.handle + (RADIUS if s.side > 0.0 else -RADIUS)
        s.object, s.object_velocity, s.object_acceleration = step(
            p.integrator, s.object, s.object_velocity, s.object_acceleration, dt, p.friction,
            p.mass, 0.0, 0.0, 0.0, touch, s.side, s.handle_velocity,
            p.contact_stiffness, p.contact_damping, REACH, p.wall_stiffness,
        )  # fmt: skip
        if flown_apart(s.object, s.object_velocity) > 0.0:
            s.started, s.object = 0.0, START
            s.object_velocity = 0.0
            return 0.0
    # at any depth inside the puck, the handle stays on the side from which it came
    gap = x - s.object
    if s.side == 0.0 or abs(gap) >= RADIUS:
        s.side = 1.0 if gap < 0.0 else -1.0
    s.handle = x
    s.handle_velocity = v
    touch = x + (RADIUS if s.side > 0.0 else -RADIUS)
    return -pushed(s.object, s.object_velocity, touch, s.side, v, p.contact_stiffness, p.contact_damping)


@law(state=STATE)
def stored(p, s, x, v, dt):
    """Return the energy in motion, contact and walls."""
    depth = max(0.0, s.side * (x - s.object) + RADIUS)
    beyond = max(0.0, abs(s.object) - REACH)
    moving = p.mass * s.object_velocity * s.object_velocity
    return 0.5 * (moving + p.contact_stiffness * depth * depth + p.wall_stiffness * beyond * beyond)


def swing(p: Values) -> tuple[float, float, float]:
    """Return mass, damping and stiffness of the puck between wall and handle."""
    return p["mass"], 0.0, p["wall_stiffness"] + p["contact_stiffness"]


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if the chosen integrator makes the puck gain energy in contact."""
    return growth(values, swing(values), conditions)


ENVIRONMENT = Environment(
    key="puck",
    title="Puck",
    summary="A puck to push and catch",
    parameters=(
        Parameter("mass", "Mass", "kg", 0.5, 0.05, 5.0, "Mass of the puck", "m"),
        *contact("puck"),
        Parameter(
            "wall_stiffness",
            "Wall stiffness",
            "N/m",
            500.0,
            50.0,
            5000.0,
            "Stiffness of the two walls",
            "k<sub>w</sub>",
        ),
        Parameter(
            "friction",
            "Friction",
            "N",
            0.0,
            0.0,
            3.0,
            "Dry friction between the puck and the ground",
            "F<sub>c</sub>",
        ),
        integrator("puck"),
    ),
    force=force,
    shortcut="P",
    formula="<i>m&nbsp;ẍ</i> = <i>F</i><sub>u</sub> − <i>k</i><sub>w</sub>&nbsp;<i>d</i><sub>w</sub>, "
    "<i>F</i>&nbsp;=&nbsp;−<i>F</i><sub>u</sub>",
    symbols="<i>x</i> position of the puck, <i>m</i> mass, <i>F</i><sub>u</sub> contact force, "
    "<i>k</i><sub>w</sub> wall stiffness, <i>d</i><sub>w</sub> depth of the puck in a wall, "
    "<i>F</i> force on the handle",
    explanation="A free mass slides between two walls. Handle and walls push it through springs: the deeper "
    "the contact, the larger the force. The handle feels the same force back. A push gives the puck "
    "momentum: the force summed over the time of contact. A bounce that is computed exactly keeps the "
    "puck's energy. Explicit Euler and the lecture's rule add energy, implicit Euler takes some "
    "away. With too much energy the puck flies out and is reset to rest.",
    impedance=lambda p: (p["contact_stiffness"], p["contact_damping"]),
    terms=no_terms,
    # the force depends on the puck's position, so there is no curve over the handle's position
    over_position=lambda values, x: np.full_like(x, np.nan),
    warnings=warnings,
    stored=stored,
    moves=MovingObject("puck", state="object", swing=swing),
    hands=("tap", "shake", "released"),
    restless="Without friction the puck moves back and forth between the walls for ever.",
    needs=("mass", "viscous", "coulomb", "quantization", "sampling", "delay"),
    order=11,
)

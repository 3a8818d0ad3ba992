"""A mass on a spring and damper, pushed by the handle from the left; the user selects the integrator."""

from collections.abc import Iterable

import numpy as np

from hapkit_studio.dynamics.integrators import step
from hapkit_studio.dynamics.moving_mass import FAR, flown_apart, pushed
from hapkit_studio.environments.base import Conditions, Environment, MovingObject, Values, no_terms
from hapkit_studio.environments.pushed import contact, growth, integrator
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter

STATE = dict.fromkeys(
    ("object", "object_velocity", "object_acceleration", "started", "handle", "handle_velocity"), 0.0
)


@law(state=STATE)
def force(p, s, x, v, dt):
    """Integrate the object's motion over the last period, then return the object's force on the handle."""
    begins = s.started == 0.0
    if begins:
        s.started = 1.0
        s.object = p.rest_position
        s.object_velocity = 0.0
    elif dt > 0.0:
        s.object, s.object_velocity, s.object_acceleration = step(
            p.integrator, s.object, s.object_velocity, s.object_acceleration, dt, 0.0,
            p.mass, p.damping, p.stiffness, p.stiffness * p.rest_position, s.handle, 1.0, s.handle_velocity,
            p.contact_stiffness, p.contact_damping, FAR, 0.0,
        )  # fmt: skip
        if flown_apart(s.object, s.object_velocity) > 0.0:
            s.started, s.object = 0.0, p.rest_position
            s.object_velocity = 0.0
            return 0.0
    s.handle = x
    s.handle_velocity = v
    push = pushed(s.object, s.object_velocity, x, 1.0, v, p.contact_stiffness, p.contact_damping)
    if begins:
        s.object_acceleration = push / p.mass
    return -push


@law(state=STATE)
def stored(p, s, x, v, dt):
    """Return the energy in motion, spring and contact."""
    depth = max(0.0, x - s.object)
    swing = s.object - p.rest_position
    moving = p.mass * s.object_velocity * s.object_velocity
    return 0.5 * (moving + p.stiffness * swing * swing + p.contact_stiffness * depth * depth)


def pushed_slowly(p: Values, x: np.ndarray) -> np.ndarray:
    """Return the force over position of contact and spring in series."""
    both = p["contact_stiffness"] * p["stiffness"] / (p["contact_stiffness"] + p["stiffness"])
    return -both * np.maximum(x - p["rest_position"], 0.0)


def swing(p: Values) -> tuple[float, float, float]:
    """Return mass, damping and stiffness of the object in contact."""
    return p["mass"], p["damping"], p["stiffness"] + p["contact_stiffness"]


def warnings(values: Values, conditions: Conditions) -> Iterable[str]:
    """Warn if the chosen integrator makes the mass gain energy in contact."""
    return growth(values, swing(values), conditions)


ENVIRONMENT = Environment(
    key="mass_spring_damper",
    title="Mass–spring–damper",
    summary="Push a moving mass",
    parameters=(
        Parameter("mass", "Mass", "kg", 2.0, 0.05, 5.0, "Mass of the pushed object", "m"),
        Parameter(
            "damping",
            "Damping",
            "N·s/m",
            1.0,
            0.0,
            20.0,
            "Force that brakes the object, for each m/s of its speed",
            "b",
        ),
        Parameter(
            "stiffness",
            "Stiffness",
            "N/m",
            300.0,
            0.0,
            2000.0,
            "Stiffness of the spring that holds the object",
            "k",
        ),
        *contact("object"),
        Parameter(
            "rest_position",
            "Rest position",
            "m",
            0.01,
            -0.04,
            0.04,
            "Position of the object where its spring exerts no force",
            "x<sub>eq</sub>",
        ),
        integrator("object"),
    ),
    force=force,
    shortcut="M",
    formula="<i>m&nbsp;ẍ</i> = <i>F</i><sub>u</sub> − <i>b&nbsp;ẋ</i> − "
    "<i>k</i>(<i>x</i>&nbsp;−&nbsp;<i>x</i><sub>eq</sub>), "
    "<i>F</i>&nbsp;=&nbsp;−<i>F</i><sub>u</sub>",
    symbols="<i>x</i> position of the object, <i>m</i> mass, <i>F</i><sub>u</sub> contact force, "
    "<i>b</i> damping, <i>k</i> stiffness, <i>x</i><sub>eq</sub> rest position, <i>F</i> force on the handle",
    explanation="The handle pushes an object from the left through a contact spring and feels the same force "
    "back. The object is a mass on a spring with a damper, so it keeps swinging when the handle "
    "leaves it. The motion is computed step by step by an integrator. Explicit Euler and the "
    "lecture's rule add energy in each step. If the damper takes away less energy than that, the "
    "swing grows until the object is reset to rest. Semi-implicit Euler needs no more "
    "computing time, and its swing does not grow.",
    impedance=lambda p: (p["contact_stiffness"], p["contact_damping"]),
    terms=no_terms,
    over_position=pushed_slowly,
    stored=stored,
    moves=MovingObject("mass", state="object", swing=swing),
    warnings=warnings,
    hands=("press", "tap", "released"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay"),
    order=10,
)

"""A mass on a spring: the handle pulls a mass that swings on, and feels its pull."""

from hapkit_studio.environments.base import Environment, MovingObject
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


# The mass has a place and a velocity of its own. The law keeps them in its memory s, which starts as here.
@law(state={"object": 0.0, "velocity": 0.0})
def force(p, s, x, v, dt):
    # The spring between handle and mass: positive where it pulls the mass to the right.
    pull = p.stiffness * (x - s.object) + p.damping * (v - s.velocity)
    # Newton: acceleration = force / mass. First the new velocity, then the new place with it:
    # the other way round, the swing would grow by itself. The mass stays within the range of the handle.
    s.velocity += pull / p.mass * dt
    s.object = min(max(s.object + s.velocity * dt, -0.06), 0.06)
    # What pulls the mass to the right pulls the handle to the left.
    return -pull


ENVIRONMENT = Environment(
    key="my_mass",
    title="My mass on a spring",
    summary="A mass that swings on",
    parameters=(
        # name in the law, label, unit, default, lowest, highest, help; a mass of 0 could not be divided by
        Parameter("mass", "Mass", "kg", 0.1, 0.05, 1.0, "What hangs on the spring"),
        Parameter("stiffness", "Stiffness", "N/m", 50.0, 0.0, 300.0, "Force per metre of stretch"),
        Parameter("damping", "Damping", "N·s/m", 0.1, 0.0, 1.0, "Force per metre per second of stretch"),
    ),
    force=force,
    # the plot of position shows this state besides the handle, under this name
    moves=MovingObject("mass", state="object"),
    # how the force is written; with another law, write another formula or none
    formula="<i>F</i> = −<i>k</i> (<i>x</i> − <i>x</i>ₘ) − <i>b</i> (<i>v</i> − <i>v</i>ₘ)",
    impedance=lambda p: (p["stiffness"], p["damping"]),
)

"""A mass on a spring: the handle pulls a swinging mass and feels its pull."""

from hapkit_studio.environments.base import Environment, MovingObject
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


# The mass has its own position and velocity. The law stores them in its memory s, which starts with these
# values.
@law(state={"object": 0.0, "velocity": 0.0})
def force(p, s, x, v, dt):
    # The spring between handle and mass: positive where it pulls the mass to the right.
    pull = p.stiffness * (x - s.object) + p.damping * (v - s.velocity)
    # Newton: acceleration = force / mass. Compute the new velocity first and use it for the new position:
    # in the opposite order, the oscillation would grow. The mass stays within the range of the handle.
    s.velocity += pull / p.mass * dt
    s.object = min(max(s.object + s.velocity * dt, -0.06), 0.06)
    # The spring pulls the handle with the opposite force.
    return -pull


ENVIRONMENT = Environment(
    key="my_mass",
    title="My mass on a spring",
    summary="A mass that keeps swinging",
    parameters=(
        # name in the law, label, unit, default, lowest, highest, help; the law divides by the mass, so its
        # lowest value is not 0
        Parameter("mass", "Mass", "kg", 0.1, 0.05, 1.0, "Mass on the spring"),
        Parameter("stiffness", "Stiffness", "N/m", 50.0, 0.0, 300.0, "Force per metre of stretch"),
        Parameter("damping", "Damping", "N·s/m", 0.1, 0.0, 1.0, "Force per metre per second of stretch"),
    ),
    force=force,
    # the position plot shows this state next to the handle, with this name
    moves=MovingObject("mass", state="object"),
    # the formula shown for the law; if you change the law, change or delete it
    formula="<i>F</i> = −<i>k</i> (<i>x</i> − <i>x</i>ₘ) − <i>b</i> (<i>v</i> − <i>v</i>ₘ)",
    impedance=lambda p: (p["stiffness"], p["damping"]),
)

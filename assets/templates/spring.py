"""A spring: the farther the handle is from the centre, the harder it pulls back."""

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


# The law is called once every millisecond. Its arguments are
#   p   the parameters declared below, set with the sliders
#   s   the memory between calls (this law needs none)
#   x   the position of the handle in m, positive to the right
#   v   its velocity in m/s
#   dt  the time between two calls in s
# It returns the force on the handle in N, positive to the right.
@law
def force(p, s, x, v, dt):
    return -p.stiffness * (x - p.center) - p.damping * v


ENVIRONMENT = Environment(
    key="my_spring",
    title="My spring",
    summary="Pulls back to its centre",
    parameters=(
        # name in the law, label, unit, default, lowest, highest, help
        Parameter("stiffness", "Stiffness", "N/m", 80.0, 0.0, 2000.0, "Force per metre from the centre"),
        Parameter("damping", "Damping", "N·s/m", 0.5, 0.0, 20.0, "Force per metre per second"),
        Parameter("center", "Centre", "m", 0.0, -0.04, 0.04, "Where the spring is at rest"),
    ),
    force=force,
    # the picture; drawn only if the names and limits of the parameters match it
    scene="spring",
    # the formula shown for the law (if you change the law, change or delete it),
    # and the stiffness and damping that limit its stability
    formula="<i>F</i> = −<i>k</i> (<i>x</i> − <i>x</i>₀) − <i>b v</i>",
    impedance=lambda p: (p["stiffness"], p["damping"]),
)

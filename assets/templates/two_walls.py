"""Two walls with a free gap between them; each is a spring and a damper."""

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


# This function is used for both walls. A law may call functions of its own file.
# depth in m is the handle's distance behind the surface, rate in m/s its speed into the wall. The force is
# never negative.
def wall(depth, rate, stiffness, damping):
    if depth <= 0.0:
        return 0.0
    return stiffness * depth + damping * max(rate, 0.0)


# x is the handle's position in m, v its velocity in m/s; the force is in N. Right is positive.
@law
def force(p, s, x, v, dt):
    half = p.gap / 2
    right = wall(x - half, v, p.stiffness, p.damping)
    # The left wall mirrors the right wall: x, v and the force change sign.
    left = wall(-x - half, -v, p.stiffness, p.damping)
    return left - right


ENVIRONMENT = Environment(
    key="my_two_walls",
    title="My two walls",
    summary="A gap to move in",
    parameters=(
        # name in the law, label, unit, default, lowest, highest, help
        Parameter("gap", "Gap", "m", 0.03, 0.0, 0.1, "Distance between the walls"),
        Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 5000.0, "Force per metre of depth"),
        Parameter("damping", "Damping", "N·s/m", 1.0, 0.0, 50.0, "Force per metre per second on the way in"),
    ),
    force=force,
    # the formula shown for the law; if you change the law, change or delete it
    formula="<i>F</i> = ∓ (<i>k d</i> + <i>b v</i>) inside",
    impedance=lambda p: (p["stiffness"], p["damping"]),
    shades=True,
)

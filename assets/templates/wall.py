"""A wall: no force outside, a spring and a damper inside."""

from hapkit_studio.environments.base import Environment
from hapkit_studio.laws import law
from hapkit_studio.parameters import Choice, Parameter


# x is the handle's position in m, v its velocity in m/s; the force is in N. Right is positive.
@law
def force(p, s, x, v, dt):
    # depth is the distance behind the surface, rate the speed into the wall.
    side = 1.0 if p.side == "right" else -1.0
    depth = side * (x - p.position)
    rate = side * v
    if depth <= 0.0:
        return 0.0
    push = p.stiffness * depth
    # The wall damps the way in only, so it never pulls the handle on the way out.
    if rate > 0.0:
        push += p.damping * rate
    return -side * push


ENVIRONMENT = Environment(
    key="my_wall",
    title="My wall",
    summary="Pushes back if pressed",
    parameters=(
        # name in the law, label, unit, default, lowest, highest, help
        Parameter("stiffness", "Stiffness", "N/m", 300.0, 0.0, 5000.0, "Force per metre of depth"),
        Parameter("damping", "Damping", "N·s/m", 1.0, 0.0, 50.0, "Force per metre per second on the way in"),
        Parameter("position", "Position", "m", 0.005, -0.04, 0.04, "Where the surface is"),
        # name in the law, label, the options: the first one is the default
        Choice("side", "Side", ("right", "left"), help="Side of the wall"),
    ),
    force=force,
    scene="wall",
    # the formula shown for the law; if you change the law, change or delete it
    formula="<i>F</i> = −<i>k d</i> − <i>b v</i> inside",
    impedance=lambda p: (p["stiffness"], p["damping"]),
    shades=True,
)

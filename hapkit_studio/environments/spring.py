"""Virtual spring: a force proportional to the distance from its centre, the test case of stability."""

from hapkit_studio.environments.base import Environment, ForceTerms
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    return -p.stiffness * (x - p.center) - p.damping * v


ENVIRONMENT = Environment(
    key="spring",
    title="Spring",
    summary="Pulls back to its centre",
    parameters=(
        Parameter(
            "stiffness",
            "Stiffness",
            "N/m",
            80.0,
            0.0,
            2000.0,
            "Force for each metre of distance from the centre",
            "k",
        ),
        Parameter(
            "damping",
            "Damping",
            "N·s/m",
            0.0,
            0.0,
            50.0,
            "Force against the motion for each m/s of speed",
            "b",
        ),
        Parameter("center", "Centre", "m", 0.0, -0.04, 0.04, "Position to which the spring pulls", "x₀"),
    ),
    force=force,
    shortcut="1",
    formula="<i>F</i> = −<i>k</i> (<i>x</i> − <i>x</i>₀) − <i>b v</i>",
    symbols="<i>k</i> stiffness, <i>x</i> position, <i>x</i>₀ centre, <i>b</i> damping, <i>v</i> velocity",
    explanation="The farther you are from its centre, the harder the spring pulls back. The computed force "
    "stays the same for a whole period of the loop, so the spring pushes a little longer on the "
    "way out than it resisted on the way in. Above a certain stiffness, this adds more energy "
    "than the paddle's friction takes away.",
    impedance=lambda p: (p["stiffness"], p["damping"]),
    terms=lambda p: ForceTerms(
        p["stiffness"], p["damping"], centre=p["center"], terms=("stiffness", "damping")
    ),
    hands=("released", "press", "stroke"),
    needs=("mass", "viscous", "coulomb", "sampling", "delay"),
    order=1,
)

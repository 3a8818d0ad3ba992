"""Virtual damping: a force against the motion, proportional to the speed."""

from hapkit_studio.environments.base import Environment, ForceTerms
from hapkit_studio.laws import law
from hapkit_studio.parameters import Parameter


@law
def force(p, s, x, v, dt):
    return -p.damping * v


ENVIRONMENT = Environment(
    key="damping",
    title="Damping",
    summary="Resists fast motion",
    parameters=(
        Parameter(
            "damping",
            "Damping",
            "N·s/m",
            4.0,
            0.0,
            50.0,
            "Force against the motion for each m/s of speed",
            "b",
        ),
    ),
    force=force,
    shortcut="3",
    formula="<i>F</i> = −<i>b v</i>",
    symbols="<i>b</i> damping, <i>v</i> velocity",
    explanation="Damping is a force against the motion, as if you stirred honey. The sensor measures the "
    "position in small steps, called counts. So the computed speed changes in steps of one count per "
    "period of the loop, and the force changes in steps of b × count × rate.",
    impedance=lambda p: (0.0, p["damping"]),
    terms=lambda p: ForceTerms(0.0, p["damping"], terms=("stiffness", "damping")),
    hands=("released", "stroke", "sweep"),
    needs=("mass", "viscous", "coulomb", "delay", "filter"),
    order=3,
)

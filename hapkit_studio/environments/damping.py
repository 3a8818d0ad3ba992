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
    summary="Slower is easier",
    parameters=(
        Parameter("damping", "Damping", "N·s/m", 4.0, 0.0, 50.0, "Force per m/s, against the motion", "b"),
    ),
    force=force,
    shortcut="3",
    formula="<i>F</i> = −<i>b v</i>",
    explanation="A force against the motion, like stirring honey. The speed is computed from sensor counts, "
    "so it changes in steps of one count per period, and the force changes in steps of b × count "
    "× rate.",
    impedance=lambda p: (0.0, p["damping"]),
    terms=lambda p: ForceTerms(0.0, p["damping"], terms=("stiffness", "damping")),
    hands=("released", "stroke", "sweep"),
    needs=("mass", "viscous", "coulomb", "delay", "filter"),
    order=3,
)

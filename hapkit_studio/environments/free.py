"""Free: there is no force, and the handle moves only by the paddle's dynamics."""

from hapkit_studio.environments.base import Environment, ForceTerms
from hapkit_studio.laws import law


@law
def force(p, s, x, v, dt):
    return 0.0


ENVIRONMENT = Environment(
    key="free",
    title="Free",
    summary="A paddle without force",
    parameters=(),
    force=force,
    shortcut="0",
    formula="<i>F</i> = 0",
    explanation="The motor gives no force. You feel only the paddle itself: its mass, the friction of its "
    "bearing and cable, and the motor that your hand turns.",
    terms=lambda p: ForceTerms(0.0, 0.0, terms=("stiffness", "damping")),
    hands=("released", "stroke", "tap"),
    needs=("mass", "viscous", "coulomb"),
    order=0,
)

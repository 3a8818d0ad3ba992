"""What the objects that the handle pushes share: contact, integrator, and when its step is too long."""

from collections.abc import Iterator

from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.dynamics.step_limits import longest_step
from hapkit_studio.environments.base import Conditions, Values
from hapkit_studio.parameters import Choice, Parameter


def contact(what: str) -> tuple[Parameter, Parameter]:
    """Return the stiffness and damping between the handle and an object of this name."""
    inside = f"Force per metre that the handle is inside the {what}"
    closing = f"Force per metre per second while handle and {what} approach each other in contact"
    return (
        Parameter(
            "contact_stiffness", "Contact stiffness", "N/m", 500.0, 50.0, 5000.0, inside, "k<sub>u</sub>"
        ),
        Parameter("contact_damping", "Contact damping", "N·s/m", 0.0, 0.0, 50.0, closing, "b<sub>u</sub>"),
    )


def integrator(what: str) -> Choice:
    """Return the choice of how an object's motion is computed."""
    words = f"How the {what}'s motion is computed. Explicit Euler and the lecture's rule add energy."
    return Choice("integrator", "Integrator", INTEGRATORS, "semi_implicit", words)


def growth(values: Values, damping: float, stiffness: float, conditions: Conditions) -> Iterator[str]:
    """Say where the chosen integrator makes an object of that damping, stiffness in contact gain energy."""
    method = INTEGRATORS[int(values["integrator"])]
    longest = longest_step(method, values["mass"], damping, stiffness)
    if conditions.period > longest:
        yield (
            f"In contact {method.replace('_', ' ')} adds energy at steps above {1e3 * longest:.3g} ms; "
            f"they take {1e3 * conditions.period:.3g} ms."
        )

"""Functions for objects that the handle pushes: parameters, and a check of the integrator's step."""

from collections.abc import Iterator

from hapkit_studio.dynamics.integrator_stability import longest_step
from hapkit_studio.dynamics.integrators import INTEGRATORS
from hapkit_studio.environments.base import Conditions, Values
from hapkit_studio.formatting import with_unit
from hapkit_studio.parameters import Choice, Parameter

# one label per integrator
LABELS = (
    "Explicit Euler", "Lecture's rule", "Semi-implicit", "Verlet", "RK4", "Implicit Euler",
    "Trapezoid", "Exact",
)  # fmt: skip


def contact(what: str) -> tuple[Parameter, Parameter]:
    """Return the parameters for stiffness and damping between the handle and an object with this name."""
    inside = f"Force for each metre that the handle is inside the {what}"
    closing = f"Force for each m/s of approach speed between the handle and the {what} while they touch"
    symbol = "k<sub>u</sub>"
    return (
        Parameter("contact_stiffness", "Contact stiffness", "N/m", 500.0, 50.0, 5000.0, inside, symbol),
        Parameter("contact_damping", "Contact damping", "N·s/m", 0.0, 0.0, 50.0, closing, "b<sub>u</sub>"),
    )


def integrator(what: str) -> Choice:
    """Return the parameter that selects the integrator of an object's motion."""
    text = (
        f"Method that computes the {what}'s motion step by step. Explicit Euler and Lecture's rule "
        "(averages of old and new values) add energy in each step; Implicit Euler takes energy away."
    )
    return Choice(
        "integrator",
        "Integrator",
        INTEGRATORS,
        "semi_implicit",
        text,
        labels=LABELS,
        method=True,
        exact="exact",
    )


def growth(values: Values, swing: tuple[float, float, float], conditions: Conditions) -> Iterator[str]:
    """Warn if the chosen integrator makes an object of this mass, damping and stiffness gain energy."""
    index = int(values["integrator"])
    longest = longest_step(INTEGRATORS[index], *swing)
    if conditions.period > longest:
        most, step = with_unit(1e3 * longest, "ms"), with_unit(1e3 * conditions.period, "ms")
        too_long = f"when its step is longer than {most}. The step is {step} now"
        yield f"{LABELS[index]} adds energy during contact {too_long if longest else 'in every step'}."

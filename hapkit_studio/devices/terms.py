"""What a simulated scene models, term by term, and what the device is without a term."""

import math
from dataclasses import dataclass

from hapkit_studio.errors import ParameterError

# The hand's mass alone, to twelve digits; the paddle's equations divide by the mass.
NO_MASS = 1e-13


@dataclass(frozen=True)
class Term:
    """One term: its key, a word for people, its field of the device ("": the loop has it), its off-value."""

    key: str
    word: str
    field: str = ""
    off: float = 0.0


TERMS: dict[str, Term] = {
    t.key: t
    for t in (
        Term("mass", "mass", "mass", NO_MASS),
        Term("viscous", "damping", "damping"),
        Term("coulomb", "friction", "coulomb_force"),
        Term("quantization", "sensor steps", "quantum"),
        Term("sampling", "sampling"),
        Term("delay", "delay"),
        Term("saturation", "force limit", "max_force", math.inf),
        Term("filter", "velocity filter"),
    )
}
# What a live loop may leave out: a released handle has no other mass, the force limit is the last line of
# safety, and sampling, delay and filter are the person's own settings.
OPTIONAL = ("viscous", "coulomb", "quantization")
# What a person chooses between: what the scene needs, or all of it.
MODELS = ("scene", "everything")


def term(key: str) -> Term:
    """Return a term by its key; raise ParameterError listing those there are."""
    if key not in TERMS:
        raise ParameterError(f"A modelled term is one of {', '.join(TERMS)}, not {key!r}.")
    return TERMS[key]

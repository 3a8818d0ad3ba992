"""Words of the command line turned into what the studio takes."""

from collections.abc import Sequence

from hapkit_studio import environments
from hapkit_studio.dynamics.estimators import ESTIMATORS, Spec
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.workshop import asking

ESTIMATOR_HELP = f"{', '.join(ESTIMATORS)}; options as iir:cutoff=20"


def environment(wanted: str, trust: bool) -> Environment:
    """Return an environment by its key or its Python file; raise ParameterError."""
    return asking.environment(wanted, trust) if wanted.endswith(".py") else environments.named(wanted)


def key_values(
    pairs: Sequence[str], what: str = "A parameter", like: str = "stiffness=400"
) -> dict[str, object]:
    """Return {key: number or word} of KEY=VALUE pairs; raise ParameterError that names what they are."""
    found: dict[str, object] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key or not value:
            raise ParameterError(f"{what} is given as KEY=VALUE, e.g. {like}, not {pair!r}.")
        try:
            found[key] = float(value)
        except ValueError:
            found[key] = value
    return found


def estimator_spec(text: str) -> Spec:
    """Return an estimator of ``iir`` or ``iir:cutoff=20``; raise ParameterError."""
    name, colon, options = text.partition(":")
    if not colon:
        return name
    numbers = key_values(options.split(","), "An option", "cutoff=20")
    for key, value in numbers.items():
        if not isinstance(value, float):
            raise ParameterError(f"The estimator's {key} takes a number, not {value!r}.")
    return name, numbers  # type: ignore[return-value]

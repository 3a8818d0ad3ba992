"""What an environment is: a force law with its parameters, its words and its picture's name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from hapkit_studio.errors import ParameterError
from hapkit_studio.laws import Law
from hapkit_studio.parameters import AnyParameter, resolve


@dataclass(frozen=True)
class Environment:
    """One virtual environment; its file in this folder is found by the name ``ENVIRONMENT``.

    formula is short HTML; impedance maps named values to the (stiffness N/m, damping N·s/m) that bound
    stability, None where no linear limit applies; shades says whether contact is shaded in the plots.
    """

    key: str
    title: str
    summary: str
    parameters: tuple[AnyParameter, ...]
    force: Law
    shortcut: str = ""
    formula: str = ""
    explanation: str = ""
    scene: str = ""
    impedance: Callable[[Mapping[str, float]], tuple[float, float]] | None = None
    shades: bool = False
    needs: tuple[str, ...] = ()
    order: int = 100
    state_names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "state_names", self.force.state_names)
        object.__setattr__(self, "scene", self.scene or self.key)
        self.force.bind(self.parameters)

    def values(self, given: Mapping[str, object] | None = None) -> dict[str, float]:
        """Return every parameter's number, defaults filled in; raise ParameterError."""
        given = {} if given is None else given
        if not isinstance(given, Mapping):
            raise ParameterError(
                f"{self.title} takes its parameters by name, as {{key: value}}, not {given!r}."
            )
        numbers = resolve(self.parameters, given, self.title)
        return {p.key: n for p, n in zip(self.parameters, numbers, strict=True)}

    def curve(self, values: Mapping[str, float], position: np.ndarray, velocity: float = 0.0) -> np.ndarray:
        """Return the law's static force (n,) in N over position (n,) in m, its state at the start."""
        return np.array([self.force.plain(values, x, velocity) for x in map(float, position)])

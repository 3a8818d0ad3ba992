"""Which of an environment's parameters are the stiffness and the damping that the map shows."""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.gui.widgets.numbers import Quantity
from hapkit_studio.parameters import Parameter

_UNITS = ("N/m", "N·s/m")
# Two shares of a parameter's range: where the impedance is the parameter at both, it is that parameter.
_PROBES = (0.3, 0.6)
_REACH, _POINTS = 0.04, 161
# Where the force rises nearly as steeply as anywhere.
_STEEP = 0.9
# This far in m on both sides of the stiffest place tells a wall; less than this share of force is none.
_NEAR, _SLIGHT = 0.003, 0.1


@dataclass(frozen=True)
class Pair:
    """The parameters that set stiffness and damping; None where the environment has none for it."""

    stiffness: Parameter | None
    damping: Parameter | None

    def values(self, stiffness: float, damping: float) -> dict[str, float]:
        """Return what to set for a point of the map, on whole steps and inside the parameters' limits."""
        found = ((self.stiffness, stiffness), (self.damping, damping))
        return {p.key: _on_a_step(p, value) for p, value in found if p is not None}

    @property
    def words(self) -> str:
        """Say what a click on the map does."""
        if self.stiffness and self.damping:
            return "Click the map: the sliders go there, the scene shows what happens. Ctrl+Z goes back."
        if self.stiffness or self.damping:
            name = (self.stiffness or self.damping).label.lower()  # type: ignore[union-attr]
            return f"Click the map: {name} goes there, the only one of the two that is set here."
        return "No slider here is the stiffness or the damping alone. Choose Spring or Wall to go by clicks."


def pair_of(environment: Environment, values: Values) -> Pair:
    """Return the parameters that are the impedance themselves, with these values of the others."""
    numbers = [p for p in environment.parameters if isinstance(p, Parameter)]
    found = [
        next((p for p in numbers if p.unit == unit and _is_it(environment, values, p, which)), None)
        for which, unit in enumerate(_UNITS)
    ]
    return Pair(*found)


def _is_it(environment: Environment, values: Values, parameter: Parameter, which: int) -> bool:
    if environment.impedance is None:
        return False
    for share in _PROBES:
        value = parameter.low + share * (parameter.high - parameter.low)
        if environment.impedance({**values, parameter.key: value})[which] != value:
            return False
    return True


def _on_a_step(parameter: Parameter, value: float) -> float:
    quantity = Quantity.of(parameter)
    inside = min(max(value * quantity.factor, quantity.low), quantity.high)
    return min(max(quantity.at(quantity.index(inside)) / quantity.factor, parameter.low), parameter.high)


def contact(environment: Environment, values: Values) -> tuple[float, float]:
    """Return (place in m, direction) where the force rises most steeply, with the least force to begin with.

    Going that direction stays in it. The middle, to the right, where no place has any stiffness.
    """
    x = np.linspace(-_REACH, _REACH, _POINTS)
    force = environment.curve(values, x)
    slope = -np.gradient(force, x)
    if not np.isfinite(slope).all() or slope.max() <= 0.0:
        return 0.0, 1.0
    steep = slope >= _STEEP * slope.max()
    places = np.flatnonzero(steep)
    best = int(min(places, key=lambda i: (round(abs(float(force[i])), 6), abs(float(x[i])))))
    onwards = best + 4 < _POINTS and bool(steep[best : best + 4].all())
    return float(x[best]), 1.0 if onwards else -1.0


def one_sided(environment: Environment, values: Values) -> bool:
    """Return whether the scene pushes on one side only of its stiffest place, as a wall does."""
    place, way = contact(environment, values)
    inside, outside = environment.curve(values, np.array([place + way * _NEAR, place - way * _NEAR]))
    return abs(float(outside)) < _SLIGHT * abs(float(inside))

"""How a scene is declared; a file in this folder with such a ``SCENE`` is found by its environment's name."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment
from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.stage import Stage

Values = Mapping[str, float]


def reader(environment: Environment) -> Callable[[Values, str], float]:
    """Return how a drawing reads a parameter: within its limits, its default if no number is given."""
    known = {p.key: p for p in environment.parameters}

    def read(values: Values, key: str) -> float:
        parameter = known[key]
        value = values.get(key, parameter.default)
        return min(max(value, parameter.low), parameter.high) if math.isfinite(value) else parameter.default

    return read


def _nothing(stage: Stage, values: Values) -> None:
    """Draw nothing."""


def _still(stage: Stage, values: Values, motion: Motion) -> None:
    """Draw nothing."""


@dataclass(frozen=True)
class Scene:
    """One environment's drawing.

    fixed is painted once per size, theme and parameters, marks below the rail included; moving is painted
    behind the handle in every frame; words is called last, when the places taken are known.
    per_newton is the arrow's length in px at u = 1; tip gives the stem's end in px for a shown surface;
    height is the card's in px where there is room.
    """

    key: str
    fixed: Callable[[Stage, Values], None] = _nothing
    moving: Callable[[Stage, Values, Motion], None] = _still
    words: Callable[[Stage, Values, Motion], None] = _still
    tip: Callable[[Stage, Values, Motion], float] | None = None
    per_newton: float = 46.0
    height: int = 236


@cache
def discover() -> dict[str, Scene]:
    """Return every scene of this folder by its key."""
    return {scene.key: scene for scene in declared(__package__, "SCENE", Scene)}


def named(key: str) -> Scene:
    """Return a scene; an environment without a drawing of its own gets the bare handle."""
    return discover().get(key) or Scene(key)

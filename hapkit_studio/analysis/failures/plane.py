"""A failure in the plane of two dimensionless numbers: closed-form boundaries and measured points."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

STABLE, BOUNDED, PUSHED, UNSTABLE = "stable", "bounded", "pushed", "unstable"
"""Outcomes of a point: settles; limit cycle; grows after a large push only; grows."""


@dataclass(frozen=True)
class Boundary:
    """A closed-form curve: x (n,), y (n,); ``strong`` marks the curve that applies to this case."""

    label: str
    x: np.ndarray
    y: np.ndarray
    strong: bool = True


@dataclass(frozen=True)
class Points:
    """Measured points of one outcome: x (n,), y (n,)."""

    label: str
    outcome: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Field:
    """A quantity z (m, n) over x (n,) and y (m,). The motion is stable for z < 1 and bounded for z < 2.

    ``levels`` are the contour lines of z below 1.
    """

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    levels: tuple[float, ...] = ()


@dataclass(frozen=True)
class Panel:
    """The axes of one plot in the plane; marks are named points (x, y, words)."""

    field: Field
    title: str = ""
    boundaries: tuple[Boundary, ...] = ()
    points: tuple[Points, ...] = ()
    marks: tuple[tuple[float, float, str], ...] = ()


@dataclass(frozen=True)
class Plane:
    """Panels with equal logarithmic axes; ``place`` returns (x, y) of a knob's value in panel ``own``."""

    sentence: str
    x_label: str
    y_label: str
    panels: tuple[Panel, ...]
    place: Callable[[float], tuple[float, float]]
    own: int = 0

"""How a plot is declared; a file in this folder with such a ``PLOT`` is found and shown."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from hapkit_studio.analysis.theory import Curve
from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment

_BENT = 1e-6  # of the force's span: a bend smaller than this is rounding

Theory = Callable[[Environment, Mapping[str, float], float, float], Curve | None]


@dataclass(frozen=True)
class Trace:
    """One line of a time plot: which channel of the history, in which token's colour.

    dash: on and off, … in pixels, along the line. Without a label it is the environment's object, which names
    it and need not be there.
    """

    channel: str
    label: str
    color: str
    dashed: bool = False
    dash: tuple[float, ...] = ()
    help: str = ""


@dataclass(frozen=True)
class TimePlot:
    """A quantity over time; scale turns SI into the shown unit, reach is the least range shown.

    The last trace lies on top and gives the live value. share is the plot's part of the height in percent.
    beside: it stands among the plots of force, not below the others. folds: where room is short it folds
    away, the lowest first; 0: never.
    """

    key: str
    title: str
    unit: str
    scale: float
    decimals: int
    reach: float
    share: int
    order: int
    traces: tuple[Trace, ...]
    limits: bool = False
    surface: bool = False
    folds: int = 0
    beside: bool = False
    marker: str = "dot"


@dataclass(frozen=True)
class PhasePlot:
    """The applied force over another channel; theory returns the law's force from low to high, SI, or None.

    It opens on ±reach, or on as much more, up to ±most, as the theory needs.
    """

    key: str
    title: str
    label: str
    channel: str
    unit: str
    scale: float
    reach: float
    most: float
    order: int
    theory: Theory

    def theory_of(self, environment: Environment, values: Mapping[str, float]) -> Curve | None:
        """Return the theory up to three times the reach to each side."""
        far = 3.0 * self.reach / self.scale
        return self.theory(environment, values, -far, far)


def landmarks(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the places among x (n,) where a branch of a law's force (m, n) bends or changes its sign.

    A wall's surface, a spring's centre; every place of a curve without a straight part, none of no curve.
    """
    found = np.zeros(x.shape, dtype=bool)
    for row in force:
        slopes = np.diff(row) / np.diff(x)
        found[1:-1] |= np.abs(np.diff(slopes)) > _BENT * np.fmax.reduce(np.abs(slopes), initial=0.0)
        found[1:-1] |= row[:-2] * row[2:] < 0.0
    return x[found]


@cache
def time_plots(beside: bool = False) -> list[TimePlot]:
    """Return the plots over time that stand one below the other, or those among the plots of force."""
    found = declared(__package__, "PLOT", TimePlot)
    return sorted((plot for plot in found if plot.beside == beside), key=lambda plot: plot.order)


@cache
def phase_plots() -> list[PhasePlot]:
    """Return the plots of force over something else."""
    return sorted(declared(__package__, "PLOT", PhasePlot), key=lambda plot: plot.order)

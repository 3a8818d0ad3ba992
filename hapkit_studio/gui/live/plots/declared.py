"""Declarations of plots; a file in this folder that defines ``PLOT`` is discovered and shown."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from hapkit_studio.analysis.theory import Curve
from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics.signals import BY_NAME

OBJECT = "object"
"""The channel of the second body: its position in m, NaN without one."""
_BENT = 1e-6  # of the force's span: a smaller bend is rounding

Theory = Callable[[Environment, Mapping[str, float], float, float], Curve | None]


@dataclass(frozen=True)
class Trace:
    """One line of a time plot: a signal of the row, or OBJECT, in a token's colour.

    dash: lengths on and off in pixels along the line. A trace without a label is the environment's object,
    which supplies the name and may be absent.
    """

    channel: str
    label: str
    color: str
    dashed: bool = False
    dash: tuple[float, ...] = ()
    help: str = ""

    def __post_init__(self) -> None:
        _check_channel(self.channel)


@dataclass(frozen=True)
class TimePlot:
    """Signals over time in the unit of the last trace; ``reach`` is the minimum range shown, in this unit.

    The last trace is drawn on top and gives the live value. share: percentage of the height. beside: shown
    among the force plots, not below the other time plots. folds: order of folding if there is little height,
    lowest first; 0: never.
    """

    key: str
    title: str
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

    @property
    def unit(self) -> str:
        """Return the unit shown."""
        return BY_NAME[self.traces[-1].channel].shown_unit

    @property
    def scale(self) -> float:
        """Return the number of shown units per SI unit."""
        return BY_NAME[self.traces[-1].channel].scale


@dataclass(frozen=True)
class PhasePlot:
    """The applied force over another signal; theory returns the law's force from low to high, SI, or None.

    The initial range is ±reach, extended up to ±most if the theory needs it.
    """

    key: str
    title: str
    channel: str
    reach: float
    most: float
    order: int
    theory: Theory

    def __post_init__(self) -> None:
        _check_channel(self.channel)

    @property
    def unit(self) -> str:
        """Return the unit shown."""
        return BY_NAME[self.channel].shown_unit

    @property
    def scale(self) -> float:
        """Return the number of shown units per SI unit."""
        return BY_NAME[self.channel].scale

    @property
    def label(self) -> str:
        """Return the name and unit of its axis."""
        return f"{self.channel.replace('_', ' ')}, {self.unit}"

    def theory_of(self, environment: Environment, values: Mapping[str, float]) -> Curve | None:
        """Return the theory up to three times the reach on each side."""
        far = 3.0 * self.reach / self.scale
        return self.theory(environment, values, -far, far)


def _check_channel(name: str) -> None:
    if name != OBJECT and name not in BY_NAME:
        raise ValueError(f"There is no signal {name}; the signals are {', '.join(BY_NAME)} and {OBJECT}.")


def landmarks(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the points of x (n,) where a branch of a law's force (m, n) bends or changes sign.

    For example a wall's surface or a spring's centre; every point of a curve without a straight part.
    """
    found = np.zeros(x.shape, dtype=bool)
    for row in force:
        slopes = np.diff(row) / np.diff(x)
        found[1:-1] |= np.abs(np.diff(slopes)) > _BENT * np.fmax.reduce(np.abs(slopes), initial=0.0)
        found[1:-1] |= row[:-2] * row[2:] < 0.0
    return x[found]


@cache
def time_plots(beside: bool = False) -> list[TimePlot]:
    """Return the time plots shown one below the other, or (``beside``) those shown among the force plots."""
    found = declared(__package__, "PLOT", TimePlot)
    return sorted((plot for plot in found if plot.beside == beside), key=lambda plot: plot.order)


@cache
def phase_plots() -> list[PhasePlot]:
    """Return the plots of force over another signal."""
    return sorted(declared(__package__, "PLOT", PhasePlot), key=lambda plot: plot.order)

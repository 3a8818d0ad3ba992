"""Declarations of plots. The window shows the plot of each file in this folder that defines ``PLOT``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from hapkit_studio.analysis.theory import Curve
from hapkit_studio.discovery import declared
from hapkit_studio.environments.base import Environment
from hapkit_studio.haptics.signals import BY_NAME

OBJECT = "object"
"""The channel with the position of the second body in m; NaN if there is no second body."""
_BENT = 1e-6  # a bend is a rounding error if it is smaller than this fraction of the force's span

Theory = Callable[[Environment, Mapping[str, float], float, float], Curve | None]


@dataclass(frozen=True)
class Trace:
    """One line of a time plot: a signal of the telemetry row, or OBJECT, and a colour token.

    ``dash`` lists the lengths of the dashes and gaps in pixels. A trace without a label is the environment's
    object; the object supplies the label and may be absent.
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

    The last trace is drawn on top and supplies the live value. ``share`` is the percentage of the height.
    ``beside``: the plot is shown among the force plots, not below the other time plots. ``folds``: plots are
    folded in this order if there is little height, the lowest first; 0 means that the plot is never folded.
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
        """Return the unit that the axis shows."""
        return BY_NAME[self.traces[-1].channel].shown_unit

    @property
    def scale(self) -> float:
        """Return the number of shown units in one SI unit."""
        return BY_NAME[self.traces[-1].channel].scale


@dataclass(frozen=True)
class PhasePlot:
    """A plot of the applied force over another signal, its x axis.

    ``theory`` returns the law's force over the same signal in SI; None for a law without such a curve.

    The initial range is ±reach; it is extended up to ±most if the curve needs this.
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
        """Return the unit that the axis shows."""
        return BY_NAME[self.channel].shown_unit

    @property
    def scale(self) -> float:
        """Return the number of shown units in one SI unit."""
        return BY_NAME[self.channel].scale

    @property
    def label(self) -> str:
        """Return the name and unit of the x axis."""
        return f"{self.channel.replace('_', ' ')}, {self.unit}"

    def theory_of(self, environment: Environment, values: Mapping[str, float]) -> Curve | None:
        """Return the law's curve up to three times the reach on either side; None if it has no curve."""
        far = 3.0 * self.reach / self.scale
        return self.theory(environment, values, -far, far)


def _check_channel(name: str) -> None:
    if name != OBJECT and name not in BY_NAME:
        raise ValueError(f"There is no signal {name}; the signals are {', '.join(BY_NAME)} and {OBJECT}.")


def landmarks(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the points of x (n,) at which a branch of a law's force (m, n) bends or changes sign.

    Examples are a wall's surface and a spring's centre. On a curve without a straight part, every inner
    point is returned.
    """
    found = np.zeros(x.shape, dtype=bool)
    for row in force:
        slopes = np.diff(row) / np.diff(x)
        found[1:-1] |= np.abs(np.diff(slopes)) > _BENT * np.fmax.reduce(np.abs(slopes), initial=0.0)
        found[1:-1] |= row[:-2] * row[2:] < 0.0
    return x[found]


@cache
def time_plots(beside: bool = False) -> list[TimePlot]:
    """Return the time plots that are shown below each other, or (``beside``) among the force plots."""
    found = declared(__package__, "PLOT", TimePlot)
    return sorted((plot for plot in found if plot.beside == beside), key=lambda plot: plot.order)


@cache
def phase_plots() -> list[PhasePlot]:
    """Return the plots of force over another signal."""
    return sorted(declared(__package__, "PLOT", PhasePlot), key=lambda plot: plot.order)

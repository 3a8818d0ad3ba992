"""The plane of virtual damping and stiffness: every limit of a loop, and where the impedance in use lies."""

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis import scales
from hapkit_studio.analysis.checks import DAMPING, STIFFNESS, row, whole
from hapkit_studio.analysis.exact import Loop, checked_loop, stiffness_limits
from hapkit_studio.analysis.margin import Margin
from hapkit_studio.analysis.passivity import passive_damping, passive_stiffness
from hapkit_studio.analysis.regions import coulomb_line, simple_rule
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import GRIPS

__all__ = ["Cells", "Plane", "Points", "coulomb_line", "exact_boundary", "hands", "limit", "measure_cells"]
__all__ += ["measure_points", "passive_edge", "passivity_line", "plane", "simple_rule"]

Progress = Callable[[int, int], None]
RENDERED_STIFFNESS = replace(STIFFNESS, label="The rendered stiffness")
RENDERED_DAMPING = replace(DAMPING, label="The rendered damping")
WIDTH = replace(DAMPING, label="The largest damping shown")
TOP = replace(STIFFNESS, label="The largest stiffness shown")
COLUMNS = 121
EDGE_POINTS = 41


@dataclass(frozen=True)
class Points:
    """A measured boundary: stiffness (n,) N/m at damping (n,) N·s/m; real: with friction and sensor steps."""

    damping: np.ndarray
    stiffness: np.ndarray
    real: bool
    controller: bool = False


@dataclass(frozen=True)
class Cells:
    """A measured map: classes (m, n) of ``measured`` at stiffness (m,) N/m and damping (n,) N·s/m."""

    damping: np.ndarray
    stiffness: np.ndarray
    classes: np.ndarray
    real: bool
    controller: bool = False


@dataclass(frozen=True)
class Plane:
    """Everything that a chart of the plane shows; SI units.

    exact and simple are (n,) over damping (n,); edge_damping and edge (k,) are the passivity line up to the
    largest passive damping; coulomb is inf without sensor steps, hands the limits at the margin's damping.
    Without a linear estimator exact is all nan, the edge empty, the hands' and the margin's limits nan.
    """

    setting: Setting
    margin: Margin
    top: float
    damping: np.ndarray
    exact: np.ndarray
    simple: np.ndarray
    edge_damping: np.ndarray
    edge: np.ndarray
    coulomb: float
    hands: dict[str, float]
    points: Points | None = None
    cells: Cells | None = None

    @property
    def width(self) -> float:
        """Return the largest damping shown, in N·s/m."""
        return float(self.damping[-1])


def _loop(setting: Setting) -> Loop:
    return checked_loop(
        setting.mass,
        setting.viscous,
        0.0,
        setting.rate,
        setting.delay,
        setting.estimator,
        setting.hand,
        setting.quantum,
    )


def exact_boundary(setting: Setting, damping: np.ndarray) -> np.ndarray:
    """Return the largest stable stiffness (n,) in N/m; 0 where damping (n,) alone is unstable.

    Raise ParameterError for an estimator that is not linear.
    """
    return stiffness_limits(_loop(setting), row(damping, DAMPING))


def passivity_line(setting: Setting, damping: np.ndarray) -> np.ndarray:
    """Return the largest stiffness (n,) in N/m that is passive, safe in any hand; 0 where none is.

    Raise ParameterError for an estimator that is not linear.
    """
    columns = row(damping, DAMPING)
    return passive_stiffness(setting.viscous, columns, *_sampling(setting))


def _sampling(setting: Setting) -> tuple[float, float, Spec, float]:
    return setting.rate, setting.delay, setting.estimator, setting.quantum


def passive_edge(setting: Setting, points: int = EDGE_POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Return the passivity line as (damping, stiffness), each (points,), as far as anything is passive."""
    most = passive_damping(setting.viscous, *_sampling(setting))
    damping = np.linspace(0.0, most, points)
    return damping, passivity_line(setting, damping)


def limit(setting: Setting, damping: float) -> float:
    """Return the largest stable stiffness in N/m at one damping; nan where the estimator is not linear."""
    across = np.array([DAMPING.check(damping)])
    return float(exact_boundary(setting, across)[0]) if setting.linear else math.nan


def hands(setting: Setting, damping: float) -> dict[str, float]:
    """Return the limit in N/m at one damping under every grip, the released hand first."""
    return {name: limit(replace(setting, hand=name), damping) for name in GRIPS}


def _axes(setting: Setting, stiffness: float, damping: float, bound: float) -> tuple[float, float]:
    """Return round axes by the exact boundary, or by the simple rule where there is none."""
    if setting.linear:
        return scales.axes(lambda across: exact_boundary(setting, across), stiffness, damping, bound)
    rule = float(simple_rule(setting, np.array([damping]))[0])
    return scales.axes(lambda across: simple_rule(setting, across), stiffness, damping, rule)


def plane(
    setting: Setting,
    stiffness: float,
    damping: float,
    *,
    width: float | None = None,
    top: float | None = None,
    columns: int = COLUMNS,
) -> Plane:
    """Return the lines of a setting around a rendered impedance; axes as given, or round ones that fit.

    Raise ParameterError.
    """
    stiffness, damping = RENDERED_STIFFNESS.check(stiffness), RENDERED_DAMPING.check(damping)
    width, top = WIDTH.check(width or 0.0), TOP.check(top or 0.0)
    columns = whole(columns, "The number of columns", 2)
    around = hands(setting, damping)
    bound = around[setting.hand]
    wide, high = (width, top) if width and top else _axes(setting, stiffness, damping, bound)
    across = np.linspace(0.0, width or wide, columns)
    exact = exact_boundary(setting, across) if setting.linear else np.full(columns, math.nan)
    edge = passive_edge(setting) if setting.linear else (np.empty(0), np.empty(0))
    return Plane(
        setting,
        Margin(stiffness, damping, bound, setting.hand),
        top or high,
        across,
        exact,
        simple_rule(setting, across),
        edge[0],
        edge[1],
        coulomb_line(setting),
        around,
    )


def measure_points(
    setting: Setting,
    damping: np.ndarray,
    *,
    real: bool = False,
    executor: Executor | None = None,
    progress: Progress = lambda done, of: None,
) -> Points:
    """Return the boundary as rendering finds it, by bisection in each column."""
    from hapkit_studio.analysis import measured

    found = measured.boundary(setting, damping, real=real, executor=executor, progress=progress)
    return Points(np.asarray(damping), found, real, setting.controller)


def measure_cells(
    setting: Setting,
    damping: np.ndarray,
    stiffness: np.ndarray,
    *,
    real: bool = False,
    executor: Executor | None = None,
    progress: Progress = lambda done, of: None,
) -> Cells:
    """Return what rendering does in every cell of the plane."""
    from hapkit_studio.analysis import measured

    found = measured.classes(setting, damping, stiffness, real=real, executor=executor, progress=progress)
    return Cells(np.asarray(damping), np.asarray(stiffness), found, real, setting.controller)

"""Stable and unstable springs by rendering them: a class for every cell of the K-B plane, and the boundary.

The rule is that of ``settling``; real=True renders the device's Coulomb friction and sensor steps too.
"""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial

import numpy as np

from hapkit_studio.analysis import settling
from hapkit_studio.analysis.checks import DAMPING, STIFFNESS, row
from hapkit_studio.analysis.setting import Setting
from hapkit_studio.analysis.settling import BUZZES, DECAYS, GROWS, Rendered
from hapkit_studio.analysis.sweeps import Progress, quiet, sweep
from hapkit_studio.dynamics.filter_design import USUAL_QUANTUM

__all__ = ["BUZZES", "DECAYS", "GROWS", "boundary", "classes", "largest_stable", "maps", "rendered"]

_STIFFEST = 1e9
_PRECISION = 1e-4


def rendered(setting: Setting, real: bool = False) -> Rendered:
    """Return what renders a setting's spring; real: with friction and sensor steps.

    The velocity estimator is that of the device either way, designed for its sensor's quantum.
    """
    quantum = setting.quantum or USUAL_QUANTUM
    return Rendered(setting.device(real), setting.loop, setting.grip, setting.controller, quantum)


def classes(
    setting: Setting,
    damping: np.ndarray,
    stiffness: np.ndarray,
    *,
    real: bool = False,
    executor: Executor | None = None,
    progress: Progress = quiet,
) -> np.ndarray:
    """Return DECAYS, BUZZES or GROWS (m, n) int8 for every stiffness (m,) N/m and damping (n,) N·s/m.

    Raise ParameterError, and what progress raises.
    """
    columns, lines = row(damping, DAMPING), row(stiffness, STIFFNESS)
    cells = [(k, b) for k in lines.tolist() for b in columns.tolist()]
    task = partial(_classes, rendered(setting, real))
    found = sweep(task, cells, executor=executor, progress=progress)
    return np.array(found, dtype=np.int8).reshape(lines.size, columns.size)


def maps(
    settings: Sequence[Setting],
    damping: np.ndarray,
    stiffness: np.ndarray,
    *,
    real: bool = False,
    executor: Executor | None = None,
    progress: Progress = quiet,
) -> np.ndarray:
    """Return the ``classes`` (s, m, n) int8 of many settings: one sweep, whose cell is a line of a map.

    Raise ParameterError, and what progress raises.
    """
    columns, lines = row(damping, DAMPING), row(stiffness, STIFFNESS)
    cells = [(rendered(setting, real), k) for setting in settings for k in lines.tolist()]
    found = sweep(partial(_lines, columns), cells, executor=executor, progress=progress)
    return np.array(found, dtype=np.int8).reshape(len(settings), lines.size, columns.size)


def boundary(
    setting: Setting,
    damping: np.ndarray,
    *,
    real: bool = False,
    executor: Executor | None = None,
    progress: Progress = quiet,
) -> np.ndarray:
    """Return the largest stiffness (n,) N/m that does not grow, to 1e-4, for every damping (n,) N·s/m.

    Found by bisection; 0 where no spring of ``settling.softest`` is stable, inf beyond 1 GN/m. Raise
    ParameterError, and what progress raises.
    """
    columns = row(damping, DAMPING).tolist()
    task = partial(_limits, rendered(setting, real))
    return np.array(sweep(task, columns, executor=executor, progress=progress), dtype=float)


def _classes(what: Rendered, cells: list[tuple[float, float]]) -> list[int]:
    stiffness, damping = np.array(cells).T
    return settling.judge(what, stiffness, damping).tolist()


def _lines(damping: np.ndarray, cells: list[tuple[Rendered, float]]) -> list[np.ndarray]:
    return [settling.judge(what, np.full(damping.size, k), damping) for what, k in cells]


def _limits(what: Rendered, columns: list[float]) -> list[float]:
    return [stiffest(what, damping) for damping in columns]


def stiffest(what: Rendered, damping: float) -> float:
    """Return the largest stiffness in N/m that does not grow at a virtual damping in N·s/m."""

    def stable(stiffness: float) -> bool:
        verdict = settling.judge(what, np.array([stiffness]), np.array([damping]))
        return bool(verdict[0] != GROWS)

    return largest_stable(stable, settling.softest(what))


def largest_stable(stable: Callable[[float], bool], softest: float = settling.SOFTEST) -> float:
    """Return the stiffness in N/m, to 1e-4, up to which ``stable`` holds; 0 if nowhere, inf if everywhere.

    Nothing softer than the softest is tried.
    """
    low, high = 1.0, math.inf
    while not stable(low):
        if low <= softest:
            return 0.0
        low, high = max(low / 4.0, softest), low
    while high == math.inf:
        if 4.0 * low > _STIFFEST:
            return math.inf
        low, high = (4.0 * low, high) if stable(4.0 * low) else (low, 4.0 * low)
    while high > low * (1.0 + _PRECISION):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.sqrt(low * high)

"""Figure of a run: position, velocity and force over time, and force over position or velocity."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from hapkit_studio.analysis import theory
from hapkit_studio.charts.caption import Known, caption, environment_of
from hapkit_studio.charts.style import DOT, TICK, Colors, legend, save, style_axes
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import number

_SIZE = (792, 450)
_LETTER = 0.016  # width of a character in the label of a mark, as a fraction of the time axis
_ROOM = 0.25  # free space for marks above the lines, as a fraction of the range

_UNITS = {"position": "mm", "velocity": "mm/s"}
_CURVES = {"position": theory.over_position, "velocity": theory.over_velocity}
_CURVE_RANGE = 0.06  # m or m/s: largest value at which a law's curve is evaluated
_LEAST_HALF = 2.5  # mm or mm/s: smallest half range of the law's curve
_MORE_SIGHT = 0.1
_OVER_LIMIT = 1.35  # largest force drawn, as a multiple of the force limit
# free space beyond the forces, as a fraction of their range; smallest range of the axis in N
_BESIDE, _LEAST_FORCE = 0.08, 0.5

Mark = tuple[float, str]
"""Time in s of a settings change, and its label."""


@dataclass(frozen=True)
class KeptCurve:
    """A kept curve for comparison: arrays (n,) in SI units, colour token, dash pattern in line widths."""

    label: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    token: str
    dash: Sequence[float]


def run_figure(
    run: Any,
    path: str | Path,
    marks: Sequence[Mark] = (),
    kept_curves: Sequence[KeptCurve] = (),
    known: Known = MappingProxyType({}),
    over: str = "",
) -> None:
    """Write a run's position, velocity and force over time, and force over position or velocity.

    ``known`` are environments in addition to those of the library. ``over`` is "position" or "velocity"; if
    it is empty, the quantity over which the law has a curve is used. The caption contains the settings at the
    start and each change with its time.
    """
    text = caption(run.log, known, run.date)
    save(lambda figure, c: draw(figure, c, run, marks, kept_curves, known, over), path, _SIZE, caption=text)


def draw(
    figure: Any,
    c: Colors,
    run: Any,
    marks: Sequence[Mark] = (),
    kept_curves: Sequence[KeptCurve] = (),
    known: Known = MappingProxyType({}),
    over: str = "",
) -> None:
    """Draw three quantities over time and force over ``over``, like ``run_figure``.

    The kept curves are drawn behind the run. The law's curve and the force limit are those at the end of the
    run.
    """
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2))
    upper, middle, lower = (figure.add_subplot(grid[i, 0]) for i in range(3))
    loop = figure.add_subplot(grid[:, 1])
    found = environment_of(run.log[-1][1], known)
    over = over or _curve_quantity(found)
    for curve in kept_curves:
        line_style = {"color": getattr(c, curve.token), "dashes": curve.dash}
        upper.plot(curve.time, 1e3 * curve.position, label=curve.label, **line_style)
        middle.plot(curve.time, 1e3 * curve.velocity, **line_style)
        lower.plot(curve.time, curve.force, **line_style)
        loop.plot(1e3 * getattr(curve, over), curve.force, **line_style)
    for name, place in run.moves.items():
        upper.plot(run.time, 1e3 * place, color=c.objline, dashes=(4, 2.5), label=name)
    upper.plot(run.time, 1e3 * run.position, color=c.position, label="handle")
    middle.plot(run.time, 1e3 * run.velocity, color=c.velocity)
    lower.plot(run.time, run.force, color=c.asked, dashes=(5, 3.5), label="asked", zorder=3)
    lower.plot(run.time, run.applied_force, color=c.applied, label="applied")
    loop.plot(1e3 * getattr(run, over), run.applied_force, color=c.applied, label="applied")
    style_axes(upper, c, "", "position, mm")
    style_axes(middle, c, "", "velocity, mm/s")
    style_axes(lower, c, "time, s", "force, N")
    style_axes(loop, c, f"{over}, {_UNITS[over]}", "force applied, N")
    begin, end = np.nanmin(run.time), np.nanmax(run.time)
    for axes in (upper, middle, lower):
        axes.set_xlim(begin, end if end > begin else None)
        for when, _ in marks:
            axes.axvline(when, color=c.ink3, linewidth=1, dashes=(3, 3), zorder=1)
    limit = _limit(run.log[-1][1])
    if found is not None and _draw_theory(loop, c, found, over, limit):
        legend(loop, c)
    for axes in (lower, loop):
        _draw_limit(axes, c, limit)
    _write_marks(upper, c, marks, begin, end)
    legend(lower, c)
    if kept_curves or run.moves:
        legend(upper, c)


def _curve_quantity(found: tuple[Environment, dict[str, float]] | None) -> str:
    """Return the quantity of the law's curve: "velocity" if the law declares it, else "position"."""
    if found is None:
        return "position"
    environment, values = found
    order = ["position", "velocity"] if environment.over_velocity is None else ["velocity", "position"]
    return next(
        (over for over in order if _CURVES[over](environment, values, -_CURVE_RANGE, _CURVE_RANGE)),
        "position",
    )


def _draw_theory(
    axes: Any, c: Colors, found: tuple[Environment, dict[str, float]], over: str, limit: float
) -> bool:
    """Draw the law's curve behind the data, over the range of the data and up to the force limit.

    Return True if the law has a curve.
    """
    low, high = axes.get_xlim()
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), _LEAST_HALF)
    low, high = middle - half, middle + half
    beyond = _MORE_SIGHT * half  # extend the curve beyond the visible range, so that its ends are hidden
    curve = _CURVES[over](*found, 1e-3 * (low - beyond), 1e-3 * (high + beyond))
    if curve is None:
        return False
    bottom, top = axes.get_ylim()
    most = _OVER_LIMIT * limit
    seen = np.clip(curve.force[np.isfinite(curve.force)], -most, most)
    margin = _BESIDE * max(np.ptp(np.append(seen, (bottom, top))), _LEAST_FORCE)
    axes.set_xlim(low, high)
    axes.set_ylim(min(bottom, seen.min() - margin), max(top, seen.max() + margin))
    for token, width in (("edge", 8.8), ("theory", 6.4)):
        # reversed, because matplotlib omits the samples of an ascending line that are beyond the axes
        for force in curve.force:
            axes.plot(1e3 * curve.x[::-1], force[::-1], color=getattr(c, token), linewidth=width, zorder=0.7)
    axes.lines[-1].set_label("theory")
    return True


def _limit(settings: Mapping) -> float:
    """Return the force limit in N; inf for a recording without a force limit."""
    device = settings.get("device")
    found = settings.get("max_force_N", device.get("max_force") if isinstance(device, Mapping) else None)
    try:
        return float(found) if found is not None else math.inf
    except (TypeError, ValueError):
        return math.inf


def _draw_limit(axes: Any, c: Colors, limit: float) -> None:
    """Draw the positive and the negative force limit, each with its label, if they lie within the axes."""
    bottom, top = axes.get_ylim()
    for level in (limit, -limit):
        if bottom < level < top:
            axes.axhline(level, color=c.danger, linestyle=DOT, linewidth=1.6, zorder=1)
            text = f"limit {number(level, 1)} N"
            axes.annotate(
                text, (0.0, level), (5, 3), ("axes fraction", "data"), textcoords="offset points",
                size=TICK - 1, color=c.danger,
            ).set_in_layout(False)  # fmt: skip


def _write_marks(axes: Any, c: Colors, marks: Sequence[Mark], begin: float, end: float) -> None:
    """Label the marks along the top; a newer label hides older labels that it overlaps."""
    right, (low, high) = end, axes.get_ylim()
    axes.set_ylim(low, high + _ROOM * (high - low) * bool(marks))
    for when, text in reversed(marks):
        wide = _LETTER * len(text) * (end - begin)
        if when + wide <= right or right == end:
            axes.annotate(
                text, (max(min(when, end - wide), begin), 0.97), (4, 0), ("data", "axes fraction"),
                textcoords="offset points", va="top", size=TICK - 1, color=c.ink2, zorder=5,
                bbox={"facecolor": c.plot, "alpha": 0.85, "edgecolor": "none", "pad": 1.0},
            ).set_in_layout(False)  # fmt: skip
        right = min(right, when)

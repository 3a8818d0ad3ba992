"""A failure: what moves just inside its limit and just outside, and the measured curve beside the formula."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.analysis.failures.numbers import readable
from hapkit_studio.charts.style import (
    ACCENT,
    ASKED,
    DANGER,
    EDGE,
    ENERGY,
    GRID,
    HELD,
    INK,
    INK2,
    LINE,
    OK,
    SURFACE,
    THEORY,
)
from hapkit_studio.figures import new_figure

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures.base import Chart, Line
    from hapkit_studio.analysis.failures.shown import Shown, Try

_SIZE = (15, 7.6)
_TEXT, _HEAD = 12, 16
_DOTS, _DASHES = (0, (1, 1.6)), (0, (5, 3.5))
_OTHERS = ((ASKED, _DASHES), (ENERGY, (0, (9, 4, 2, 4))), (HELD, (0, (2, 3))))
_ROOM = 0.08
# A mark beyond this share of the axis has its words at its left.
_RIGHT = 0.7


def failure_figure(shown: "Shown", path: str | Path) -> None:
    """Draw a failure that was charted: two traces at the left, the curve at the right.

    The path's ending picks the format. Raise ParameterError for an ending that is no format of pictures.
    """
    figure = new_figure(path, _SIZE)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
    for row, (one, word) in enumerate(((shown.inside, "inside"), (shown.outside, "outside"))):
        _trace(figure.add_subplot(grid[row, 0]), shown, one, word)
    if shown.chart is not None:
        _curve(figure.add_subplot(grid[:, 1]), shown.chart)
    figure.suptitle(f"{shown.failure.title}\n", size=_HEAD + 2, color=INK, weight="bold")
    figure.text(0.5, 0.945, shown.failure.formula, size=_HEAD - 2, color=INK2, ha="center", va="center")
    figure.savefig(path, dpi=110, facecolor=SURFACE)


def value_text(shown: "Shown", value: float) -> str:
    """Write a value of the knob and how far it lies from the limit."""
    knob = shown.failure.knob
    share = f"{value / shown.limit:.3g} × the limit" if shown.limit > 0.0 else "no limit"
    return f"{knob.symbol or knob.label} = {readable(value, knob.unit, 5)}, {share}"


def _trace(axes: Any, shown: "Shown", one: "Try", word: str) -> None:
    found = one.evidence
    color, sign = (OK, "✓") if found.holds else (DANGER, "✕")
    style = "steps-post" if found.held else "default"
    axes.plot(found.time, found.trace, color=color, linewidth=1.6, drawstyle=style)
    axes.set_title(
        f"{sign} {word}: {value_text(shown, one.value)}\n{found.words}",
        size=_TEXT + 1, color=color, loc="left",
    )  # fmt: skip
    axes.set_ylabel(f"{found.label}, {found.unit}", size=_TEXT + 1, color=INK)
    axes.set_xlabel("time, s", size=_TEXT + 1, color=INK)
    _plain(axes)


def _curve(axes: Any, chart: "Chart") -> None:
    if chart.log_x:
        axes.set_xscale("log")
        _plain_numbers(axes.xaxis)
    if chart.log_y:
        axes.set_yscale("log")
        _plain_numbers(axes.yaxis)
    others = iter(_OTHERS)
    for line in chart.lines:
        _line(axes, line, others)
    _plain(axes)
    _limits(axes, chart)
    axes.set_xlabel(chart.x_label, size=_HEAD - 2, color=INK)
    axes.set_ylabel(chart.y_label, size=_HEAD - 2, color=INK)
    axes.legend(
        frameon=False, fontsize=_TEXT + 1, labelcolor=INK, ncols=2, loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
    )  # fmt: skip


def _plain_numbers(axis: Any) -> None:
    """Give a logarithmic axis plain numbers at 1, 2 and 5 of each decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _line(axes: Any, line: "Line", others: Any) -> None:
    from matplotlib import patheffects

    seen = np.isfinite(line.y)
    x, y = line.x[seen], line.y[seen]
    if line.role == "theory":
        kerbs = [patheffects.Stroke(linewidth=8.8, foreground=EDGE), patheffects.Normal()]
        axes.plot(x, y, color=THEORY, linewidth=6.4, path_effects=kerbs, label=line.label, zorder=1)
    elif line.role == "measured":
        axes.plot(
            x, y, "o", color=ACCENT, markersize=8, markerfacecolor=SURFACE, markeredgewidth=2,
            label=line.label, zorder=4,
        )  # fmt: skip
    else:
        color, dashes = next(others)
        axes.plot(x, y, color=color, linewidth=2.2, linestyle=dashes, label=line.label, zorder=3)


def _limits(axes: Any, chart: "Chart") -> None:
    """Draw the boundary, the other limits and the level at which it begins to fail, each with its words."""
    _widen(axes, chart)
    for index, mark in enumerate(chart.marks):
        color = DANGER if index == 0 else INK2
        axes.axvline(mark.x, color=color, linewidth=2, linestyle=_DOTS, zorder=2)
        right = _share(axes, mark.x) > _RIGHT
        axes.annotate(
            mark.label, (mark.x, 0.985 - 0.055 * index), xycoords=("data", "axes fraction"),
            xytext=(-5 if right else 5, 0), textcoords="offset points", ha="right" if right else "left",
            va="top", size=_TEXT, color=color, zorder=5,
            bbox={"facecolor": SURFACE, "edgecolor": "none", "pad": 1.0, "alpha": 0.8},
        )  # fmt: skip
    if chart.level is not None:
        axes.axhline(chart.level, color=INK2, linewidth=1.2, zorder=2)
        axes.annotate(
            chart.level_label, (0.99, chart.level), xycoords=("axes fraction", "data"),
            xytext=(0, 4), textcoords="offset points", size=_TEXT, color=INK2, ha="right", zorder=5,
            bbox={"facecolor": SURFACE, "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
        )  # fmt: skip


def _share(axes: Any, x: float) -> float:
    """Return where x lies along the axis, 0 at its left end and 1 at its right."""
    return float(axes.transAxes.inverted().transform(axes.transData.transform((x, axes.get_ylim()[0])))[0])


def _widen(axes: Any, chart: "Chart") -> None:
    """Leave room at the top for the marks' words."""
    low, high = axes.get_ylim()
    share = _ROOM * len(chart.marks)
    if chart.log_y:
        axes.set_ylim(low, high * (high / low) ** share)
    else:
        axes.set_ylim(low, high + share * (high - low))


def _plain(axes: Any) -> None:
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=_TEXT, color=LINE, labelcolor=INK)
    for side, spine in axes.spines.items():
        spine.set_color(LINE)
        spine.set_visible(side not in ("top", "right"))

"""The map of damping and stiffness: boundaries, regions, and where the rendered impedance lies."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from hapkit_studio.analysis.margin import factor, hand_words
from hapkit_studio.analysis.plane import Plane
from hapkit_studio.charts import stability_side
from hapkit_studio.charts.placing import Box, crosses, room
from hapkit_studio.charts.style import (
    ACCENT,
    APPLIED,
    ASKED,
    DANGER,
    GRID,
    INK,
    LINE,
    OK,
    PASSIVE,
    STABLE,
    SURFACE,
    UNSTABLE,
    VELOCITY,
    WARN,
    WARN_SOFT,
)
from hapkit_studio.figures import new_figure

_WIDTH = 13.5
_DOTS = (1, 1.6)
_NAME = 13
_PASSIVE_NAME, _PASSIVE_SIZE = "passive: stable in any hand", (0.42, 0.06)
# A quarter, as the last two digits of a colour.
_FAINT = "40"


def stability_figure(plane: Plane, path: str | Path, device: str = "") -> None:
    """Draw the plane with its verdict, legend and conditions; the path's ending picks the format.

    device: the name of the device it holds for.

    Raise ParameterError for an ending that is no format of pictures.
    """
    figure = new_figure(path, (_WIDTH, stability_side.height(plane)))
    left, right = figure.subplots(1, 2, width_ratios=(2.3, 1.0))
    _regions(left, plane)
    _lines(left, plane)
    _names(left, plane)
    _dot(left, plane)
    _frame(left, plane)
    stability_side.draw(right, plane, device)
    figure.savefig(path, dpi=110, facecolor=SURFACE)


def _frame(axes: Any, plane: Plane) -> None:
    axes.set_xlim(0.0, plane.width)
    axes.set_ylim(0.0, plane.top)
    axes.set_xlabel("damping B, N·s/m", size=14, color=INK)
    axes.set_ylabel("stiffness K, N/m", size=14, color=INK)
    axes.tick_params(labelsize=12, color=LINE, labelcolor=INK)
    axes.locator_params(nbins=6)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.grid(color=GRID, linewidth=0.8)
    axes.set_axisbelow(False)
    for spine in axes.spines.values():
        spine.set_color(LINE)


def _regions(axes: Any, plane: Plane) -> None:
    if plane.cells is not None:
        _cells(axes, plane)
    elif plane.setting.linear:
        axes.set_facecolor(UNSTABLE)
        axes.fill_between(
            plane.damping, plane.exact, 10.0 * plane.top, facecolor="none", edgecolor=DANGER, hatch="//",
            linewidth=0.0, alpha=0.25,
        )  # fmt: skip
        axes.fill_between(plane.damping, 0.0, plane.exact, color=STABLE, linewidth=0.0)
    if plane.edge.size:
        axes.fill_between(plane.edge_damping, 0.0, plane.edge, color=PASSIVE, linewidth=0.0, alpha=0.8)


def _cells(axes: Any, plane: Plane) -> None:
    from matplotlib.colors import ListedColormap

    cells = plane.cells
    assert cells is not None
    axes.pcolormesh(
        cells.damping, cells.stiffness, cells.classes, shading="nearest", vmin=-0.5, vmax=2.5,
        cmap=ListedColormap([STABLE, WARN_SOFT, UNSTABLE]), rasterized=True,
    )  # fmt: skip
    if (cells.classes > 1).any():
        hatched = axes.contourf(
            cells.damping, cells.stiffness, cells.classes, levels=[1.5, 2.5], colors="none", hatches=["//"]
        )
        hatched.set(edgecolor=DANGER + _FAINT, linewidth=0.0)


def _lines(axes: Any, plane: Plane) -> None:
    axes.plot(plane.damping, plane.simple, color=ASKED, linewidth=2, linestyle=(0, _DOTS))
    if plane.setting.linear:
        axes.plot(plane.damping, plane.exact, color=INK, linewidth=3)
    if plane.edge.size:
        axes.plot(plane.edge_damping, plane.edge, color=VELOCITY, linewidth=2, linestyle="dashdot")
    if plane.coulomb < plane.top:
        axes.axhline(plane.coulomb, color=WARN, linewidth=2, linestyle=(0, (6, 3)))
    if plane.points is not None:
        color = APPLIED if plane.points.controller else ACCENT
        seen = (plane.points.stiffness <= plane.top) & (plane.points.damping <= plane.width)
        axes.plot(
            plane.points.damping[seen], plane.points.stiffness[seen], "o", markersize=8, color=color,
            markerfacecolor=SURFACE, markeredgewidth=2, zorder=5, clip_on=False,
        )  # fmt: skip


def _names(axes: Any, plane: Plane) -> None:
    """Write the regions' names inside them, clear of the dot, its words and the simple rule."""
    if not plane.setting.linear or (plane.cells is not None and plane.cells.real):
        return
    hand = hand_words(plane.setting.hand).replace(" hand", "")
    taken = [_around_dot(plane), *_along(plane.damping / plane.width, plane.simple / plane.top)]
    exact = np.clip(plane.exact / plane.top, 0.0, 1.0)
    _passive_name(axes, plane, taken)
    passive = np.minimum(_passive(plane), exact)
    for words, color, low, high in (
        (f"grows, {hand}", DANGER, exact, np.ones_like(exact)),
        (f"stable, {hand}", OK, passive, exact),
    ):
        box = room(low, high, (0.016 * len(words), 0.07), taken)
        if box is not None:
            _write(axes, plane, box, words, color)
            taken.append(box)


def _passive(plane: Plane) -> np.ndarray:
    """Return the passivity line as a share of the height in each column (n,)."""
    if not plane.edge.size:
        return np.zeros_like(plane.damping)
    return np.interp(plane.damping, plane.edge_damping, plane.edge / plane.top, right=0.0)


def _along(x: np.ndarray, y: np.ndarray) -> list[Box]:
    """Return small boxes along a line, in shares of the frame."""
    inside = np.interp(np.linspace(0.0, 1.0, 4 * len(x)), x, y)
    places = np.linspace(0.0, 1.0, 4 * len(x))
    return [(a - 0.01, b - 0.02, a + 0.01, b + 0.02) for a, b in zip(places, inside, strict=True) if b < 1.0]


def _write(axes: Any, plane: Plane, box: Box, words: str, color: str) -> None:
    x, y = 0.5 * (box[0] + box[2]) * plane.width, 0.5 * (box[1] + box[3]) * plane.top
    axes.text(
        x,
        y,
        words,
        ha="center",
        va="center",
        size=_NAME,
        weight="bold",
        color=color,
        zorder=6,
        path_effects=_rim(),
    )


def _passive_name(axes: Any, plane: Plane, taken: list[Box]) -> None:
    """Name the passive region from beside it, with a line that leads into it."""
    if not plane.edge.size or not plane.edge.any():
        return
    exact = np.clip(plane.exact / plane.top, 0.0, 1.0)
    floor = np.interp(plane.damping, plane.edge_damping, np.clip(plane.edge / plane.top, 0.0, 1.0), right=0.0)
    box = room(floor, np.minimum(exact, floor + 0.25), _PASSIVE_SIZE, taken)
    reach = float(plane.edge_damping[-1]) / plane.width
    into = 0.35 * min(reach, 1.0), 0.35 * min(plane.edge[0] / plane.top, 1.0)
    if box is None or crosses((box[0], 0.5 * (box[1] + box[3])), into, _around_dot(plane)):
        return
    taken.append(box)
    end = (into[0] * plane.width, into[1] * plane.top)
    start = (box[0] * plane.width, 0.5 * (box[1] + box[3]) * plane.top)
    axes.plot([start[0], end[0]], [start[1], end[1]], color=VELOCITY, linewidth=1.2)
    axes.text(
        *start, f" {_PASSIVE_NAME}", va="center", size=_NAME, weight="bold", color=VELOCITY,
        zorder=6, path_effects=_rim(),
    )  # fmt: skip


def _around_dot(plane: Plane) -> Box:
    """Return the share of the frame that dot, arrow and their words take."""
    x, y = plane.margin.damping / plane.width, plane.margin.stiffness / plane.top
    limit = plane.margin.limit if math.isfinite(plane.margin.limit) else plane.margin.stiffness
    tip = min(limit / plane.top, 1.0)
    return x - 0.03, min(y, tip) - 0.05, x + 0.45, max(y, tip) + 0.05


def _dot(axes: Any, plane: Plane) -> None:
    margin = plane.margin
    color = ACCENT if margin.stable or not plane.setting.linear else DANGER
    axes.plot([0.0, margin.damping], [margin.stiffness] * 2, color=color, linewidth=1.2, linestyle=":")
    axes.plot([margin.damping] * 2, [0.0, margin.stiffness], color=color, linewidth=1.2, linestyle=":")
    tip = min(margin.limit, 0.97 * plane.top)
    if margin.stiffness > 0.0 and margin.limit > 0.0:
        axes.annotate(
            "", (margin.damping, tip), (margin.damping, margin.stiffness), zorder=7,
            arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 2.2, "mutation_scale": 18},
        )  # fmt: skip
        _say(axes, plane, 0.5 * (tip + margin.stiffness), factor(margin.ratio), color)
    axes.plot(
        margin.damping, margin.stiffness, "o", markersize=14, color=color, markeredgecolor=SURFACE,
        markeredgewidth=2, zorder=8, clip_on=False,
    )  # fmt: skip
    _say(axes, plane, margin.stiffness, f"{margin.stiffness:,.0f} N/m, {margin.damping:.1f} N·s/m", color)


def _say(axes: Any, plane: Plane, height: float, words: str, color: str) -> None:
    """Write beside the dot, on its other side where there is no room."""
    left = plane.margin.damping > 0.62 * plane.width
    axes.annotate(
        words, (plane.margin.damping, height), (-14 if left else 14, 0), textcoords="offset points",
        ha="right" if left else "left", va="center", size=_NAME, weight="bold", color=color, zorder=8,
        path_effects=_rim(),
    )  # fmt: skip


def _rim() -> list:
    """Return what draws words readable across a line."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=4, foreground=SURFACE, alpha=0.8)]

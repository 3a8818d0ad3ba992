"""Identification: force over what moves, with the line that was found and its band; residuals below."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.charts.style import APPLIED, EDGE, GRID, HELD, INK, QUIET, SURFACE, THEORY
from hapkit_studio.figures import new_figure

if TYPE_CHECKING:
    from hapkit_studio.analysis.identify import Identified, Part

# What is drawn over what: a term's column, its axis, and how many of the axis's units one SI unit has.
AXES = {
    "stiffness": ("position, mm", 1e3),
    "damping": ("velocity, mm/s", 1e3),
    "damping_in": ("velocity going in, mm/s", 1e3),
    "damping_out": ("velocity going out, mm/s", 1e3),
    "friction": ("direction of motion", 1.0),
    "mass": ("acceleration, m/s²", 1.0),
    "viscous": ("velocity, mm/s", 1e3),
    "coulomb": ("direction of motion", 1.0),
}
TITLES = {"rendered": "What was rendered", "handle": "What the handle is"}
_MOST_PANELS = 3
_TEXT, _HEAD = 12, 16


def identify_figure(found: "Identified", path: str | Path) -> None:
    """Draw both answers: a row of charts each, the residuals below, the numbers in words.

    The path's ending picks the format. Raise ParameterError for an ending that is no format of pictures.
    """
    parts = [part for part in (found.rendered, found.handle) if part.points is not None]
    figure = new_figure(path, (15, 1.5 + 6.0 * max(len(parts), 1)))
    rows = figure.subfigures(max(len(parts), 1), 1, squeeze=False)[:, 0]
    for row, part in zip(rows, parts or [found.rendered], strict=True):
        _draw(row, part, found)
    figure.savefig(path, dpi=110, facecolor=SURFACE)


def _draw(figure: Any, part: "Part", found: "Identified") -> None:
    lines = [line for line in found.sentences(part) if not line.startswith("  ")]
    figure.suptitle(TITLES[part.key], size=_HEAD, color=INK, weight="bold")
    figure.supxlabel("\n".join(lines), size=_TEXT, color=INK, x=0.04, ha="left")
    if part.points is None:
        return
    names = [name for name in part.points.names if name in AXES][:_MOST_PANELS]
    grid = figure.add_gridspec(2, len(names), height_ratios=(3, 1))
    for column, name in enumerate(names):
        _term(figure.add_subplot(grid[0, column]), part, name)
    _residuals(figure.add_subplot(grid[1, :]), part)


def _term(axes: Any, part: "Part", name: str) -> None:
    points, estimate = part.points, part[name]
    assert points is not None
    label, scale = AXES[name]
    own, force = points.share(name)
    sign = -1.0 if part.key == "rendered" else 1.0
    beyond = np.linspace(own.min(), own.max(), 60)
    fit, half = points.line(name, beyond)
    axes.plot(scale * own, sign * force, ".", ms=3, color=APPLIED, alpha=0.5)
    axes.fill_between(
        scale * beyond, sign * (fit - half), sign * (fit + half), color=THEORY, edgecolor=EDGE, lw=1, zorder=1
    )
    axes.plot(scale * beyond, sign * fit, color=INK, lw=2)
    if estimate.asked is not None:
        middle = 0.5 * (beyond[0] + beyond[-1]) if name == "stiffness" else 0.0
        through = np.interp(middle, beyond, fit) if name == "stiffness" else 0.0
        axes.plot(
            scale * beyond, sign * (through + estimate.asked * (beyond - middle)), color=HELD, ls=":", lw=2
        )
    axes.set_title(estimate.term.label, size=_TEXT + 1, color=INK, loc="left")
    axes.set_xlabel(label, size=_TEXT)
    axes.set_ylabel("force, the rest taken away, N", size=_TEXT)
    _quiet(axes)


def _residuals(axes: Any, part: "Part") -> None:
    points = part.points
    assert points is not None
    axes.plot(points.time, 1e3 * points.residual, ".", ms=2, color=APPLIED)
    axes.axhline(0.0, color=INK, lw=1)
    axes.set_xlabel("time, s", size=_TEXT)
    axes.set_ylabel("left over, mN", size=_TEXT)
    _quiet(axes)


def _quiet(axes: Any) -> None:
    axes.grid(color=GRID)
    axes.tick_params(labelsize=_TEXT, colors=QUIET)
    axes.spines[["top", "right"]].set_visible(False)

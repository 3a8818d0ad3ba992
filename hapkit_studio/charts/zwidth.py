"""The Z-width: the stiffest wall over virtual damping, the linear loop's limit beside it."""

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.charts.style import GRID, INK, INK2, LINE, POSITION, QUIET, STABLE, SURFACE
from hapkit_studio.figures import new_figure

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth_result import ZWidth

_WIDTH, _TITLE_WIDTH = 108, 64  # letters that fit into a line


def zwidth_figure(result: "ZWidth", path: str | Path) -> None:
    """Draw stiffness over damping: what was rendered, what the linear loop allows, under which conditions.

    A hollow marker: the motor's limit was reached. The path's ending picks the format. Raise ParameterError
    for an ending that is no format of pictures.
    """
    figure = new_figure(path, (11, 7))
    axes = figure.add_subplot()
    _rendered(axes, result)
    _linear(axes, result)
    highest = np.nanmax(np.append(result.stiffness, result.curve[1]), initial=100.0)
    axes.set_ylim(0.0, 1.28 * highest)
    right = max(float(result.damping[-1]), 1.0)
    axes.set_xlim(-0.02 * right, 1.04 * right)
    axes.set_xlabel("virtual damping B, N·s/m", size=13, color=INK2)
    axes.set_ylabel("virtual stiffness K, N/m", size=13, color=INK2)
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
    axes.tick_params(labelsize=12, colors=INK2)
    axes.grid(color=GRID)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(LINE)
    axes.legend(frameon=False, fontsize=12, loc="upper left", labelcolor=INK)
    title = textwrap.fill(result.sentence, _TITLE_WIDTH)
    axes.set_title(title, size=17, color=INK, loc="left", pad=14, weight="bold")
    figure.supxlabel(_caption(result), size=11, color=QUIET, x=0.02, ha="left")
    figure.savefig(path, dpi=110, facecolor=SURFACE)


def _caption(result: "ZWidth") -> str:
    """Return the conditions in lines that break between two of them only."""
    whole = [words.replace(" ", "\u00a0") for words in (result.place, *(c.words for c in result.conditions))]
    return textwrap.fill(" · ".join(whole), _WIDTH, break_on_hyphens=False)


def _rendered(axes: Any, result: "ZWidth") -> None:
    axes.fill_between(result.damping, result.stiffness, color=STABLE, linewidth=0.0)
    axes.plot(result.damping, result.stiffness, "-o", color=POSITION, linewidth=2.2, markersize=8,
              markerfacecolor=POSITION, label="rendered without buzzing", zorder=3)  # fmt: skip
    clamped = np.array(result.clamped, dtype=bool)
    if clamped.any():
        axes.plot(result.damping[clamped], result.stiffness[clamped], "o", color=POSITION, markersize=8,
                  markerfacecolor=SURFACE, markeredgewidth=2.0, label="the same, at the motor's limit",
                  zorder=4)  # fmt: skip


def _linear(axes: Any, result: "ZWidth") -> None:
    if np.isfinite(result.curve[1]).any():
        axes.plot(*result.curve, color=INK, linewidth=1.8, dashes=(5, 3),
                  label="limit of the linear loop: no friction, no sensor steps")  # fmt: skip

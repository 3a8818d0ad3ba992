"""What every drawing shares: colours by token, quiet axes, names above them, saving in light colours."""

import textwrap
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hapkit_studio.figures import new_figure
from hapkit_studio.palette import paler, table

Colors = SimpleNamespace
"""Every token of the palette as an attribute, "#RRGGBB"."""
Paint = Callable[[Any, Colors], object]
"""Draws on an empty figure of any size; text sizes are in points, which in the window are pixels."""

TICK, TEXT, HEAD = 12, 13, 16
DOT, DASH, DASH_DOT = (0, (1, 1.6)), (0, (5, 3.5)), (0, (7, 2.6, 1.6, 2.6))
_TICKS, _MOST = 90.0, 0.34  # points that ticks and title of an axis take; share of the height for names
_LETTER = 5.6  # points that a letter of a caption takes
_DPI, _PAD = 110, 0.12  # inches
# what stays as strong while data are out of date
_GROUND = {"surface", "plot", "grid", "line", "edge", "axis", "ink2", "ink3"}


def colors(mode: str = "light") -> Colors:
    """Return the colours of a mode of the palette."""
    return SimpleNamespace(**table(mode))


def pale(strong: Colors) -> Colors:
    """Return colours in which data that are out of date are drawn."""
    faint = {k: v if k in _GROUND else paler(v, strong.plot) for k, v in vars(strong).items()}
    return SimpleNamespace(**faint)


def save(
    paint: Paint, path: str | Path, size: tuple[float, float], title: str = "", caption: str = ""
) -> None:
    """Write a drawing of so many points in light colours, its title above it, its conditions below.

    The path's ending picks the format. Raise ParameterError for an ending that is no format of pictures.
    """
    figure, light = new_figure(path, (size[0] / 72.0, size[1] / 72.0)), colors()
    figure.get_layout_engine().set(w_pad=_PAD, h_pad=_PAD)
    letters = round(size[0] / _LETTER)
    if title:
        words = textwrap.fill(title, round(0.47 * letters))
        figure.suptitle(words, size=HEAD, weight="bold", color=light.ink, x=0.01, ha="left")
    if caption:
        words = "\n".join(
            textwrap.fill(line, letters, break_on_hyphens=False) for line in caption.split("\n")
        )
        figure.supxlabel(words, size=TICK - 1, color=light.ink3, x=0.01, ha="left")
    paint(figure, light)
    figure.savefig(path, dpi=_DPI, facecolor=light.surface)


def whole(parts: list[str]) -> str:
    """Return conditions as one line that breaks between two of them only."""
    return " · ".join(words.replace(" ", "\u00a0") for words in parts)


def dress(axes: Any, c: Colors, across: str, up: str) -> None:
    """Title the axes; give them a quiet frame and grid."""
    axes.set_facecolor(c.plot)
    axes.set_xlabel(across, size=TICK, color=c.axis)
    axes.set_ylabel(up, size=TICK, color=c.axis)
    axes.tick_params(which="both", labelsize=TICK, color=c.line, labelcolor=c.axis)
    axes.grid(color=c.grid, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[:].set_color(c.line)


def legend(axes: Any, c: Colors) -> None:
    """Name what is drawn above the axes, in as few rows as fit; nothing where little else would stay."""
    names = axes.get_legend_handles_labels()[1]
    box = axes.figure.bbox
    share = axes.get_subplotspec().get_position(axes.figure).width / 0.775
    for columns in range(len(names), 0, -1):
        made = axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, fontsize=TICK,
            labelcolor=c.ink2, borderaxespad=0.2, columnspacing=1.2, handlelength=1.7, labelspacing=0.3,
        )  # fmt: skip
        taken = made.get_window_extent()
        if taken.width <= share * box.width - _TICKS * axes.figure.dpi / 72.0:
            made.set_visible(taken.height <= _MOST * box.height)
            return


def rim(c: Colors) -> list:
    """Return what draws words readable across a line."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=4, foreground=c.plot, alpha=0.8)]

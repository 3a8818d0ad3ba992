"""The shared style of all figures: colours by token, quiet axes, legends above axes, saving in light colours.

Labels are placed so that they cover no line and no other label.
"""

import io
import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from hapkit_studio.errors import ParameterError
from hapkit_studio.files import replacing
from hapkit_studio.palette import paler, table

Colors = SimpleNamespace
"""Palette tokens as attributes, "#RRGGBB"."""
Paint = Callable[[Any, Colors], object]
"""Draws on an empty figure of any size; text sizes are in points, equal to pixels in the window."""

TICK, TEXT, HEAD = 12, 13, 16
DOT, DASH, DASH_DOT = (0, (1, 1.6)), (0, (5, 3.5)), (0, (7, 2.6, 1.6, 2.6))
_MOST = 0.34  # largest height of the legend, as a fraction of the height of the figure
_LETTER = 6.4  # pt: width of a character of a caption
_DPI, _PAD = 110, 0.12  # resolution in dots per inch; padding around the axes in inches
# colour tokens that do not fade while the data are out of date
_GROUND = {"surface", "plot", "grid", "line", "edge", "axis", "ink2", "ink3"}


def colors(mode: str = "light") -> Colors:
    """Return the palette's colours in a mode such as "light"."""
    return SimpleNamespace(**table(mode))


def pale(strong: Colors) -> Colors:
    """Return the faded colours of out-of-date data."""
    faint = {k: v if k in _GROUND else paler(v, strong.plot) for k, v in vars(strong).items()}
    return SimpleNamespace(**faint)


def save(
    paint: Paint, path: str | Path, size: tuple[float, float], title: str = "", caption: str = ""
) -> None:
    """Write a drawing in light colours, with title and caption; ``size`` is in points.

    The path's suffix selects the format. Raise ParameterError if the suffix is not that of a picture format.
    """
    figure, light = new_figure(path, (size[0] / 72.0, size[1] / 72.0)), colors()
    figure.get_layout_engine().set(w_pad=_PAD, h_pad=_PAD)
    letters = round(size[0] / _LETTER)
    if title:
        text = textwrap.fill(title, round(0.47 * letters))
        figure.suptitle(text, size=HEAD, weight="bold", color=light.ink, x=0.01, ha="left")
    if caption:
        text = "\n".join(textwrap.fill(line, letters, break_on_hyphens=False) for line in caption.split("\n"))
        figure.supxlabel(text, size=TICK - 1, color=light.ink3, x=0.01, ha="left")
    paint(figure, light)
    picture = io.BytesIO()  # save to memory first: picture writers seek, which is impossible in a pipe
    figure.savefig(picture, format=ending(path), dpi=_DPI, facecolor=light.surface)
    with replacing(path) as part:
        part.write_bytes(picture.getvalue())


def unbroken(parts: list[str]) -> str:
    """Join conditions in a line that breaks only between conditions."""
    return " · ".join(text.replace(" ", "\u00a0") for text in parts)


def style_axes(axes: Any, c: Colors, across: str, up: str) -> None:
    """Label the axes, and give them a quiet frame and grid."""
    axes.set_facecolor(c.plot)
    axes.set_xlabel(across, size=TICK, color=c.axis)
    axes.set_ylabel(up, size=TICK, color=c.axis)
    axes.tick_params(which="both", labelsize=TICK, color=c.line, labelcolor=c.axis)
    for axis in (axes.xaxis, axes.yaxis):
        number_ticks(axis)
    axes.grid(color=c.grid, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[:].set_color(c.line)


def number_ticks(axis: Any) -> None:
    """Format an axis' ticks like the numbers in texts and in the window's plots: 1,000 and −2, not 10³.

    Call this function again after a change of the axis' scale, because the change restores matplotlib's
    formats.
    """
    from hapkit_studio.charts.ticks import MinorTicks, Ticks

    linear = axis.get_scale() == "linear"
    axis.set_major_formatter(Ticks(linear))
    if not linear:
        axis.set_minor_formatter(MinorTicks())


def legend(axes: Any, c: Colors) -> None:
    """Put the legend above the axes in as few rows as possible; hide it if the axes become too small."""
    names = axes.get_legend_handles_labels()[1]
    box, wide = axes.figure.bbox, axes.get_subplotspec().get_position(axes.figure).width
    for rows in range(1, len(names) + 1):
        columns = -(-len(names) // rows)
        made = axes.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False, fontsize=TICK,
            labelcolor=c.ink2, borderaxespad=0.2, columnspacing=1.2, handlelength=1.7, labelspacing=0.3,
        )  # fmt: skip
        taken = made.get_window_extent()
        # the layout widens the axes by more than 10 %; a wider legend would leave unused space at their right
        if taken.width <= 1.1 * wide * box.width:
            made.set_visible(taken.height <= _MOST * box.height)
            return


def text_outline(c: Colors) -> list:
    """Return path effects that keep text readable across a line."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=4, foreground=c.plot, alpha=0.8)]


@dataclass(frozen=True)
class Label:
    """A text at a point; a bold label must not cover a line."""

    x: float
    y: float
    text: str
    color: str
    bold: bool = False


def write_labels(axes: Any, c: Colors, labels: Sequence[Label]) -> None:
    """Place labels near their points without overlap, with a leader line if the distance is large.

    The figure's layout must be final.
    """
    lines = list(axes.lines)
    taken: list[Any] = []
    for label in sorted(labels, key=lambda label: (not label.bold, -label.y)):
        note = axes.annotate(
            label.text, (label.x, label.y), (0.0, 0.0), textcoords="offset points", va="center", size=TICK,
            color=label.color, weight="bold" if label.bold else "normal", zorder=9, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": label.color, "linewidth": 0.8, "visible": False},
            bbox={"facecolor": c.plot, "alpha": 0.75, "edgecolor": "none", "pad": 0.6},
        )  # fmt: skip
        note.set_in_layout(False)
        keep_clear(note, lines if label.bold else (), taken)
        note.arrow_patch.set_visible(math.hypot(*note.xyann) > _FAR)
        taken.append(note.get_window_extent())


_FAR = 20.0  # pt: a label farther from its point has a leader line
_CLEAR = 3.0  # pt: distance between a label and a line
# candidate offsets of a label from its point in pt, nearest first
_OFFSETS = sorted(
    ((dx, dy) for dx in (13, -13, 40, -40, 90, -90) for dy in range(-132, 133, 6)),
    key=lambda away: (math.hypot(*away), -away[0]),
)


def keep_clear(label: Any, lines: Sequence[Any], taken: Sequence[Any] = ()) -> None:
    """Place a label so that it covers no line or box; if there is no such place, put it next to its point."""
    from matplotlib.transforms import Bbox

    axes, points = label.axes, label.figure.dpi / 72.0
    frame, (_, _, width, height) = axes.get_window_extent(), label.get_window_extent().bounds
    x, y = axes.transData.transform(label.xy)
    paths = [line.get_path().transformed(line.get_transform()) for line in lines if line.get_visible()]

    def free(away: tuple[int, int]) -> bool:
        left, middle = x + points * away[0], y + points * away[1]
        box = Bbox.from_bounds(left if away[0] > 0 else left - width, middle - 0.5 * height, width, height)
        inside = frame.contains(box.x0, box.y0) and frame.contains(box.x1, box.y1)
        wide = box.padded(_CLEAR * points)
        crossed = inside and any(path.intersects_bbox(wide, filled=False) for path in paths)
        return inside and not crossed and not box.count_overlaps(taken)

    label.xyann = next(filter(free, _OFFSETS), _OFFSETS[0])
    label.set(horizontalalignment="left" if label.xyann[0] > 0 else "right")


def new_figure(path: str | Path, size: tuple[float, float]) -> Any:
    """Return an empty figure of this size in inches; raise ParameterError for an unknown picture format."""
    from matplotlib.figure import Figure

    check_picture(path)
    return Figure(figsize=size, layout="constrained")


PNG = "png"


def ending(path: str | Path) -> str:
    """Return the picture format of a path's suffix; PNG if the path has no suffix."""
    return Path(path).suffix[1:].lower() or PNG


def check_picture(path: str | Path) -> None:
    """Raise ParameterError unless the path has the suffix of a picture format."""
    from matplotlib.backend_bases import FigureCanvasBase

    found, known = ending(path), FigureCanvasBase.get_supported_filetypes()
    if found not in known:
        raise ParameterError(f"The name of a picture must end in one of {', '.join(known)}, not {found!r}.")

"""Speed against accuracy: a picture a scene, error over computing time, both in powers of ten."""

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.accuracy.words import sentence, verdict
from hapkit_studio.charts.accuracy_axes import Frame
from hapkit_studio.charts.accuracy_names import write_names
from hapkit_studio.charts.methods import look
from hapkit_studio.charts.style import (
    ACCENT,
    DANGER,
    EDGE,
    INK,
    LIGHT,
    OK,
    QUIET,
    STABLE,
    SURFACE,
    THEORY,
    WARN,
)
from hapkit_studio.figures import new_figure

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Accuracy, Point, Sheet

_LARGE, _SMALL = (12.0, 8.8), (7.6, 7.0)
_KEY = (
    "Filled: the loop's own step.  Hollow: other steps.  Ring: the default.  Grey band: nothing is beyond it."
)
_MARKERS = {
    "star": "*", "diamond": "D", "square": "s", "pentagon": "p", "circle": "o", "down": "v", "plus": "P",
    "up": "^", "cross": "X",
}  # fmt: skip
_SIZE = 8.5
_LARGER = {"star": 13.0, "pentagon": 10.0, "plus": 10.0, "cross": 9.5}


def accuracy_figure(result: "Accuracy", path: str | Path) -> None:
    """Draw every scene of a result: one large, or several side by side.

    The path's ending picks the format. Raise ParameterError for an ending that is no format of pictures.
    """
    sheets = result.sheets
    columns = 1 if len(sheets) == 1 else 2 if len(sheets) <= 4 else 3 if len(sheets) <= 9 else 4
    rows = -(-len(sheets) // columns)
    wide, high = _LARGE if columns == 1 else _SMALL
    figure = new_figure(path, (columns * wide, rows * high))
    figure.get_layout_engine().set(w_pad=0.25, h_pad=0.25, wspace=0.02, hspace=0.02)
    panels = [(figure.add_subplot(rows, columns, i + 1), sheet) for i, sheet in enumerate(sheets)]
    frames = [_draw(axes, sheet, large=columns == 1) for axes, sheet in panels]
    figure.supxlabel(_KEY, size=12.0, color=QUIET)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for (axes, sheet), frame in zip(panels, frames, strict=True):
        write_names(axes, sheet, frame)
    figure.savefig(path, dpi=110, facecolor=SURFACE)


def _draw(axes: Any, sheet: "Sheet", large: bool) -> Frame:
    frame = Frame(sheet)
    frame.dress(axes)
    _head(axes, sheet, large)
    _tolerance(axes, sheet, frame)
    _front(axes, sheet.front, frame)
    for method in sheet.methods:
        _line(axes, sheet, sheet.line(method.key), frame)
    default = sheet.answer.default
    if default is not None:
        axes.plot(
            *frame.place(default), "o", markersize=21, markerfacecolor="none", markeredgecolor=ACCENT,
            markeredgewidth=2.4, zorder=8,
        )  # fmt: skip
    return frame


def _head(axes: Any, sheet: "Sheet", large: bool) -> None:
    """Write title, answer with its sign, and what the default makes of it."""
    right = sheet.answer.right
    size, wide = (18.0, 96) if large else (15.0, 64)
    words = size * 0.8
    answer = fill(("✓ " if right else "▲ ") + sentence(sheet), wide)
    more = fill(verdict(sheet), round(1.12 * wide))
    lines = answer.count("\n") + more.count("\n") + 2
    above = (1.3 * lines + 1.0) * words
    axes.set_title(sheet.scene.title, loc="left", size=size, weight="bold", color=INK, pad=above)
    up = (1.3 * (more.count("\n") + 1) + 0.5) * words
    for text, color, bottom, bold in (
        (answer, OK if right else WARN, up, True),
        (more, QUIET, 0.5 * words, False),
    ):
        made = axes.annotate(
            text, (0.0, 1.0), (0.0, bottom), xycoords="axes fraction", textcoords="offset points",
            va="bottom", size=words if bold else 0.92 * words, color=color,
            weight="bold" if bold else "normal",
        )  # fmt: skip
        made.set_in_layout(False)


def _tolerance(axes: Any, sheet: "Sheet", frame: Frame) -> None:
    """Tint what is within the tolerance, and draw its limit."""
    limit = sheet.scene.tolerance * frame.factor
    axes.axhspan(frame.bottom, limit, color=STABLE, alpha=0.45, linewidth=0.0, zorder=0.5)
    axes.axhline(limit, color=DANGER, linewidth=1.8, dashes=(5, 3), zorder=2.5)


def _front(axes: Any, front: Sequence["Point"], frame: Frame) -> None:
    """Draw the edge beyond which no point lies: a staircase as a band with kerbs."""
    if not front:
        return
    x, y = [], [frame.top]
    for point in front:
        cost, error = frame.place(point)
        x += [cost, cost]
        y += [error, error]
    x.append(frame.right)
    for color, width in ((EDGE, 9.6), (THEORY, 7.2)):
        axes.plot(x, y, color=color, linewidth=width, solid_joinstyle="miter", zorder=2.0)


def _line(axes: Any, sheet: "Sheet", points: Sequence["Point"], frame: Frame) -> None:
    """Draw a method's points, those at the loop's own step filled, joined by a line."""
    if not points:
        return
    shape, token = look(points[0].method)
    color = LIGHT[token]
    sound = [p for p in points if math.isfinite(p.error)]
    places = [frame.place(p) for p in sound]
    axes.plot(*zip(*places, strict=True), color=color, linewidth=1.5, zorder=3) if places else None
    for point, place in zip(sound, places, strict=True):
        filled = abs(point.step_s - sheet.scene.default.step_s) <= 1e-9
        axes.plot(
            *place, _MARKERS[shape], markersize=_LARGER.get(shape, _SIZE) * (1.0 if filled else 0.85),
            markeredgecolor=color, markerfacecolor=color if filled else SURFACE, markeredgewidth=1.5,
            zorder=5 if filled else 4,
        )  # fmt: skip

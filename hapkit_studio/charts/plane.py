"""Figure of a failure over two dimensionless numbers: boundaries, measured points, the knob's point."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.charts import style
from hapkit_studio.formatting import compact

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures.base import Shown
    from hapkit_studio.analysis.failures.plane import Panel, Plane

_SIZE, _SMALL_SIZE = (1080, 700), (820, 600)
_COLUMNS = 4
_LOW_FIGURE = 6.0  # inches: a figure below this height shows only the panel of the case
# colour token and marker for each outcome
_POINTS = {
    "stable": ("ok", "o"),
    "bounded": ("warn", "D"),
    "pushed": ("warn", "^"),
    "unstable": ("danger", "X"),
}
_LARGEST = 3.0  # largest value of the colour scale
_DASHES = (style.DASH, style.DOT, style.DASH_DOT)


def plane_figure(shown: "Shown", path: str | Path) -> None:
    """Write a failure's plane with its sentence above and the conditions below."""
    plane = shown.plane
    assert plane is not None
    conditions = [f"{p.label} {p.text(shown.case[p.key])}" for p in shown.failure.options]
    size = _SIZE if len(plane.panels) > 1 else _SMALL_SIZE
    title = f"{shown.failure.title}. {plane.sentence}"
    style.save(
        lambda figure, c: draw(figure, c, plane).place(shown.limit),
        path, size, title, style.unbroken(conditions),
    )  # fmt: skip


class KnobPoint:
    """The point of a plane that shows the knob's value; ``artists`` are drawn last."""

    def __init__(self, axes: Any, c: style.Colors, plane: "Plane"):
        self._plane = plane
        (self._ring,) = axes.plot([], [], "o", color="none", markersize=15, markeredgecolor=c.accent,
                                  markeredgewidth=2.6, zorder=9, clip_on=False)  # fmt: skip
        (self._dot,) = axes.plot([], [], "o", color=c.accent, markersize=6, zorder=9, clip_on=False)
        self.artists = (self._ring, self._dot)

    def place(self, value: float | None) -> None:
        """Move the point to a value of the knob; None hides the point."""
        x, y = (np.nan, np.nan) if value is None else self._plane.place(value)
        for artist in self.artists:
            artist.set_data([x], [y])


def draw(figure: Any, c: style.Colors, plane: "Plane") -> KnobPoint:
    """Draw all panels, or only the panel of the case if the figure is low; return the knob's point."""
    from matplotlib.ticker import LogLocator, NullFormatter

    panels, own = plane.panels, plane.own
    if figure.get_figheight() < _LOW_FIGURE:
        panels, own = (panels[own],), 0
    count = len(panels)
    columns = min(count, _COLUMNS)
    grid = figure.subplots(-(-count // columns), columns, sharex=True, sharey=True, squeeze=False)
    for index, (axes, panel) in enumerate(zip(grid.flat, panels, strict=True)):
        across = plane.x_label if index + columns >= count else ""
        style.style_axes(axes, c, across, plane.y_label if index % columns == 0 else "")
        axes.set_navigate(False)
        for axis in (axes.xaxis, axes.yaxis):
            getattr(axes, f"set_{axis.axis_name}scale")("log")
            axis.set_major_locator(LogLocator(subs=(1.0,) if count > 1 else (1.0, 2.0, 5.0)))
            style.number_ticks(axis)
            axis.set_minor_formatter(NullFormatter())
        _panel(axes, c, panel)
        if panel.title:
            mine = index == own and count > 1
            axes.set_title(panel.title, size=style.TEXT, loc="left", color=c.accent if mine else c.ink,
                           weight="bold" if mine else "normal")  # fmt: skip
        else:
            style.legend(axes, c)
    return KnobPoint(grid.flat[own], c, plane)


def _panel(axes: Any, c: style.Colors, panel: "Panel") -> None:
    field = panel.field
    axes.set_xlim(field.x[0], field.x[-1])
    axes.set_ylim(field.y[0], field.y[-1])
    filled = axes.contourf(
        field.x, field.y, np.minimum(field.z, _LARGEST), levels=[0.0, 1.0, 2.0, _LARGEST],
        colors=[c.stable, c.warnsoft, c.unstable], hatches=["", "", "//"], zorder=0.1,
    )  # fmt: skip
    filled.set_edgecolor(c.danger + "40")
    filled.set_linewidth(0.0)
    if field.levels:
        lines = axes.contour(field.x, field.y, field.z, levels=field.levels, colors=[c.ink3], linewidths=0.9,
                             zorder=2)  # fmt: skip
        axes.clabel(lines, fmt=compact, fontsize=style.TICK - 2, colors=[c.ink3])
    weak = iter(_DASHES)
    for line in panel.boundaries:
        color, dashes = (c.ink, "-") if line.strong else (c.ink2, next(weak))
        axes.plot(line.x, line.y, color=color, linestyle=dashes, linewidth=2.4 if line.strong else 1.5,
                  label=line.label, zorder=3)  # fmt: skip
    for points in panel.points:
        token, marker = _POINTS[points.outcome]
        axes.plot(points.x, points.y, marker, color=getattr(c, token), markersize=7, label=points.label,
                  markeredgecolor=c.plot, markeredgewidth=0.8, zorder=5)  # fmt: skip
    for x, y, text in panel.marks:
        axes.plot([x], [y], "*", color=c.hold, markersize=11, markeredgecolor=c.plot, zorder=6, clip_on=False)
        axes.annotate(text, (x, y), (7, 3), textcoords="offset points", size=style.TICK - 2,
                      color=c.ink2, path_effects=style.text_outline(c), zorder=6)  # fmt: skip

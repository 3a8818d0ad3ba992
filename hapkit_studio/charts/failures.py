"""Figure of a failure: motion just inside and just outside the limit, and the measured curve."""

import itertools
import math
import re
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.charts import style
from hapkit_studio.formatting import compact, on_screen, unbroken

if TYPE_CHECKING:
    from hapkit_studio.analysis.failures.base import Chart, Evidence, Shown, Try

_SIZE = (1080, 560)
_LONG = 50  # characters of the longest verdict that fits next to the knob's name and value
_LETTER = 6.6  # pt: width of a character of a title
_ROOM = 0.08  # each label at the top takes this fraction of the height
_LINE = 16.0  # pt: line height
# a mark beyond this fraction of the axis has its label at the left
_RIGHT = 0.7
_SHORT = 0.5  # s: the axis of a shorter trace is in ms
_TRACE = 0.36  # the title of a trace takes at most this fraction of the width
_DECADES = 3.0  # a shorter axis also has ticks at 2 and 5
_SMALL = 0.01  # smaller numbers are scaled by a power of ten
_FEW = 50  # up to this many samples, a trace shows its points
# colour token, dashes and marker of a curve, by its role and by its rank within the role
_LOOKS = {
    "theory": (("ink", (0, (3.2, 2.0)), ""), ("asked", (0, (5, 2)), ""), ("energy", (0, (5, 2, 1.2, 2)), "")),
    "measured": (("position", "none", "o"), ("velocity", "none", "s"), ("applied", "none", "^")),
    "other": (("hold", style.DOT, ""), ("energy", (0, (5, 2, 1.2, 2)), ""), ("asked", style.DOT, "")),
}


def failure_figure(shown: "Shown", path: str | Path) -> None:
    """Write a failure's figure, with its formula above and its conditions below."""
    failure = shown.failure
    conditions = [f"{p.label} {p.text(shown.case[p.key])}" for p in failure.options]
    title = f"{failure.title}: {failure.formula}"
    style.save(lambda figure, c: draw(figure, c, shown), path, _SIZE, title, style.unbroken(conditions))


def draw(figure: Any, c: style.Colors, shown: "Shown") -> "Knob | None":
    """Draw two traces at the left and the curve at the right.

    Return the knob, or None if the x axis of the curve does not show the knob's quantity.
    """
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.2))
    for row, (word, one) in enumerate((("inside", shown.inside), ("outside", shown.outside))):
        axes = figure.add_subplot(grid[row, 0])
        axes.set_navigate(False)  # no zooming in the small traces
        _trace(axes, style.pale(c) if word in shown.old else c, shown, one, word)
        below = shown.outside and _time_label(shown.outside)
        if row == 0 and axes.get_xlabel() == below:
            axes.set_xlabel("")  # the lower trace has the same label
    axes = figure.add_subplot(grid[:, 1])
    if shown.chart is None:
        axes.set_navigate(False)
        style.style_axes(axes, c, "", "")
        axes.tick_params(labelbottom=False, labelleft=False)
        return None
    _curve(axes, style.pale(c) if "chart" in shown.old else c, shown, shown.chart)
    return Knob(axes, c, shown.scale) if shown.scale is not None else None


def clauses(text: str) -> list[str]:
    """Split a sentence into its verdict and its additions, each without a full stop."""
    parts = [part.strip() for part in re.split("[;,] ", text)]
    return [part[:1].upper() + part[1:] for part in parts]


def _trace(axes: Any, c: style.Colors, shown: "Shown", one: "Try | None", word: str) -> None:
    letters = int(_TRACE * 72.0 * axes.figure.get_figwidth() / _LETTER)
    if one is None:
        style.style_axes(axes, c, "", "")
        axes.tick_params(labelbottom=False, labelleft=False)
        axes.set_title(f"{word.capitalize()}: not tried yet", size=style.TEXT, color=c.ink3, loc="left")
        return
    found = one.evidence
    color, sign = (c.ok, "✓") if found.holds else (c.danger, "✕")
    time, trace = found.trace
    factor, power = scaled(trace)
    axes.plot(
        (1e3 if _is_short(one) else 1.0) * time, factor * trace, color=color, linewidth=1.6, markersize=4,
        marker="o" if len(time) < _FEW else "", drawstyle="steps-post" if found.held else "default",
    )  # fmt: skip
    knob, limit = shown.failure.knob, shown.limit
    place, size = on_screen(one.value, knob.unit, 4), style.TICK
    if letters > _LONG and limit:
        far = f"{knob.symbol or knob.label} = {on_screen(one.value, knob.unit, 5)}"
        place, size = f"{word}, {far}, {compact(one.value / limit, 3)} × the limit", style.TEXT
    title = fill(unbroken(f"{sign} {place}: {clauses(found.text)[0].lower()}"), letters)
    axes.set_title(title, size=size, color=color, loc="left")
    style.style_axes(axes, c, _time_label(one), f"{power} {found.unit}".strip())
    axes.locator_params(axis="y", nbins=4)


def _is_short(one: "Try") -> bool:
    """Return True if a trace's time axis is in ms."""
    return 0.0 < one.evidence.seconds < _SHORT


def _time_label(one: "Try") -> str:
    """Return the label of a trace's time axis, with the name of the drawn quantity."""
    return f"{one.evidence.label} over time, {'ms' if _is_short(one) else 's'}"


def scaled(y: np.ndarray) -> tuple[float, str]:
    """Return a factor that makes small numbers readable, and its inverse as text, "" for a factor of 1."""
    finite = np.asarray(y)[np.isfinite(y)]
    most = float(np.abs(finite).max()) if len(finite) else 0.0
    if not 0.0 < most < _SMALL:
        return 1.0, ""
    exponent = -3 * math.floor(math.log10(most) / 3.0)
    return 10.0**exponent, f"$10^{{{-exponent}}}$"


def _curve(axes: Any, c: style.Colors, shown: "Shown", chart: "Chart") -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    plot = chart.plot
    for name, log in (("x", plot.log_x), ("y", plot.log_y)):
        axis = getattr(axes, f"{name}axis")
        if log:
            getattr(axes, f"set_{name}scale")("log")
    looks = {role: itertools.cycle(known) for role, known in _LOOKS.items()}
    for line in chart.lines:
        token, dashes, marker = next(looks[line.role])
        seen = np.isfinite(line.y)
        axes.plot(
            line.x[seen], line.y[seen], color=getattr(c, token), linewidth=2.2, linestyle=dashes,
            marker=marker, markersize=7, markerfacecolor=c.plot, markeredgewidth=1.8, label=line.label,
            zorder=4,
        )  # fmt: skip
    if chart.level is not None:
        axes.axhline(chart.level, color=c.ink3, linewidth=1.2, zorder=2, label=plot.level_label or None)
    for name, log in (("x", plot.log_x), ("y", plot.log_y)):
        axis = getattr(axes, f"{name}axis")
        if log:
            low, high = getattr(axes, f"get_{name}lim")()
            axis.set_major_locator(
                LogLocator(subs=(1.0, 2.0, 5.0) if high < 10.0**_DECADES * low else (1.0,))
            )
        else:
            axes.locator_params(axis=name, nbins=5)
    letters = int(0.55 * 72.0 * axes.figure.get_figheight() / _LETTER)
    style.style_axes(axes, c, plot.x_label, fill(plot.y_label, letters))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())
    _limits(axes, c, shown, chart)
    style.legend(axes, c)


def _limits(axes: Any, c: style.Colors, shown: "Shown", chart: "Chart") -> None:
    """Draw the stable and unstable ranges, the boundary and other limits, each with its label at the top."""
    low, high = axes.get_ylim()
    share = _ROOM * len(chart.marks)
    axes.set_ylim(low, high * (high / low) ** share if chart.plot.log_y else high + share * (high - low))
    axes.set_xlim(axes.get_xlim())
    if shown.scale is not None:
        left, right = axes.get_xlim()
        edge = min(max(next(iter(chart.marks.values())), left), right)
        axes.axvspan(left, edge, color=c.stable, linewidth=0.0, zorder=0.1)
        axes.axvspan(edge, right, facecolor=c.unstable, edgecolor=c.danger + "40", hatch="//", linewidth=0.0,
                     zorder=0.1)  # fmt: skip
    for index, (label, x) in enumerate(chart.marks.items()):
        color = c.ink if index == 0 else c.ink2
        axes.axvline(x, color=color, linewidth=1.4 if index else 2.4, linestyle=style.DOT if index else "-")
        at = axes.transAxes.inverted().transform(axes.transData.transform((x, low)))[0]
        right = at > _RIGHT
        axes.annotate(
            label.replace("_", ""), (x, 1.0), xycoords=("data", "axes fraction"),
            xytext=(-5 if right else 5, -4 - _LINE * index), textcoords="offset points", va="top",
            ha="right" if right else "left", size=style.TICK, color=color, zorder=5,
            path_effects=style.text_outline(c), weight="normal" if index else "bold", annotation_clip=True,
        )  # fmt: skip


class Knob:
    """Markers for the knob's value on the x axis and the value measured there; ``artists`` are drawn last."""

    def __init__(self, axes: Any, c: style.Colors, scale: float | None):
        self._scale = scale or 1.0
        across = axes.get_xaxis_transform()
        self._line = axes.axvline(axes.get_xlim()[0], color=c.accent, linewidth=1.6, linestyle=(0, (5, 3.5)))
        (self._tip,) = axes.plot([], [], "^", color=c.accent, markersize=10, transform=across)
        (self._dot,) = axes.plot([], [], "o", color=c.accent, markersize=11, zorder=8)
        self.artists = (self._line, self._tip, self._dot)
        self.place(None, None)

    def place(self, value: float | None, measure: float | None) -> None:
        """Move to a value in the knob's unit; ``measure`` is the measured value there, None to hide it."""
        x = math.nan if value is None else value * self._scale
        self._line.set_xdata([x, x])
        self._tip.set_data([x], [0.02])
        self._dot.set_data([x], [math.nan if measure is None else measure])


def measured_there(chart: "Chart | None", found: "Evidence") -> float | None:
    """Return a trial's measured value if the chart's y axis shows the same quantity, else None."""
    same = chart is not None and chart.plot.y_label.endswith(f", {found.measure_unit}")
    return found.measure if same and math.isfinite(found.measure) else None

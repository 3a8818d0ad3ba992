"""Speed against accuracy: error over computing time, both in powers of ten, a method a line.

Below it a method's motion over time beside the true one, and its error, where the chart is of motions.

Every method has one marker and one colour's name in all charts, never colour alone; markers are matplotlib's,
colours tokens of the palette.
"""

import math
import os
import platform
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.accuracy import trace
from hapkit_studio.analysis.accuracy.words import (
    limit_words,
    name_words,
    rate_words,
    reason,
    sentence,
    step_words,
    unit,
    verdict,
)
from hapkit_studio.charts.style import (
    DASH,
    TEXT,
    Colors,
    Label,
    legend,
    save,
    style_axes,
    unbroken,
    write_labels,
)
from hapkit_studio.dynamics.estimators import ESTIMATORS
from hapkit_studio.dynamics.stick_slip import MODELS

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy.plan import Accuracy, Method, Point, Sheet, Trace


_OTHERS = tuple(
    zip(
        "osDp*vP^Xo",
        ("velocity", "position", "asked", "energy", "ink", "hold", "lecture", "applied", "ok", "danger"),
        strict=True,
    )
)
# Integrators and rates that look like what they are in the live plots; all others in the order above.
_OWN = {
    "explicit_euler": ("^", "applied"),
    "lecture": ("P", "lecture"),
    "semi_implicit": ("o", "velocity"),
    "verlet": ("s", "position"),
    "rk4": ("D", "asked"),
    "implicit_euler": ("v", "hold"),
    "trapezoid": ("p", "energy"),
    "exact": ("*", "ink"),
    "prompt": ("o", "velocity"),
    "late": ("v", "hold"),
}
_FAMILY = {key: n for family in (ESTIMATORS, MODELS) for n, key in enumerate(family)}


def marker_and_color(method: str) -> tuple[str, str]:
    """Return the marker and the colour's token of a method."""
    return _OWN.get(method, _OTHERS[_FAMILY.get(method, 0) % len(_OTHERS)])


# An error below this is none: no sensor shows it, and rounding made it.
_NOTHING = {"": 1e-17, "m/s": 1e-9}
_NS = 1e-3
_MOST, _INSIDE = 1e6, 0.97
# So far do errors go that only powers of ten tell them; so little do costs that 2 and 5 have ticks.
_WIDE, _NARROW = 1e8, 300.0


class AccuracyAxes:
    """Axes of error in its unit over cost in µs; zero errors have a row of their own, named 0."""

    def __init__(self, sheet: "Sheet"):
        self._sheet = sheet
        scene = sheet.scene
        self._nothing = _NOTHING[scene.unit]
        self.factor, self.unit = unit(scene)
        errors = [p.error for p in sheet.points if self._nothing < p.error < _MOST] + [scene.tolerance]
        low, high = math.log10(min(errors) * self.factor), math.log10(max(errors) * self.factor)
        air = 0.08 * (high - low) + 0.12
        self.has_zero = any(p.error <= self._nothing for p in sheet.points)
        self._zero = 10.0 ** (low - 2.0 * air)
        self.bottom = 10.0 ** (low - (3.2 * air if self.has_zero else air))
        self.top = 10.0 ** (high + air)
        costs = [p.ns_per_simulated_s * _NS for p in sheet.points]
        span = math.log10(max(costs) / min(costs))
        room = 0.05 if scene.step_s else 0.12
        self.left = min(costs) / 10 ** (room * (1.0 + span))
        self.right = max(costs) * 10 ** (0.12 + 0.34 * span)

    def place(self, point: "Point") -> tuple[float, float]:
        """Return a point's place; one with an error beyond the axes stands at the upper edge."""
        edge = self.top**_INSIDE * self.bottom ** (1.0 - _INSIDE)
        error = self._zero if point.error <= self._nothing else min(point.error * self.factor, edge)
        return point.ns_per_simulated_s * _NS, error

    def set_up(self, axes: Any, c: Colors) -> None:
        """Set ranges, ticks, grid and titles."""
        axes.set(xscale="log", yscale="log", xlim=(self.left, self.right), ylim=(self.bottom, self.top))
        subs = (1, 2, 5) if self.right / self.left < _NARROW else (1,)
        across = [sub * 10.0**power for power in range(-2, 6) for sub in subs]
        for axis, places, low, high, write in (
            (axes.xaxis, across, self.left, self.right, _cost),
            (axes.yaxis, self._errors(), self.bottom, self.top, self._tick),
        ):
            shown = [place for place in places if low <= place <= high]
            axis.set_ticks(shown, [write(place) for place in shown])
        axes.minorticks_off()
        error = f"{self._sheet.scene.error}, {self.unit}"
        style_axes(axes, c, "computing time per simulated second", error)

    def _errors(self) -> list[float]:
        """Return where the ticks of errors are, few of them where they go far."""
        floor = self._zero * 1.5 if self.has_zero else self.bottom
        every = 1 if self.top / self.bottom < _WIDE else 3
        subs = (1, 2, 5) if math.log10(self.top / floor) < 2.5 else (1,)
        powers = range(math.floor(math.log10(floor)), math.ceil(math.log10(self.top)) + 1)
        ticks = [sub * 10.0**power for power in powers if power % every == 0 for sub in subs]
        return [t for t in ticks if t >= floor] + ([self._zero] if self.has_zero else [])

    def _tick(self, value: float) -> str:
        if self.has_zero and math.isclose(value, self._zero):
            return "0"
        if 1e-3 <= value < 1e6:
            return f"{value:,g}"
        return f"$10^{{{round(math.log10(value))}}}$"


def _cost(microseconds: float) -> str:
    return f"{microseconds / 1e3:g} ms" if microseconds > 999.0 else f"{microseconds:g} µs"


_LARGE, _SMALL = (864, 634), (547, 504)
_LETTERS = {_LARGE: 105, _SMALL: 66}
_KEY = (
    "Filled: the loop's own step.  Hollow: other steps.  Ring: the default.  Grey band: nothing is beyond it."
)
# The chart's share of the height beside that of a motion below it; the height of both over that of one alone.
_HEIGHTS, _WITH_MOTION = (5, 3), 1.5
_SIZE = 8.5
_LARGER = {"*": 13.0, "p": 10.0, "P": 10.0, "X": 9.5}


def accuracy_figure(result: "Accuracy", path: str | Path, method: str = "") -> None:
    """Write every scene of a result, one large or several side by side; below them what each was.

    method: whose motion is drawn, where a scene's chart has it; "" for the default's.
    """
    sheets, count = result.sheets, len(result.sheets)
    columns = 1 if count == 1 else 2 if count <= 4 else 3 if count <= 9 else 4
    size = _LARGE if columns == 1 else _SMALL
    points = [next((p for p in s.line(method) if s.scene.competes(p)), s.answer.default) for s in sheets]
    motions = [bool(point and trace(point)) for point in points]
    heights = [
        size[1] * (_WITH_MOTION if any(motions[i : i + columns]) else 1.0) for i in range(0, count, columns)
    ]

    def paint(figure: Any, c: Colors) -> None:
        panels = figure.subfigures(len(heights), columns, squeeze=False, height_ratios=heights).flat
        drawn = []
        for panel, sheet, point in zip(panels, sheets, points, strict=False):
            said = (f"{'✓' if sheet.passes(sheet.answer.default) else '▲'} {sentence(sheet)}", verdict(sheet))
            head = [sheet.scene.title, *(fill(words, _LETTERS[size]) for words in said)]
            panel.suptitle("\n".join(head), x=0.02, ha="left", size=TEXT, color=c.ink)
            drawn.append((_panels(panel, c, sheet, point), sheet))
        figure.draw_without_rendering()
        for axes, sheet in drawn:
            _names(axes, c, sheet)

    pairs = [(s.scene.title, [" ".join(pair) for pair in s.scene.conditions]) for s in sheets]
    conditions = [f"{title}: {unbroken(words)}" for title, words in pairs]
    reasons = [f"{chart.title}: {reason(choice)}" for chart in result.charts for choice in chart.choices]
    caption = "\n".join((_KEY, *reasons, *dict.fromkeys(conditions), f"Timed on: {computer()}"))
    save(paint, path, (columns * size[0], sum(heights)), caption=caption)


def computer() -> str:
    """Name the computer on which costs are measured: its processor and how many cores it has."""
    return f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"


def draw(figure: Any, c: Colors, sheet: "Sheet", point: "Point | None" = None) -> None:
    """Draw one scene; point: its method stands out and its motion is drawn, where there is one."""
    axes = _panels(figure, c, sheet, point)
    figure.draw_without_rendering()
    _names(axes, c, sheet)


def _panels(figure: Any, c: Colors, sheet: "Sheet", point: "Point | None") -> Any:
    """Draw the chart, below it a point's motion and error over time; return the chart's axes."""
    motion = trace(point) if point else None
    grid = figure.add_gridspec(2, 2, height_ratios=_HEIGHTS) if motion else figure.add_gridspec(1, 2)
    axes = figure.add_subplot(grid[0, :])
    _points(axes, c, sheet, point.method if point else "")
    if point and motion:
        _motion(figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1]), c, point, motion)
    return axes


def _motion(path: Any, off: Any, c: Colors, point: "Point", motion: "Trace") -> None:
    """Draw the motion beside the true one, and how far it is from that."""
    color, mm = getattr(c, marker_and_color(point.method)[1]), 1e3
    path.plot(motion.t, mm * motion.true, color=c.theory, linewidth=5.0, label="true motion")
    path.plot(
        motion.t,
        mm * motion.x,
        color=color,
        linewidth=1.5,
        label=f"{point.label}, {step_words(point.step_s)}",
    )
    style_axes(path, c, "time, s", "position, mm")
    legend(path, c)
    scaled = math.isfinite(motion.scale)
    off.plot(
        motion.t,
        (100.0 / motion.scale if scaled else mm) * (motion.x - motion.true),
        color=color,
        linewidth=1.5,
    )
    off.axhline(0.0, color=c.ink2, linewidth=1.0)
    style_axes(off, c, "time, s", "error, %" if scaled else "error, mm")


def _points(axes: Any, c: Colors, sheet: "Sheet", method: str = "") -> None:
    frame = AccuracyAxes(sheet)
    frame.set_up(axes, c)
    limit = sheet.scene.tolerance * frame.factor
    axes.axhspan(frame.bottom, limit, color=c.stable, alpha=0.45, linewidth=0.0, zorder=0.5)
    axes.axhline(limit, color=c.danger, linewidth=1.8, linestyle=DASH, zorder=2.5)
    if sheet.front:  # the Pareto front, a staircase band
        places = [frame.place(point) for point in sheet.front]
        x, y = zip((places[0][0], frame.top), *places, (frame.right, places[-1][1]), strict=True)
        for color, width in ((c.edge, 9.6), (c.theory, 7.2)):
            axes.step(x, y, where="post", color=color, linewidth=width, solid_joinstyle="miter", zorder=2.0)
        axes.lines[-1].set_label("Pareto front")
    for each in sheet.methods:
        _line(axes, c, sheet, frame, each, 3.0 if each.key == method else 1.5)
    default = sheet.answer.default
    if default is not None:
        axes.plot(
            *frame.place(default), "o", markersize=21, markerfacecolor="none", markeredgecolor=c.accent,
            markeredgewidth=2.4, zorder=8,
        )  # fmt: skip
    legend(axes, c)


def _line(axes: Any, c: Colors, sheet: "Sheet", frame: AccuracyAxes, method: "Method", width: float) -> None:
    """Draw a method's points, those that compete filled, joined by a line."""
    sound = [p for p in sheet.line(method.key) if math.isfinite(p.error)]
    shape, token = marker_and_color(method.key)
    color = getattr(c, token)
    if sound:
        axes.plot(*zip(*map(frame.place, sound), strict=True), color=color, linewidth=width, zorder=3)
    if len({p.step_s for p in sound}) > 1:  # else they differ in their options, and are named one by one
        axes.plot([], [], shape, color=color, markersize=_LARGER.get(shape, _SIZE), label=method.label)
    for point in sheet.line(method.key):
        filled = abs(point.step_s - sheet.scene.default.step_s) <= 1e-9
        axes.plot(
            *frame.place(point), shape, markersize=_LARGER.get(shape, _SIZE) * (1.0 if filled else 0.85),
            markeredgecolor=color, markerfacecolor=color if filled else c.plot, markeredgewidth=1.5,
            zorder=5 if filled else 4,
        )  # fmt: skip


def _names(axes: Any, c: Colors, sheet: "Sheet") -> None:
    """Name default, options and rates beside their points, the tolerance at the edge."""
    frame, default = AccuracyAxes(sheet), sheet.answer.default
    limit = sheet.scene.tolerance * frame.factor
    found = [Label(frame.right, limit, limit_words(sheet.scene), c.danger, bold=True)]
    if default is not None:
        scene, what = sheet.scene, rate_words(default.step_s)
        what = what if scene.step_s is None else name_words(scene, default)
        found.append(Label(*frame.place(default), f"default: {what}", c.accent, bold=True))
    for method in sheet.methods:
        points = [p for p in sheet.line(method.key) if math.isfinite(p.error)]
        color = getattr(c, marker_and_color(method.key)[1])
        others = [p for p in points if p is not default]
        if len({p.step_s for p in points}) == 1:
            found += [Label(*frame.place(p), p.label, color) for p in others]
        if sheet.scene.step_s is None and method.key == sheet.scene.default.method:
            found += [Label(*frame.place(p), rate_words(p.step_s), color) for p in others]
    write_labels(axes, c, found)

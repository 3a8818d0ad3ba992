"""Speed against accuracy: error over computing time, both in powers of ten, a method a line."""

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.accuracy.words import (
    limit_words,
    name_words,
    rate_words,
    sentence,
    step_words,
    verdict,
)
from hapkit_studio.charts.accuracy_axes import Frame
from hapkit_studio.charts.labels import Label, write
from hapkit_studio.charts.methods import look
from hapkit_studio.charts.style import DASH, TEXT, Colors, save

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Accuracy, Point, Sheet

_LARGE, _SMALL = (864, 634), (547, 504)
_LETTERS = {_LARGE: 105, _SMALL: 66}
_KEY = (
    "Filled: the loop's own step.  Hollow: other steps.  Ring: the default.  Grey band: nothing is beyond it."
)
_SIZE = 8.5
_LARGER = {"*": 13.0, "p": 10.0, "P": 10.0, "X": 9.5}


def accuracy_figure(result: "Accuracy", path: str | Path) -> None:
    """Write every scene of a result: one large, or several side by side."""
    count = len(result.sheets)
    columns = 1 if count == 1 else 2 if count <= 4 else 3 if count <= 9 else 4
    rows = -(-count // columns)
    size = _LARGE if columns == 1 else _SMALL

    def paint(figure: Any, c: Colors) -> None:
        panels = [figure.add_subplot(rows, columns, i + 1) for i in range(count)]
        for axes, sheet in zip(panels, result.sheets, strict=True):
            _points(axes, c, sheet)
            axes.set_title(_head(sheet, _LETTERS[size]), loc="left", size=TEXT, color=c.ink)
        figure.draw_without_rendering()
        for axes, sheet in zip(panels, result.sheets, strict=True):
            _names(axes, c, sheet)

    save(paint, path, (columns * size[0], rows * size[1]), caption=_KEY)


def draw(figure: Any, c: Colors, sheet: "Sheet", method: str = "") -> None:
    """Draw one scene; method: the one that stands out, "" for none."""
    axes = figure.add_subplot()
    _points(axes, c, sheet, method)
    figure.draw_without_rendering()
    _names(axes, c, sheet)


def _head(sheet: "Sheet", letters: int) -> str:
    """Return title, answer with its sign, and what the default makes of it."""
    sign = "✓" if sheet.answer.right else "▲"
    return "\n".join(
        (sheet.scene.title, fill(f"{sign} {sentence(sheet)}", letters), fill(verdict(sheet), letters))
    )


def _points(axes: Any, c: Colors, sheet: "Sheet", method: str = "") -> None:
    frame = Frame(sheet)
    frame.dress(axes, c)
    limit = sheet.scene.tolerance * frame.factor
    axes.axhspan(frame.bottom, limit, color=c.stable, alpha=0.45, linewidth=0.0, zorder=0.5)
    axes.axhline(limit, color=c.danger, linewidth=1.8, linestyle=DASH, zorder=2.5)
    _front(axes, c, sheet.front, frame)
    for each in sheet.methods:
        _line(axes, c, sheet, frame, each.key, 3.0 if each.key == method else 1.5)
    default = sheet.answer.default
    if default is not None:
        axes.plot(
            *frame.place(default), "o", markersize=21, markerfacecolor="none", markeredgecolor=c.accent,
            markeredgewidth=2.4, zorder=8,
        )  # fmt: skip


def _front(axes: Any, c: Colors, front: Sequence["Point"], frame: Frame) -> None:
    """Draw the edge beyond which no point lies: a staircase as a band with kerbs."""
    if not front:
        return
    places = [frame.place(point) for point in front]
    x, y = zip((places[0][0], frame.top), *places, (frame.right, places[-1][1]), strict=True)
    for color, width in ((c.edge, 9.6), (c.theory, 7.2)):
        axes.step(x, y, where="post", color=color, linewidth=width, solid_joinstyle="miter", zorder=2.0)


def _line(axes: Any, c: Colors, sheet: "Sheet", frame: Frame, method: str, width: float) -> None:
    """Draw a method's points, those that compete filled, joined by a line."""
    sound = [p for p in sheet.line(method) if math.isfinite(p.error)]
    shape, token = look(method)
    color = getattr(c, token)
    if sound:
        axes.plot(*zip(*map(frame.place, sound), strict=True), color=color, linewidth=width, zorder=3)
    for point in sheet.line(method):
        filled = abs(point.step_s - sheet.scene.default.step_s) <= 1e-9
        axes.plot(
            *frame.place(point), shape, markersize=_LARGER.get(shape, _SIZE) * (1.0 if filled else 0.85),
            markeredgecolor=color, markerfacecolor=color if filled else c.plot, markeredgewidth=1.5,
            zorder=5 if filled else 4,
        )  # fmt: skip


def _names(axes: Any, c: Colors, sheet: "Sheet") -> None:
    """Name default, methods, options and rates beside their points, tolerance and front at the edge."""
    frame, default = Frame(sheet), sheet.answer.default
    found = [Label(frame.right, sheet.scene.tolerance * frame.factor, limit_words(sheet.scene), c.danger)]
    if sheet.front:
        found.append(Label(frame.right, frame.place(sheet.front[-1])[1], "Pareto front", c.ink3))
    if default is not None:
        found.append(Label(*frame.place(default), _default_words(sheet, default), c.accent, bold=True))
    for method in sheet.methods:
        points = [p for p in sheet.line(method.key) if math.isfinite(p.error)]
        color = getattr(c, look(method.key)[1])
        others = [p for p in points if p is not default]
        if points and len({p.step_s for p in points}) == 1:  # they differ in their options
            found += [Label(*frame.place(p), p.label, color) for p in others]
        elif points:
            last = max(points, key=lambda p: p.ns_per_simulated_s)
            found.append(Label(*frame.place(last), method.label, color))
        if sheet.scene.step_s is None and method.key == sheet.scene.default.method:
            found += [Label(*frame.place(p), rate_words(p.step_s), color, left=True) for p in others]
    write(axes, c, found)


def _default_words(sheet: "Sheet", default: "Point") -> str:
    if sheet.scene.step_s is None:
        return f"default: {rate_words(default.step_s)}"
    return f"default: {name_words(sheet.scene, default)}, {step_words(default.step_s)} step"

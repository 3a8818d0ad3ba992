"""Names in a picture of speed against accuracy: methods at their lines' ends, default, tolerance, front."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hapkit_studio.analysis.accuracy.words import limit_words, name_words, rate_words, step_words
from hapkit_studio.charts.accuracy_axes import Frame
from hapkit_studio.charts.methods import look
from hapkit_studio.charts.spreading import Name, spread
from hapkit_studio.charts.style import ACCENT, DANGER, LIGHT, QUIET, SURFACE

if TYPE_CHECKING:
    from hapkit_studio.analysis.accuracy import Point, Sheet

_SIZE = 12.0
_AWAY, _RING = 11.0, 17.0


@dataclass(frozen=True)
class _Wanted:
    """A name that a point should have: bold for the default's; on its left or right."""

    point: "Point"
    text: str
    color: str
    bold: bool = False
    left: bool = False


def write_names(axes: Any, sheet: "Sheet", frame: Frame) -> None:
    """Write every name where it overlaps no other, a thin line to what it belongs to where it moved."""
    names = [_beside(axes, frame, wanted) for wanted in _wanted(sheet)]
    box = axes.get_window_extent()
    names += _corners(axes, sheet, frame, box)
    spread(names, box.y0 + 2.0, box.y1 - 2.0)
    for name in names:
        _write(axes, name)


def _wanted(sheet: "Sheet") -> list[_Wanted]:
    """Return which points have names."""
    default = sheet.answer.default
    found = [_Wanted(default, _default_words(sheet, default), ACCENT, bold=True)] if default else []
    for method in sheet.methods:
        points = [p for p in sheet.line(method.key) if math.isfinite(p.error)]
        color = LIGHT[look(method.key)[1]]
        others = [p for p in points if p is not default]
        if points and _by_options(points):
            found += [_Wanted(p, p.label, color) for p in others]
        elif points:
            found.append(_Wanted(max(points, key=lambda p: p.ns_per_simulated_s), method.label, color))
        if sheet.scene.step_s is None and method.key == sheet.scene.default.method:
            found += [_Wanted(p, rate_words(p.step_s), color, left=True) for p in others]
    return found


def _default_words(sheet: "Sheet", default: "Point") -> str:
    if sheet.scene.step_s is None:
        return f"default: {rate_words(default.step_s)}"
    return f"default: {name_words(sheet.scene, default)}, {step_words(default.step_s)} step"


def _by_options(points: list["Point"]) -> bool:
    """Return whether a method's points differ in their options, not in their step: each has its name."""
    return len({p.step_s for p in points}) == 1


def _measure(axes: Any, text: str, bold: bool) -> tuple[float, float]:
    probe = axes.text(0.0, 0.0, text, size=_SIZE, weight="bold" if bold else "normal")
    box = probe.get_window_extent()
    probe.remove()
    return box.width, 1.12 * box.height


def _beside(axes: Any, frame: Frame, wanted: _Wanted) -> Name:
    x, y = axes.transData.transform(frame.place(wanted.point))
    width, height = _measure(axes, wanted.text, wanted.bold)
    box = axes.get_window_extent()
    away = (_RING if wanted.bold else _AWAY) * axes.figure.dpi / 72.0
    left = x - width - away if wanted.left or x + away + width > box.x1 - 4.0 else x + away
    left = min(max(left, box.x0 + 4.0), box.x1 - width - 4.0)
    return Name(wanted.text, wanted.color, left, y, width, height, (x, y), wanted.bold)


def _corners(axes: Any, sheet: "Sheet", frame: Frame, box: Any) -> list[Name]:
    """Return the names of the tolerance and of the front, at the right edge."""
    names = []
    limit = axes.transData.transform((frame.left, sheet.scene.tolerance * frame.factor))[1]
    words = limit_words(sheet.scene)
    width, height = _measure(axes, words, False)
    x = box.x1 - width - 6.0
    names.append(Name(words, DANGER, x, limit - 0.75 * height, width, height, (x, limit - 0.75 * height)))
    if sheet.front:
        y = axes.transData.transform(frame.place(sheet.front[-1]))[1]
        width, height = _measure(axes, "Pareto front", False)
        x = box.x1 - width - 6.0
        names.append(Name("Pareto front", QUIET, x, y - height, width, height, (x, y - height)))
    return names


def _write(axes: Any, name: Name) -> None:
    back = axes.transData.inverted().transform
    x, y = back((name.left, name.middle))
    if abs(name.middle - name.point[1]) > 0.6 * name.height:
        end = name.left - 2.0 if name.left > name.point[0] else name.left + name.width + 2.0
        line = [back(name.point), back((end, name.middle))]
        axes.plot(*zip(*line, strict=True), color=name.color, linewidth=0.8, alpha=0.7, zorder=2.8)
    made = axes.text(
        x, y, name.text, size=_SIZE, color=name.color, va="center", zorder=9,
        weight="bold" if name.bold else "normal",
    )  # fmt: skip
    made.set_bbox({"facecolor": SURFACE, "alpha": 0.75, "edgecolor": "none", "pad": 0.6})

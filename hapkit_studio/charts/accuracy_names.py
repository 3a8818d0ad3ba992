"""Names in a picture of speed against accuracy: methods at their lines' ends, default, tolerance, front."""

import math
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
# A line as short as this across, as a share of the frame, has a name at every point.
_UPRIGHT = 0.2


def write_names(axes: Any, sheet: "Sheet", frame: Frame) -> None:
    """Write every name where it overlaps no other, a thin line to what it belongs to where it moved."""
    made = [_beside(axes, frame, point, *words) for point, words in _wanted(sheet, frame)]
    box = axes.get_window_extent()
    names = [name for name in made if name is not None]
    fixed = _corners(axes, sheet, frame, box)
    spread([*names, *fixed], box.y0 + 2.0, box.y1 - 2.0)
    for name in [*names, *fixed]:
        _write(axes, name)


def _wanted(sheet: "Sheet", frame: Frame) -> list[tuple["Point", tuple[str, str, bool]]]:
    """Return which points have names: (text, colour, whether it is the default's)."""
    found: list[tuple[Point, tuple[str, str, bool]]] = []
    default = sheet.answer.default
    if default is not None:
        step = rate_words(default.step_s) if sheet.scene.step_s is None else step_words(default.step_s)
        words = name_words(sheet.scene, default)
        words = f"default: {step}" if sheet.scene.step_s is None else f"default: {words}, {step} step"
        found.append((default, (words, ACCENT, True)))
    for method in sheet.methods:
        points = [p for p in sheet.line(method.key) if math.isfinite(p.error)]
        color = LIGHT[look(method.key)[1]]
        if points and _upright(points, frame):
            found += [(p, (p.label, color, False)) for p in points if p is not default]
        elif points:
            found.append((max(points, key=lambda p: p.ns_per_simulated_s), (method.label, color, False)))
    return found


def _upright(points: list["Point"], frame: Frame) -> bool:
    """Return whether a line's points stand above each other."""
    costs = [frame.place(p)[0] for p in points]
    across = math.log(max(costs) / min(costs)) / math.log(frame.right / frame.left)
    return len(points) == 1 or across < _UPRIGHT


def _measure(axes: Any, text: str, bold: bool) -> tuple[float, float]:
    probe = axes.text(0.0, 0.0, text, size=_SIZE, weight="bold" if bold else "normal")
    box = probe.get_window_extent()
    probe.remove()
    return box.width, 1.12 * box.height


def _beside(axes: Any, frame: Frame, point: "Point", text: str, color: str, default: bool) -> Name | None:
    x, y = axes.transData.transform(frame.place(point))
    width, height = _measure(axes, text, default)
    box, scale = axes.get_window_extent(), axes.figure.dpi / 72.0
    left = x + (_RING if default else _AWAY) * scale
    if left + width > box.x1 - 4.0:
        left = x - width - (_RING if default else _AWAY) * scale
    return Name(text, color, left, y, width, height, (x, y), default)


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

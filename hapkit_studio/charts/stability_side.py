"""What stands beside the map: the verdict, what the lines mean, and the conditions they hold for."""

from math import isnan
from typing import Any

from hapkit_studio.analysis import plane_words
from hapkit_studio.analysis.margin import hand_words, short, way_out
from hapkit_studio.analysis.plane import Plane
from hapkit_studio.charts.style import (
    ACCENT,
    APPLIED,
    ASKED,
    DANGER,
    INK,
    INK2,
    LINE,
    OK,
    STABLE,
    SURFACE,
    UNSTABLE,
    VELOCITY,
    WARN,
    WARN_SOFT,
)

_SAMPLE = (0.0, 0.11)
_MIDDLE = (0.055,)
_TEXT = 0.16
_MOST_STEP = 0.092
_LINE, _MOST_LINE = 0.027, 0.040
# The height in inches that these shares are for, and the one that many rows need.
LOW, HIGH = 8.0, 11.5


def draw(axes: Any, plane: Plane, device: str = "") -> None:
    """Draw the right-hand column; device: its name, if the plane is one's own."""
    axes.set_axis_off()
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(0.0, 1.0)
    below = _verdict(axes, plane)
    pairs = _pairs(plane, device)
    shrunk = LOW / axes.figure.get_figheight()
    below = _legend(axes, plane, below, below - shrunk * _LINE * (len(pairs) + 1.5) - 0.045)
    axes.plot([0.0, 1.0], [below, below], color=LINE, linewidth=1.0)
    _conditions(axes, pairs, below - 0.045)


def _verdict(axes: Any, plane: Plane) -> float:
    """Write the margin, large; return the height below it."""
    margin = plane.margin
    said, hand = short(margin), hand_words(margin.hand)
    head, cut, _ = said.partition(" the limit")
    controlled = plane.setting.controller
    color = INK if controlled or isnan(margin.limit) else OK if margin.stable else DANGER
    axes.text(0.0, 0.97, head, size=26, weight="bold", color=color, va="top")
    rest = f"the limit; {hand}." if cut else f"{hand}."
    axes.text(0.0, 0.90, rest, size=14, color=INK2, va="top")
    out = "Without the controller.\nWith it only measuring can tell." if controlled else way_out(margin)
    axes.text(0.0, 0.855, out.replace(": ", ":\n"), size=14, color=color, va="top")
    return 0.80 if margin.stable and not controlled else 0.76


def height(plane: Plane) -> float:
    """Return the height in inches that the rows need."""
    return HIGH if len(_samples(plane)) > 5 else LOW


def _legend(axes: Any, plane: Plane, top: float, room: float) -> float:
    samples = _samples(plane)
    step, apart = min(_MOST_STEP, room / len(samples)), 0.034 * LOW / axes.figure.get_figheight()
    for key, style in samples:
        name, words = plane_words.line(plane, key)
        places = _SAMPLE if style.get("linestyle") != "none" else _MIDDLE
        axes.plot(places, [top - 0.016] * len(places), **style)
        axes.text(_TEXT, top, name, size=13, color=INK, va="center")
        axes.text(_TEXT, top - apart, words, size=11, color=INK2, va="center")
        top -= step
    return top + min(0.02, step - apart - 0.014)


def _samples(plane: Plane) -> list[tuple[str, dict]]:
    """Return which lines there are, and how each is drawn."""
    found: list[tuple[str, dict]] = []
    if plane.setting.linear:
        found.append(("exact", {"color": INK, "linewidth": 3}))
    if plane.points is not None:
        ring = {"marker": "o", "markersize": 8, "markerfacecolor": SURFACE, "markeredgewidth": 2}
        color = APPLIED if plane.points.controller else ACCENT
        found.append(("measured", {"color": color, "linestyle": "none", **ring}))
    found.append(("simple", {"color": ASKED, "linewidth": 2, "linestyle": (0, (1, 1.6))}))
    if plane.edge.size:
        found.append(("passive", {"color": VELOCITY, "linewidth": 2, "linestyle": "dashdot"}))
    if plane.coulomb < plane.top:
        found.append(("coulomb", {"color": WARN, "linewidth": 2, "linestyle": (0, (6, 3))}))
    if plane.cells is not None and plane.cells.real:
        square = {"marker": "s", "markersize": 13, "linestyle": "none", "markeredgecolor": LINE}
        colors = {"decays": STABLE, "buzzes": WARN_SOFT, "grows": UNSTABLE}
        found += [(key, {"color": color, **square}) for key, color in colors.items()]
    return found


def _pairs(plane: Plane, device: str) -> list[tuple[str, str]]:
    """Return the conditions and every hand's limit."""
    real = any(found is not None and found.real for found in (plane.cells, plane.points))
    limits = [
        (f"Limit, {hand_words(hand)}", f"{limit:,.0f} N/m")
        for hand, limit in plane.hands.items()
        if limit == limit
    ]
    own = [("Device", device)] if device else []
    return [*own, *plane_words.conditions(plane.setting, real), *limits]


def _conditions(axes: Any, pairs: list[tuple[str, str]], top: float) -> None:
    axes.text(0.0, top, "Conditions", size=13, weight="bold", color=INK2, va="center")
    step = min(_MOST_LINE, top / (len(pairs) + 0.5))
    for index, (name, value) in enumerate(pairs):
        height = top - step * (index + 1)
        axes.text(0.0, height, name, size=12, color=INK2, va="center")
        axes.text(1.0, height, value, size=12, color=INK, va="center", ha="right")

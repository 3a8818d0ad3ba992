"""Figure of the Z-width: stiffest rendered wall over virtual damping, with the exact linear boundary."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hapkit_studio.analysis.stability.margin import nice_top
from hapkit_studio.analysis.zwidth import HIGHEST
from hapkit_studio.charts.style import DASH, TEXT, Colors, legend, save, style_axes, unbroken

if TYPE_CHECKING:
    from hapkit_studio.analysis.zwidth.result import Point, ZWidth

_SIZE = (792, 504)
_ROOM = 1.18
# pt: width of the bar above a point, narrower than the marker
_BAND = 6.0
# smallest axis limits while points arrive, in N·s/m and N/m
_RIGHT, _TOP = 10.0, 1000.0


@dataclass(frozen=True)
class Walls:
    """The points so far with their dampings, and the linear limit (2, m).

    ``right`` and ``top`` are the smallest axis limits. ``tried`` is the wall under test.
    """

    points: "Sequence[tuple[float, Point]]" = ()
    curve: np.ndarray = field(default_factory=lambda: np.empty((2, 0)))
    right: float = _RIGHT
    top: float = _TOP
    tried: tuple[float, float] | None = None
    buzzes: bool = False

    @classmethod
    def of(cls, result: "ZWidth") -> "Walls":
        """Return the walls of a result; ``buzzes`` is set if a stiffer wall failed above every point."""
        points = list(zip(result.damping.tolist(), result.points, strict=True))
        right = max(float(result.damping[-1]), 1.0)
        sure = all(point.ended != HIGHEST for point in result.points)
        return cls(points, result.curve, right, 100.0, buzzes=sure)


def zwidth_figure(result: "ZWidth", path: str | Path) -> None:
    """Write a chart of the rendered walls, the linear limit and the conditions to a file."""
    walls = Walls.of(result)
    caption = unbroken([result.place, *(c.short_text for c in result.conditions)])
    save(lambda figure, c: draw(figure, c, walls), path, _SIZE, result.sentence, caption)


def draw(figure: Any, c: Colors, walls: Walls) -> None:
    """Draw stiffness over damping.

    A point is hollow if the force reached the limit. A bar shows the range of stiffness in which only some
    walls pass.
    """
    axes = figure.add_subplot()
    tried = walls.tried or (0.0, 0.0)
    damping, points = [b for b, _ in walls.points], [point for _, point in walls.points]
    stiffness = [point.stiffness for point in points]
    high = np.nanmax([walls.top, tried[1], *stiffness, *(p.last_held for p in points), *walls.curve[1]])
    style_axes(axes, c, "virtual damping b, N·s/m", "virtual stiffness k, N/m")
    axes.set_xlim(-0.02 * walls.right, 1.04 * walls.right)
    axes.set_ylim(0.0, nice_top(_ROOM * float(high)))
    axes.fill_between(damping, stiffness, color=c.stable, linewidth=0.0)
    axes.plot(damping, stiffness, color=c.position, linewidth=2.4, zorder=3)
    for clamped, text in (
        (False, "handle rests at all walls up to here"),
        (True, "handle rests at all walls up to here, motor at its limit"),
    ):
        if any(p.clamped == clamped for p in points):
            axes.plot(
                *zip(*((b, p.stiffness) for b, p in walls.points if p.clamped == clamped), strict=True),
                "o", color=c.position, label=text, markersize=9,
                markeredgewidth=2.0, markerfacecolor=c.plot if clamped else c.position, zorder=4,
            )  # fmt: skip
    bands = [(b, p.stiffness, p.last_held) for b, p in walls.points if p.band]
    if bands:
        text = "rests at some walls, buzzes at others"
        axes.vlines(
            *zip(*bands, strict=True), color=c.warn, linewidth=_BAND, alpha=0.6, label=text, zorder=3.5
        )
    if np.isfinite(walls.curve).any():
        text = "exact boundary without friction and sensor steps"
        axes.plot(*walls.curve, color=c.ink, linewidth=2.0, linestyle=DASH, label=text)
    if walls.tried is not None:
        axes.plot(*tried, "o", markersize=14, color="none", markeredgecolor=c.accent, markeredgewidth=2.2)
    if walls.buzzes:
        axes.text(0.02, 0.96, "buzzes", transform=axes.transAxes, size=TEXT, weight="bold", color=c.danger,
                  va="top")  # fmt: skip
    if walls.points:
        legend(axes, c)

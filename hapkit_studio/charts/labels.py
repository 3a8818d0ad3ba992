"""Words beside points of a drawing, moved up and down until none lies on another."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hapkit_studio.charts.style import TICK, Colors

_ROUNDS = 400
_AWAY, _RING = 10.0, 16.0  # points beside a point, and beside one with a ring
_LINE = 1.15  # a line's height over its letters'


@dataclass(frozen=True)
class Label:
    """Words at a point; bold: with a ring round the point; left: on that side of it."""

    x: float
    y: float
    text: str
    color: str
    bold: bool = False
    left: bool = False


def write(axes: Any, c: Colors, labels: Sequence[Label]) -> None:
    """Write labels; one that moved has a thin line to its point. The figure's layout must have been made."""
    frame = axes.get_window_extent()
    made = [_beside(axes, c, label, frame) for label in labels]
    boxes = [words.get_window_extent() for words in made]
    middles = np.array([0.5 * (box.y0 + box.y1) for box in boxes])
    heights = np.array([_LINE * box.height for box in boxes])
    sides = [(box.x0, box.x1) for box in boxes]
    points = 72.0 / axes.figure.dpi
    for words, moved, tall in zip(
        made, spread(middles, heights, sides, (frame.y0, frame.y1)) - middles, heights, strict=True
    ):
        words.xyann = (words.xyann[0], points * moved)
        if abs(moved) > 0.6 * tall:
            words.arrow_patch.set_visible(True)


def spread(
    middles: np.ndarray, heights: np.ndarray, sides: Sequence[tuple[float, float]], frame: tuple[float, float]
) -> np.ndarray:
    """Return the middles (n,) of boxes moved apart inside a frame (bottom, top); their order stays."""
    placed, order = middles.copy(), list(np.argsort(middles, kind="stable"))
    for _ in range(_ROUNDS):
        moved = False
        for place, below in enumerate(order):
            for above in order[place + 1 :]:
                lap = 0.5 * (heights[below] + heights[above]) - (placed[above] - placed[below])
                beside = sides[below][1] <= sides[above][0] or sides[above][1] <= sides[below][0]
                if lap > 0.0 and not beside:
                    placed[below] -= 0.5 * lap + 0.05
                    placed[above] += 0.5 * lap + 0.05
                    moved = True
        placed = np.clip(placed, frame[0] + 0.5 * heights, frame[1] - 0.5 * heights)
        order.sort(key=lambda index: placed[index])
        if not moved:
            break
    return placed


def _beside(axes: Any, c: Colors, label: Label, frame: Any) -> Any:
    """Write beside a point, on its other side where the frame ends."""
    away = _RING if label.bold else _AWAY
    made = axes.annotate(
        label.text, (label.x, label.y), (away, 0.0), textcoords="offset points", va="center", size=TICK,
        color=label.color, weight="bold" if label.bold else "normal", zorder=9, annotation_clip=False,
        arrowprops={"arrowstyle": "-", "color": label.color, "linewidth": 0.8, "visible": False},
        bbox={"facecolor": c.plot, "alpha": 0.75, "edgecolor": "none", "pad": 0.6},
    )  # fmt: skip
    made.set_in_layout(False)
    if label.left or made.get_window_extent().x1 > frame.x1 - 2.0:
        made.set_horizontalalignment("right")
        made.xyann = (-away, 0.0)
    return made

"""The map's lines, computed off the window's thread; what stays the same while the dot moves is kept."""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from hapkit_studio.analysis.setting import Setting
    from hapkit_studio.analysis.stability.kb_plane import Plane

# The dot may come this near to the upper or right edge before the axes change.
_EDGE = 0.95


@dataclass(frozen=True)
class Ask:
    """A setting and the rendered impedance in it; axes: width in N·s/m and top in N/m, kept if they fit."""

    setting: "Setting"
    stiffness: float
    damping: float
    axes: tuple[float, float] | None = None
    every_hand: bool = False


@dataclass(frozen=True)
class Lines:
    """The answer: a plane, and with every hand asked for each one's exact boundary (n,) in N/m."""

    question: Ask
    plane: "Plane"
    hands: dict[str, np.ndarray] = field(default_factory=dict)


def solve(ask: Ask) -> Lines:
    """Compute the lines; a dot that only moves costs its margin alone."""
    from hapkit_studio.analysis.stability.kb_plane import hands
    from hapkit_studio.analysis.stability.margin import Margin

    axes = ask.axes
    if axes and (ask.damping > _EDGE * axes[0] or ask.stiffness > _EDGE * axes[1]):
        axes = None
    if axes is None:
        axes = _axes(ask)
    limits = hands(ask.setting, ask.damping)
    hand = min(limits, key=lambda name: limits[name]) if ask.every_hand else ask.setting.hand
    margin = Margin(ask.stiffness, ask.damping, limits[hand], hand)
    plane = replace(_plane(ask.setting, *axes), margin=margin, hands=limits)
    return Lines(ask, plane, _every(ask.setting, axes[0]) if ask.every_hand else {})


def _axes(ask: Ask) -> tuple[float, float]:
    """Return round axes; with every hand shown, high enough for the firmest one's boundary."""
    from hapkit_studio.analysis.stability.axes import nice_top
    from hapkit_studio.analysis.stability.kb_plane import plane

    found = plane(ask.setting, ask.stiffness, ask.damping, columns=2)
    highest = max((float(limits.max()) for limits in _every(ask.setting, found.width).values()), default=0.0)
    return found.width, max(found.top, nice_top(1.05 * highest) if ask.every_hand else 0.0)


@lru_cache(maxsize=32)
def _plane(setting: "Setting", width: float, top: float) -> "Plane":
    from hapkit_studio.analysis.stability.kb_plane import plane

    return plane(setting, 0.0, 0.0, width=width, top=top)


@lru_cache(maxsize=8)
def _every(setting: "Setting", width: float) -> dict[str, np.ndarray]:
    from hapkit_studio.analysis.stability.kb_plane import COLUMNS, exact_boundary
    from hapkit_studio.dynamics.hand import GRIPS

    if not setting.linear:
        return {}
    across = np.linspace(0.0, width, COLUMNS)
    return {hand: exact_boundary(replace(setting, hand=hand), across) for hand in GRIPS}

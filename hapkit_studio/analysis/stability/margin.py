"""The stability margin as a number and as text, and rounded axes for a map around it.

This module imports nothing slow, because the window needs it at start.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hapkit_studio.dynamics.hand import RUBBER_BAND

RELEASED = "released"
# largest ratio of limit to stiffness that is shown as a number
FAR = 100.0
# a ratio below _NEXT_TO_ONE is shown with two decimals, above _TEN without decimals
_NEXT_TO_ONE, _TEN = 1.095, 9.95


@dataclass(frozen=True)
class Margin:
    """A rendered stiffness (N/m) and damping (N·s/m) with the stable limit (N/m) at that damping.

    ``limit`` is 0 if the damping alone is unstable, and NaN if there is no exact limit. ``hand`` is the
    grip's name. ``again`` contains further stable intervals (low, high) in N/m above the limit.
    """

    stiffness: float
    damping: float
    limit: float
    hand: str = RELEASED
    again: tuple[tuple[float, float], ...] = ()

    @property
    def stable(self) -> bool:
        """Return True if the stiffness is below the limit, or in a stable interval above the limit."""
        return (self.limit > 0.0 and self.stiffness <= self.limit) or self.island is not None

    @property
    def island(self) -> tuple[float, float] | None:
        """Return the stable interval above the limit that contains the stiffness; None if none does."""
        return next((ends for ends in self.again if ends[0] < self.stiffness <= ends[1]), None)

    @property
    def ratio(self) -> float:
        """Return the ratio of limit to stiffness; it is infinite for a stiffness of 0."""
        return self.limit / self.stiffness if self.stiffness > 0.0 else math.inf


def hand_text(hand: str) -> str:
    """Describe the hand: "no hand", "rubber band", or the grip's name as in "medium grip"."""
    if hand == RUBBER_BAND:
        return hand
    return "no hand" if hand == RELEASED else f"{hand} grip"


def times(ratio: float) -> str:
    """Format a ratio of 1 or more: with two decimals near 1, none from 10 on, otherwise one."""
    return f"{ratio:.{2 if ratio < _NEXT_TO_ONE else 1 if ratio < _TEN else 0}f} ×"


def factor(ratio: float) -> str:
    """Format the factor from the stiffness to the limit: "× 1.4" below the limit, "÷ 1.3" above it."""
    return f"× {times(ratio)[:-2]}" if ratio >= 1.0 else f"÷ {times(1.0 / ratio)[:-2]}"


def short(margin: Margin) -> str:
    """Return the margin as text, such as "Stiffness 1.4 × below the limit"."""
    if math.isnan(margin.limit):
        return "No exact limit"
    if margin.island:
        return f"Stable from {span(margin.island)}"
    if margin.limit <= 0.0:
        return "Damping above the limit"
    if margin.stiffness <= 0.0:
        return f"Stable ({hand_text(margin.hand)})"
    if not margin.stable:
        return f"Stiffness {times(1.0 / margin.ratio)} above the limit"
    return f"Stiffness {times(margin.ratio) if margin.ratio < FAR else 'far'} below the limit"


def span(ends: tuple[float, float]) -> str:
    """Format a stiffness interval, as in "341 to 1,562 N/m"."""
    return f"{ends[0]:,.0f} to {ends[1]:,.0f} N/m"


def stable_again(margin: Margin) -> str:
    """Return a sentence on the stable intervals above the limit; "" without such intervals."""
    others = [span(ends) for ends in margin.again if ends != margin.island]
    return f"Stable {'again' if margin.limit else 'only'} from {' and from '.join(others)}." if others else ""


def remedy(margin: Margin) -> str:
    """Return the remedy for an unstable impedance; "" if the impedance is stable."""
    if math.isnan(margin.limit):
        return "The velocity filter is not linear, so only a measurement can find the limit."
    if margin.limit <= 0.0 and not margin.island:
        return "Lower the damping."
    return "" if margin.stable else f"Lower the stiffness below {margin.limit:,.0f} N/m."


def sentence(margin: Margin) -> str:
    """Return margin, hand and remedy as text, such as "Stiffness 1.4 × below the limit (no hand)."."""
    summary = short(margin)
    hand = f"({hand_text(margin.hand)})"
    whole = f"{summary}." if summary.endswith(hand) else f"{summary} {hand}."
    return " ".join(part for part in (whole, remedy(margin), stable_again(margin)) if part)


_ROUND = (1, 1.5, 2, 3, 4, 5, 8, 10)
WIDTHS = (1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_SHARE = 0.7
# the boundary must cross the upper edge within this fraction of the width
_LEAVES = 0.6
_LOOKS = 31
# Height of the axes as a multiple of the limit at the rendered damping; multiple up to which the axes are
# extended to show a peak of the boundary.
_OVER, _WHOLE = 1.5, 2.2


def nice_top(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 4, 5, 8 × 10ⁿ at or above a value."""
    if value <= 0.0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in _ROUND if m * power >= value * (1 - 1e-9))


def nice_width(damping: float, least: float = WIDTHS[0]) -> float:
    """Return a rounded width in N·s/m of at least ``least``, with room to the right of a damping."""
    return next((w for w in WIDTHS if w >= least and damping <= _SHARE * w), nice_top(damping / _SHARE))


def height(stiffness: float, limit: float, highest: float) -> float:
    """Return a rounded height in N/m with room above dot and limit; a low boundary is shown completely."""
    limit = limit if math.isfinite(limit) else 0.0
    around = max(_OVER * limit, 1.4 * stiffness, 1.0)
    whole = 1.1 * highest
    seen = whole if 0.0 < whole <= max(_WHOLE * limit, around) else around
    return nice_top(max(seen, 1.1 * stiffness, 1.0))


def round_axes(
    boundary: Callable[[np.ndarray], np.ndarray], stiffness: float, damping: float, limit: float
) -> tuple[float, float]:
    """Return rounded width in N·s/m and height in N/m around a dot and the limit in N/m at its damping.

    ``boundary`` returns the limits (n,) at dampings (n,). The width is the smallest one at which the
    boundary turns down or crosses the upper edge.
    """
    wide = nice_width(damping)
    top = height(stiffness, limit, math.inf)
    for wide in (w for w in WIDTHS if w >= nice_width(damping)):
        across = np.linspace(0.0, wide, _LOOKS)
        limits = boundary(across)
        top = height(stiffness, limit, float(limits.max()))
        leaves = (limits > top) & (across <= _LEAVES * wide)
        if leaves.any() or int(limits.argmax()) < _LOOKS - 1:
            break
    return wide, top

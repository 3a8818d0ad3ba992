"""How far from instability, as a number and in words, and round ends for the axes of a map of it.

The one place that says it; loads at once, the window starts with it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

RELEASED = "released"
# Beyond this many times nobody asks how far.
FAR = 100.0
# Below this, one decimal would hide on which side of 1 a ratio is.
_NEXT_TO_ONE, _TEN = 1.095, 9.95


@dataclass(frozen=True)
class Margin:
    """A rendered stiffness (N/m) and damping (N·s/m) beside the stable limit (N/m) at that damping.

    limit: 0 where the damping alone is unstable, nan where there is no exact one. hand: the grip's name.
    again: intervals (low, high) in N/m above the limit that are stable, too.
    """

    stiffness: float
    damping: float
    limit: float
    hand: str = RELEASED
    again: tuple[tuple[float, float], ...] = ()

    @property
    def stable(self) -> bool:
        """Say whether the rendered impedance is inside the limit, or stable again above it."""
        return (self.limit > 0.0 and self.stiffness <= self.limit) or self.island is not None

    @property
    def island(self) -> tuple[float, float] | None:
        """Return the interval above the limit that the stiffness lies in, None where in none."""
        return next((ends for ends in self.again if ends[0] < self.stiffness <= ends[1]), None)

    @property
    def ratio(self) -> float:
        """Return limit over stiffness; infinite without stiffness."""
        return self.limit / self.stiffness if self.stiffness > 0.0 else math.inf


def hand_words(hand: str) -> str:
    """Name the hand: "let go", "medium grip"."""
    return "let go" if hand == RELEASED else f"{hand} grip"


def times(ratio: float) -> str:
    """Write a ratio of 1 or more: one decimal, two where it is next to 1, none from 10 on."""
    return f"{ratio:.{2 if ratio < _NEXT_TO_ONE else 1 if ratio < _TEN else 0}f} ×"


def factor(ratio: float) -> str:
    """Write the way from the stiffness to the limit: "× 1.4", "÷ 1.3" from beyond it."""
    return f"× {times(ratio)[:-2]}" if ratio >= 1.0 else f"÷ {times(1.0 / ratio)[:-2]}"


def short(margin: Margin) -> str:
    """Return the margin in a few words: "1.4 × below the limit"."""
    if math.isnan(margin.limit):
        return "No exact limit"
    if margin.island:
        return f"Stable from {span(margin.island)}"
    if margin.limit <= 0.0:
        return "Above the damping limit"
    if margin.stiffness <= 0.0:
        return f"Stable, {hand_words(margin.hand)}"
    if not margin.stable:
        return f"{times(1.0 / margin.ratio)} above the limit"
    return f"{times(margin.ratio)} below the limit" if margin.ratio < FAR else "Over 100 × below the limit"


def span(ends: tuple[float, float]) -> str:
    """Write an interval of stiffness: "341 to 1,562 N/m"."""
    return f"{ends[0]:,.0f} to {ends[1]:,.0f} N/m"


def stable_again(margin: Margin) -> str:
    """Return in a sentence which other stiffnesses above the limit are stable, too; nothing where none is."""
    others = [span(ends) for ends in margin.again if ends != margin.island]
    return f"Stable {'again' if margin.limit else 'only'} from {' and from '.join(others)}." if others else ""


def remedy(margin: Margin) -> str:
    """Return what to do about an unstable impedance; nothing where it is stable."""
    if math.isnan(margin.limit):
        return "The velocity filter is not linear: only a run can tell."
    if margin.limit <= 0.0 and not margin.island:
        return "Lower damping."
    return "" if margin.stable else f"Lower stiffness below {margin.limit:,.0f} N/m."


def sentence(margin: Margin) -> str:
    """Return the margin, the hand, and what to do: "1.4 × below the limit; let go."."""
    said = short(margin)
    hand = hand_words(margin.hand)
    whole = f"{said}." if said.endswith(hand) else f"{said}; {hand}."
    return " ".join(part for part in (whole, remedy(margin), stable_again(margin)) if part)


_ROUND = (1, 1.5, 2, 3, 4, 5, 8, 10)
WIDTHS = (1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_SHARE = 0.7
# The boundary leaves through the upper edge within this share of the width.
_LEAVES = 0.6
_LOOKS = 31
# The height as a multiple of the limit at the dot; and at most, to show a boundary's highest point.
_OVER, _WHOLE = 1.5, 2.2


def nice_top(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 4, 5, 8 × 10ⁿ at or above a value."""
    if value <= 0.0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in _ROUND if m * power >= value * (1 - 1e-9))


def nice_width(damping: float, least: float = WIDTHS[0]) -> float:
    """Return a round width in N·s/m, at least so much, in which a damping stands clear of the right edge."""
    return next((w for w in WIDTHS if w >= least and damping <= _SHARE * w), nice_top(damping / _SHARE))


def height(stiffness: float, limit: float, highest: float) -> float:
    """Return a round height in N/m: room above dot and limit, the whole boundary if that is low."""
    limit = limit if math.isfinite(limit) else 0.0
    around = max(_OVER * limit, 1.4 * stiffness, 1.0)
    whole = 1.1 * highest
    seen = whole if 0.0 < whole <= max(_WHOLE * limit, around) else around
    return nice_top(max(seen, 1.1 * stiffness, 1.0))


def round_axes(
    boundary: Callable[[np.ndarray], np.ndarray], stiffness: float, damping: float, limit: float
) -> tuple[float, float]:
    """Return a round width in N·s/m and height in N/m around a dot and the limit at its damping, N/m.

    boundary gives the limits (n,) at dampings (n,): the narrowest width is taken in which it is seen to turn
    down, or to leave through the upper edge.
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

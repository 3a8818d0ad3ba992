"""How far from instability, as a number and in words: the one place that says it."""

import math
from dataclasses import dataclass

# Beyond this many times nobody asks how far.
_FAR = 100.0
# Below this, one decimal would hide on which side of 1 a ratio is.
_NEXT_TO_ONE = 1.095


@dataclass(frozen=True)
class Margin:
    """A rendered stiffness (N/m) and damping (N·s/m) beside the stable limit (N/m) at that damping.

    limit: 0 where the damping alone is unstable, nan where there is no exact one. hand: the grip's name.
    """

    stiffness: float
    damping: float
    limit: float
    hand: str = "released"

    @property
    def stable(self) -> bool:
        """Say whether the rendered impedance is inside the limit."""
        return self.limit > 0.0 and self.stiffness <= self.limit

    @property
    def ratio(self) -> float:
        """Return limit over stiffness; infinite without stiffness."""
        return self.limit / self.stiffness if self.stiffness > 0.0 else math.inf


def hand_words(hand: str) -> str:
    """Name the hand: "released hand", "medium grip"."""
    return "released hand" if hand == "released" else f"{hand} grip"


def times(ratio: float) -> str:
    """Write a ratio of 1 or more: one decimal, two where it is next to 1."""
    return f"{ratio:.{2 if ratio < _NEXT_TO_ONE else 1}f} ×"


def factor(ratio: float) -> str:
    """Write the way from the stiffness to the limit: "× 1.4", "÷ 1.3" from beyond it."""
    return f"× {times(ratio)[:-2]}" if ratio >= 1.0 else f"÷ {times(1.0 / ratio)[:-2]}"


def short(margin: Margin) -> str:
    """Return the margin in a few words: "1.4 × below the limit"."""
    if math.isnan(margin.limit):
        return "No exact limit"
    if margin.limit <= 0.0:
        return "Above the damping limit"
    if margin.stiffness <= 0.0:
        return f"Stable, {hand_words(margin.hand)}"
    if not margin.stable:
        return f"{times(1.0 / margin.ratio)} above the limit"
    return f"{times(margin.ratio)} below the limit" if margin.ratio < _FAR else "Over 100 × below the limit"


def way_out(margin: Margin) -> str:
    """Return what to do about an unstable impedance; nothing where it is stable."""
    if math.isnan(margin.limit):
        return "The velocity filter is not linear: only a run can tell."
    if margin.limit <= 0.0:
        return "Lower damping."
    return "" if margin.stable else f"Lower stiffness below {margin.limit:,.0f} N/m."


def verdict(margin: Margin) -> str:
    """Return the margin in one line, the way out included where there is one."""
    out = way_out(margin)
    return f"{short(margin)}. {out}" if out else short(margin)


def sentence(margin: Margin) -> str:
    """Return the margin and the hand: "1.4 × below the limit; released hand."."""
    said = short(margin)
    hand = hand_words(margin.hand)
    whole = f"{said}." if said.endswith(hand) else f"{said}; {hand}."
    return f"{whole} {way_out(margin)}".rstrip()

"""The verdict on a scene: behaviour of the handle held and released, margins, and sentences on both."""

import math
from dataclasses import dataclass

from hapkit_studio.analysis.stability.behaviour import Behaviour
from hapkit_studio.analysis.stability.margin import FAR, RELEASED, Margin, span, times


@dataclass(frozen=True)
class Verdict:
    """Behaviour of the handle and margins by grip name: first in the hand, last released.

    unknown: why there is no limit, "" if there is one. pushes: the scene only pushes the handle out, and
    limits assume a handle fixed to its spring. joint: the limits are those of handle and object together.
    """

    does: dict[str, Behaviour]
    margins: dict[str, Margin]
    unknown: str = ""
    pushes: bool = False
    joint: bool = False

    @property
    def not_judged(self) -> str:
        """Return why the handle was not judged, in sentences; "" if it was."""
        return next((one.unknown for one in self.does.values() if one.unknown), "")

    @property
    def calm(self) -> bool:
        """Return True if the handle settles from any push, held and released."""
        return all(one.calm for one in self.does.values())

    @property
    def sign(self) -> tuple[str, str]:
        """Return icon and colour of the worst behaviour."""
        return min(self.does.values(), key=lambda one: one.push).sign

    @property
    def limit(self) -> float | None:
        """Return the linear limit in N/m of a released handle, None if unknown or without one."""
        margin = self.margins.get(RELEASED)
        return margin.limit if margin and math.isfinite(margin.limit) else None

    @property
    def headline(self) -> str:
        """Return a word or two: "Calm", "Buzzes when let go"."""
        if self.not_judged:
            return "Not judged"
        lively = [hand for hand, one in self.does.items() if not one.calm]
        if not lively:
            return "Calm"
        return "Buzzes when let go" if lively == [RELEASED] else "Buzzes in your hand"

    @property
    def lines(self) -> tuple[str, ...]:
        """Return a line per hand: "In your hand: calm, 1.8 × below the limit.", …"""
        return tuple(words for words, *_ in self.signed)

    @property
    def signed(self) -> tuple[tuple[str, str, str], ...]:
        """Return each line with its icon and colour."""
        return tuple((f"{_name(hand)}: {self._line(hand)}.", *one.sign) for hand, one in self.does.items())

    @property
    def short(self) -> str:
        """Return the worst behaviour: "Let go: settles below 0.9 mm, buzzes above", or the margin."""
        hand, worst = min(self.does.items(), key=lambda item: item[1].push)
        if not worst.calm:
            return f"{_name(hand)}: {worst.words}"
        hand = min(self.margins, key=lambda name: self.margins[name].ratio, default=RELEASED)
        said = self._line(hand)
        return said[0].upper() + said[1:]

    @property
    def swings(self) -> str:
        """Return the oscillations: "Let go ±2.3 mm at 30 Hz."; "" if it settles."""
        found = [f"{_name(hand)} {one.swing}" for hand, one in self.does.items() if one.swing]
        return f"{'. '.join(found)}." if found else ""

    @property
    def holds_for(self) -> str:
        """Return a sentence on what the limits apply to, "" if to the scene itself."""
        if not self.margins:
            return ""
        if self.joint:
            return "Limits are those of handle and object pressed together; the stability map is a wall's."
        return "Limits and map are those of a handle fixed to the spring." if self.pushes else ""

    def _line(self, hand: str) -> str:
        """Return the behaviour in a hand, with the margin if it is calm."""
        one, margin = self.does[hand], self.margins.get(hand)
        if not one.calm or margin is None or margin.stiffness <= 0.0:
            return one.words
        if not margin.stable:
            if self.pushes and hand == RELEASED:
                return f"{one.words}, only pushed out"
            none = "any stiffness is above" if self.joint else "damping is above"
            above = f"{times(1.0 / margin.ratio)} above" if margin.limit > 0.0 else none
            but = " while nothing presses it," if self.joint and hand == RELEASED else ", although"
            return f"{one.words}{but} {above} the limit"
        if margin.island:
            return f"{one.words}, stable again from {span(margin.island)}"
        return f"{one.words}, {times(margin.ratio) if margin.ratio < FAR else 'over 100 ×'} below the limit"


def _name(hand: str) -> str:
    return "Let go" if hand == RELEASED else "In your hand"

"""The verdict on a scene: what the handle does held and released, its margins, and the sentences for both."""

import math
from dataclasses import dataclass

from hapkit_studio.analysis.stability.behaviour import Behaviour
from hapkit_studio.analysis.stability.margin import FAR, RELEASED, Margin, span, times


@dataclass(frozen=True)
class Verdict:
    """What the handle does and how far the limit is, by the grip's name: first in the hand, last let go.

    unknown: why no limit can be named, "" where there is one. pushes: the scene only pushes the handle out of
    itself, and a limit is that of a handle fixed to its spring. joint: the limits are those of handle and
    object together.
    """

    does: dict[str, Behaviour]
    margins: dict[str, Margin]
    unknown: str = ""
    pushes: bool = False
    joint: bool = False

    @property
    def not_judged(self) -> str:
        """Return in sentences why the handle was not judged, "" where it was."""
        return next((one.unknown for one in self.does.values() if one.unknown), "")

    @property
    def calm(self) -> bool:
        """Say whether the handle settles from any push, held and let go."""
        return all(one.calm for one in self.does.values())

    @property
    def sign(self) -> tuple[str, str]:
        """Return icon and colour of the worst."""
        return min(self.does.values(), key=lambda one: one.push).sign

    @property
    def limit(self) -> float | None:
        """Return the linear limit in N/m of a released handle, None where none is known, or there is none."""
        margin = self.margins.get(RELEASED)
        return margin.limit if margin and math.isfinite(margin.limit) else None

    @property
    def headline(self) -> str:
        """Return it in a word or two: "Calm", "Buzzes when let go"."""
        if self.not_judged:
            return "Not judged"
        lively = [hand for hand, one in self.does.items() if not one.calm]
        if not lively:
            return "Calm"
        return "Buzzes when let go" if lively == [RELEASED] else "Buzzes in your hand"

    @property
    def lines(self) -> tuple[str, ...]:
        """Return a line a hand: "In your hand: calm, 1.8 × below the limit.", …"""
        return tuple(words for words, *_ in self.signed)

    @property
    def signed(self) -> tuple[tuple[str, str, str], ...]:
        """Return each of the lines with its own icon and colour."""
        return tuple((f"{_name(hand)}: {self._said(hand)}.", *one.sign) for hand, one in self.does.items())

    @property
    def short(self) -> str:
        """Return the worst in a few words: "Let go: settles below 0.9 mm, buzzes above", or the margin."""
        hand, worst = min(self.does.items(), key=lambda item: item[1].push)
        if not worst.calm:
            return f"{_name(hand)}: {worst.words}"
        hand = min(self.margins, key=lambda name: self.margins[name].ratio, default=RELEASED)
        said = self._said(hand)
        return said[0].upper() + said[1:]

    @property
    def swings(self) -> str:
        """Return how the handle swings where it does: "Let go ±2.3 mm at 30 Hz."; "" where it settles."""
        found = [f"{_name(hand)} {one.swing}" for hand, one in self.does.items() if one.swing]
        return f"{'. '.join(found)}." if found else ""

    @property
    def holds_for(self) -> str:
        """Return in a sentence whose limits they are where that is not the scene itself, "" where it is."""
        if not self.margins:
            return ""
        if self.joint:
            return "Limits are those of handle and object pressed together; the stability map is a wall's."
        return "Limits and map are those of a handle fixed to the spring." if self.pushes else ""

    def _said(self, hand: str) -> str:
        """Return what the handle does in a hand, and how far from the linear limit where it is calm."""
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

"""The verdict on a scene: behaviour of the handle when held and released, margins, and sentences on both."""

import math
from dataclasses import dataclass

from hapkit_studio.analysis.stability.behaviour import Behaviour
from hapkit_studio.analysis.stability.margin import FAR, RELEASED, Margin, span, times


@dataclass(frozen=True)
class Verdict:
    """Behaviour of the handle and margins, by grip name; the last entry is the released handle.

    ``unknown`` is the reason why no limit is known, "" if a limit is known. ``pushes`` is True if the scene
    only pushes (a wall), so that its limits are valid while a hand presses the handle into it. ``joint`` is
    True if the limits are those of handle and object pressed together.
    """

    does: dict[str, Behaviour]
    margins: dict[str, Margin]
    unknown: str = ""
    pushes: bool = False
    joint: bool = False

    @property
    def not_judged(self) -> str:
        """Return the reason in sentences why the handle was not judged; "" if it was judged."""
        return next((one.unknown for one in self.does.values() if one.unknown), "")

    @property
    def calm(self) -> bool:
        """Return True if the handle settles from every push, held and released."""
        return all(one.calm for one in self.does.values())

    @property
    def sign(self) -> tuple[str, str]:
        """Return icon and colour of the worst behaviour."""
        return min(self.does.values(), key=lambda one: one.push).sign

    @property
    def limit(self) -> float | None:
        """Return the linear limit of a released handle in N/m; None if the limit is unknown or infinite."""
        margin = self.margins.get(RELEASED)
        return margin.limit if margin and math.isfinite(margin.limit) else None

    @property
    def worst(self) -> str:
        """Return the hand that decides the verdict: the least stable one, or the one nearest to its limit."""
        if not self.calm:
            return min(self.does, key=lambda hand: self.does[hand].push)
        # a released handle moves away from a wall, and no longer presses an object
        apart = RELEASED if self.pushes or self.joint else ""
        pressed = {hand: margin.ratio for hand, margin in self.margins.items() if hand != apart}
        return min(pressed or self.does, key=lambda hand: pressed.get(hand, math.inf))

    @property
    def headline(self) -> str:
        """Return the verdict in a few words, such as "Stable" or "Buzzes if you let go"."""
        if self.not_judged:
            return "Not judged"
        if self.calm:
            return "Stable"
        one = self.does[self.worst]
        if one.spontaneous:
            return "Buzzes by itself" if one.most else "Flies away by itself"
        does = "buzzes" if one.most else "flies away"
        if self.worst == RELEASED and all(
            other.calm for hand, other in self.does.items() if hand != RELEASED
        ):
            return f"{does.capitalize()} if you let go"
        return "Buzzes after a push" if one.most else "Flies away after a push"

    @property
    def lines(self) -> tuple[str, ...]:
        """Return a sentence for each hand, such as "In your hand, the handle is stable."."""
        return tuple(text for text, *_ in self.signed)

    @property
    def signed(self) -> tuple[tuple[str, str, str], ...]:
        """Return each of the lines with its icon and colour."""
        return tuple((self._sentence(hand), *one.sign) for hand, one in self.does.items())

    @property
    def short(self) -> str:
        """Return the verdict for the status bar, such as "Buzzes after a push"."""
        margin = self.margins.get(self.worst)
        if not self.calm or margin is None or margin.stiffness <= 0.0:
            return self.headline
        if margin.stable:
            return f"Stable, {_below(margin)}"
        return "Stable, thanks to friction"

    @property
    def reason(self) -> str:
        """Return a sentence that states why the handle does not settle, or which limit is the nearest."""
        margin = self.margins.get(self.worst)
        if margin is None or (margin.stiffness <= 0.0 < margin.limit):
            return ""
        whose = _WHOSE[self.worst == RELEASED]
        if margin.limit <= 0.0 and not margin.island:
            return (
                "Reason: "
                f"{'even the softest contact is too stiff' if self.joint else 'the damping is too high'} "
                f"{whose}."
            )
        limit = f"{margin.limit:,.0f} N/m {whose}"
        if self.calm:
            return f"Limit without friction: {limit}."
        if not margin.stable:
            return f"Reason: {margin.stiffness:,.0f} N/m is above the limit of {limit}."
        return f"Reason: the sensor's steps. Without them, the limit is {limit}."

    def _sentence(self, hand: str) -> str:
        """Describe the behaviour in a hand and, if it is stable, the distance from the linear limit."""
        one, margin = self.does[hand], self.margins.get(hand)
        in_hand = hand != RELEASED
        if self.not_judged:
            return f"{'In your hand' if in_hand else 'After you let go'}, the stability is not judged."
        if not one.calm:
            return one.sentence(in_hand)
        if not in_hand and self.pushes:
            return "After you let go, the handle moves away and cannot buzz."
        text = one.sentence(in_hand).removesuffix(".")
        if margin is None or margin.stiffness <= 0.0:
            return f"{text}."
        if self.joint and not in_hand and not margin.stable:
            return f"{text}: nothing presses the handle onto the object."
        if margin.island:
            return f"{text}: stable again from {span(margin.island)}."
        if margin.stable:
            return f"{text}, {_below(margin)}."
        if margin.limit <= 0.0:
            return f"{text}: friction stops every motion, although the damping is above the limit."
        return (
            f"{text}: friction stops every motion, although the stiffness is {times(1.0 / margin.ratio)} "
            "above the limit."
        )


_WHOSE = ("in your hand", "after you let go")


def _below(margin: Margin) -> str:
    return f"{times(margin.ratio) if margin.ratio < FAR else 'far'} below the limit"

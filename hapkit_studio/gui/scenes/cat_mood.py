"""What the cat's state looks like: how it holds ears, eyes, tail and paw, and the word for it."""

import math
from dataclasses import dataclass

from hapkit_studio.environments.cat import ENVIRONMENT, PURRS_ABOVE, SWAT_TIME, SWATS_BELOW
from hapkit_studio.gui.scenes.actors import Motion
from hapkit_studio.gui.scenes.parts import read as number

BREATH = 0.012  # of the body's height, either way
_CONTENT = 0.1
_FULL_BEND = 3.0  # mm: hairs bent by this are drawn bent as far as they go


def between(value: float, low: float, high: float) -> float:
    """Return 0..1: where value lies from low to high, which may lie below low."""
    return min(1.0, max(0.0, (value - low) / (high - low)))


@dataclass(frozen=True)
class Mood:
    """Contentment −1..1, breath rad, seconds left of swat and sulk, the swat's direction, bent hair −1..1."""

    contentment: float = 0.0
    breath: float = 0.0
    swat: float = 0.0
    sulk: float = 0.0
    push: float = 1.0
    bend: float = 0.0

    @property
    def word(self) -> str:
        if self.swat > 0.0:
            return "swat"
        if self.sulk > 0.0:
            return "sulking"
        if self.purrs:
            return "purring"
        if self.contentment < -_CONTENT:
            return "annoyed"
        return "content" if self.contentment > _CONTENT else "at rest"

    @property
    def purrs(self) -> bool:
        return self.contentment > PURRS_ABOVE

    @property
    def cross(self) -> bool:
        """Say whether it swats or sulks."""
        return self.swat > 0.0 or self.sulk > 0.0

    @property
    def anger(self) -> float:
        """Return 0..1: nothing yet down to −0.1, all of it where it would swat."""
        return 1.0 if self.swat > 0.0 else between(self.contentment, -_CONTENT, SWATS_BELOW)

    @property
    def ears(self) -> float:
        """Return 0..1: upright, turned back below the mood it swats in."""
        return 1.0 if self.cross else between(self.contentment, -0.35, SWATS_BELOW)

    @property
    def eyes(self) -> float:
        """Return 0..1.15: how far the eyes are open; they fall shut until it purrs."""
        if self.swat > 0.0:
            return 1.15
        if self.sulk > 0.0:
            return 0.5
        if self.purrs:
            return 0.0
        return 0.62 + 0.38 * self.anger - 1.6 * max(0.0, self.contentment)

    @property
    def reach(self) -> float:
        """Return 0..1: how far the paw is out."""
        return math.sin(math.pi * min(1.0, self.swat / SWAT_TIME)) if self.swat > 0.0 else 0.0

    @property
    def chest(self) -> float:
        """Return the body's height as a share of its mean: full as the breath begins to go out."""
        return 1.0 + BREATH * math.cos(self.breath)

    @property
    def tail(self) -> float:
        """Return −1..1: slow with the breath, three times as fast and far in anger."""
        calm, lash = math.sin(self.breath), math.sin(3.0 * self.breath)
        return (0.22 + 0.12 * self.contentment) * calm * (1.0 - self.anger) + self.anger * lash


def read(motion: Motion) -> Mood:
    """Return the mood in the newest row."""
    state = {name: number(motion, ENVIRONMENT.state_names, name) for name in ENVIRONMENT.state_names}
    bent = (motion.position - 1e3 * state["anchor"]) / _FULL_BEND if state["started"] else 0.0
    return Mood(
        min(1.0, max(-1.0, state["contentment"])),
        state["breath"],
        state["swat"],
        state["sulk"],
        math.copysign(1.0, state["push"] or 1.0),
        min(1.0, max(-1.0, bent)),
    )

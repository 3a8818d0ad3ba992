"""Names beside their points, moved up and down until none lies on another."""

from collections.abc import Sequence
from dataclasses import dataclass

_ROUNDS = 400


@dataclass
class Name:
    """A name's box in points of the picture: its left end and middle, its size, and what it belongs to."""

    text: str
    color: str
    left: float
    middle: float
    width: float
    height: float
    point: tuple[float, float]
    bold: bool = False

    def meets(self, other: "Name") -> bool:
        """Return whether two boxes overlap."""
        beside = self.left + self.width <= other.left or other.left + other.width <= self.left
        return not beside and abs(self.middle - other.middle) < 0.5 * (self.height + other.height)


def spread(names: Sequence[Name], bottom: float, top: float) -> None:
    """Move names that overlap apart, within the frame's height; the order from top to bottom stays."""
    ordered = sorted(names, key=lambda name: name.middle)
    for _ in range(_ROUNDS):
        moved = False
        for i, below in enumerate(ordered):
            for above in ordered[i + 1 :]:
                if below.meets(above):
                    lap = 0.5 * (below.height + above.height) - (above.middle - below.middle)
                    below.middle -= 0.5 * lap + 0.05
                    above.middle += 0.5 * lap + 0.05
                    moved = True
        for name in ordered:
            low, high = bottom + 0.5 * name.height, top - 0.5 * name.height
            name.middle = min(max(name.middle, low), high)
        ordered.sort(key=lambda name: name.middle)
        if not moved:
            return

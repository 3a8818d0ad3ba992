"""Points of a chart of speed against accuracy, and which of them nothing beats."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Point:
    """One method at one step in one scene: its error, and the ns of computing a simulated second.

    label names the method with its options. extra: what only some charts measure.
    """

    chart: str
    scene: str
    method: str
    step_s: float
    error: float
    ns_per_simulated_s: float
    pareto: bool = False
    label: str = ""
    options: tuple[tuple[str, float], ...] = ()
    extra: tuple[tuple[str, float], ...] = ()

    def row(self) -> dict[str, object]:
        """Return what a program reads; an error that is no number, or endless, is None."""
        return {
            "chart": self.chart,
            "scene": self.scene,
            "method": self.method,
            "step_s": self.step_s,
            "error": self.error if math.isfinite(self.error) else None,
            "ns_per_simulated_s": self.ns_per_simulated_s,
            "pareto": self.pareto,
            **({"options": dict(self.options)} if self.options else {}),
            **{key: value if math.isfinite(value) else None for key, value in self.extra},
        }


def beats(one: Point, other: Point) -> bool:
    """Return whether one is no worse in error and cost, and better in either."""
    no_worse = one.error <= other.error and one.ns_per_simulated_s <= other.ns_per_simulated_s
    return no_worse and (one.error < other.error or one.ns_per_simulated_s < other.ns_per_simulated_s)


def mark_front(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points, those marked that no other beats: the Pareto front.

    Equal points are in it together; one whose error is no number, or endless, never is.
    """
    front: set[tuple[float, float]] = set()
    least = math.inf
    sound = {(p.ns_per_simulated_s, p.error) for p in points if math.isfinite(p.error)}
    for cost, error in sorted(sound):
        if error < least:
            front.add((cost, error))
            least = error
    return tuple(replace(p, pareto=(p.ns_per_simulated_s, p.error) in front) for p in points)

"""The search for the stiffest wall: up by a factor to the first that fails, then by halves between."""

from collections.abc import Callable
from dataclasses import dataclass

from hapkit_studio.analysis.zwidth_result import HIGHEST


@dataclass(frozen=True)
class Verdict:
    """One trial's outcome: why it failed, "" where the wall held; whether the motor's limit was reached."""

    why: str
    clamped: bool = False


@dataclass(frozen=True)
class Point:
    """The stiffest wall in N/m that held, why the next fails, whether it needed the motor's limit."""

    stiffness: float
    ended: str
    clamped: bool


def stiffest(
    held: Callable[[float], Verdict], softest: float, raised: float, highest: float, halvings: int
) -> Point:
    """Return the stiffest wall between the last that held and the first that failed; 0 where none held.

    No trial is stiffer than the first that fails, nor than the highest.
    """
    low, high = Point(0.0, HIGHEST, False), softest
    while not (verdict := held(high)).why:
        low = Point(high, HIGHEST, verdict.clamped)
        if high >= highest:
            return low
        high = min(high * raised, highest)
    why = verdict.why
    for _ in range(halvings):
        middle = 0.5 * (low.stiffness + high)
        verdict = held(middle)
        if verdict.why:
            high, why = middle, verdict.why
        else:
            low = Point(middle, why, verdict.clamped)
    return Point(low.stiffness, why, low.clamped)

"""Does a push to the right move the handle to the right? A wrong sign is a spring that runs away."""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.calibrate.verdict import Verdict, look, passed
from hapkit_studio.devices.calibration import Track

MOVED = 0.3e-3
"""m from which a handle counts as moved."""


TOGETHER = 9
"""Samples of a pulse that are taken together: a noisy reading is no motion, nor its direction."""


def shift(track: Track, together: int = 1) -> float:
    """Return how far the handle went from its first place, where it was farthest, in m, signed.

    together: samples whose mean is a place.
    """
    place = np.convolve(track.position, np.full(together, 1.0 / together), "valid")
    away = place - place[0]
    return float(away[np.argmax(np.abs(away))])


@dataclass(frozen=True)
class Direction:
    """How far each pulse (force in N) moved the handle in m; agrees: None where that cannot be told."""

    pulses: tuple[tuple[float, float], ...]
    agrees: bool | None
    verdict: Verdict


def judge(pulses: list[tuple[float, float]]) -> Direction:
    """Judge pulses (force N, shift m) of both signs."""
    moved = [(force, gone) for force, gone in pulses if abs(gone) >= MOVED]
    rights, lefts = ([m for m in moved if m[0] * sign > 0.0] for sign in (1.0, -1.0))
    pushed = max((abs(force) for force, _ in pulses), default=0.0)
    if not moved:
        words = f"Pulses up to {pushed:.1f} N did not move the handle."
        remedy = (
            "Is the motor's supply on (12 V plug, not only USB)? Is the cable on the pulley, and not jammed? "
            "Is the handle free? If all that is so, look for a dead band."
        )
        return Direction(tuple(pulses), None, look("no motion", words, remedy))
    signs = {np.sign(force * gone) for force, gone in moved}
    if len(signs) > 1 or not rights or not lefts:
        words = "The handle did not follow the pulses both ways."
        remedy = "Level the kit, let the handle go in the middle, keep the hands off. Then push again."
        return Direction(tuple(pulses), None, look("one way", words, remedy))
    farthest = 1e3 * max(abs(gone) for _, gone in moved)
    if signs == {-1.0}:
        words = f"A push to the right moved the handle to the left, {farthest:.1f} mm."
        remedy = "Nothing to do: the motor's direction is turned round now, and pushed again."
        return Direction(tuple(pulses), False, look("opposite", words, remedy))
    return Direction(tuple(pulses), True, passed(f"Force and position agree: {farthest:.1f} mm both ways."))

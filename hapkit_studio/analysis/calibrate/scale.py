"""Find zero and scale from marks at known positions by least squares, and check them against the radii."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from hapkit_studio.analysis.calibrate.result import CheckResult, failed, passed, warn
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.devices.profiles import quantum_of
from hapkit_studio.errors import ParameterError
from hapkit_studio.protocol.messages import Board

STILL = 0.4e-3
"""m: largest motion of a held handle during a mark."""
APART = 0.020
"""m: smallest distance between the outermost marks."""
SLIPPED = 1.5e-3
"""m: largest difference when a mark is repeated."""
READING = 0.3e-3
"""m: standard deviation of a mark held by hand, combined with the residuals of the marks."""
_KNOWN = 4
# Largest relative deviation of the fitted scale from the scale of the radii. If the deviation is near a
# factor of 2, or the handle length is implausible (kits have 66 to 90 mm), a diameter was entered as a
# radius.
NEAR = 0.06
_FACTOR = 0.12
_HANDLES = (0.055, 0.120)
_NAMES = {"handle_radius": "The handle's radius rh", "pulley_radius": "The pulley's radius rp"}


@dataclass(frozen=True)
class Mark:
    """A handle held at a known position: place in m from the centre, positive to the right, and raw count."""

    place: float
    count: float


def mark_from(track: Track, place: float) -> Mark:
    """Return the mark from a track of a held handle; raise ParameterError if the handle moves."""
    count = track.settings.sense * track.count + track.settings.zero
    spread = float(np.ptp(track.position))
    if spread > STILL:
        moved = f"The handle moved {1e3 * spread:.1f} mm (limit {1e3 * STILL:.1f} mm)."
        raise ParameterError(f"{moved} Hold the handle still, and take the mark again.")
    return Mark(place, float(count.mean()))


@dataclass(frozen=True)
class Scale:
    """A fitted scale: quantum in m per count with its 95 % half width, zero as a raw count, and sense.

    ``residuals`` (n,) in m are those of the marks. ``ratio`` is the fitted quantum divided by the quantum
    that follows from the radii. ``twice`` is the largest difference between repeated marks in m.
    """

    quantum: float
    quantum_half: float
    zero: float
    sense: int
    residuals: np.ndarray
    ratio: float
    closure: float
    result: CheckResult


def fit(marks: list[Mark], board: Board, inverted: bool | None = None) -> Scale:
    """Fit count = zero + place / quantum; raise ParameterError for few marks or a small range."""
    places, counts = np.array([m.place for m in marks]), np.array([m.count for m in marks])
    if len(marks) < 2 or np.ptp(places) < APART:
        raise ParameterError(
            f"At least two marks, {1e3 * APART:.0f} mm or more apart, are needed; you have {len(marks)}. "
            "Take another mark."
        )
    middle = places.mean()
    around = places - middle
    slope = float(around @ counts) / float(around @ around)
    zero = float(counts.mean() - slope * middle)
    if abs(slope) < 1.0 and np.ptp(counts) * quantum_of(board) > APART / 2:
        raise ParameterError(
            "The marks contradict each other: the handle was on the wrong side at one of them. Take all "
            "marks again."
        )
    if abs(slope) < 1.0:
        raise ParameterError("The counts do not change from mark to mark. Go back to the step Sensor.")
    residuals = (counts - zero - slope * places) / slope
    freedom = len(marks) - 2 + _KNOWN
    sigma = np.sqrt((float(residuals @ residuals) + _KNOWN * READING**2) / freedom)
    spread = float(stats.t.ppf(0.975, freedom)) * sigma / np.sqrt(float(around @ around))
    quantum = 1.0 / abs(slope)
    sense = 1 if slope > 0.0 else -1
    twice = quantum * max(abs(a.count - b.count) for a in marks for b in marks if a.place == b.place)
    ratio = quantum / quantum_of(board)
    found = Scale(quantum, quantum * spread, zero, sense, residuals, ratio, twice, passed(""))
    # the distance of each mark from the line through the other marks; 0 if they do not determine a line
    free = 1.0 - 1.0 / len(marks) - around**2 / float(around @ around)
    apart = float(np.abs(residuals / np.where(free > 1e-6, free, np.inf)).max())
    return replace(found, result=_judge(found, board, apart, inverted))


def _judge(found: Scale, board: Board, apart: float, inverted: bool | None) -> CheckResult:
    if found.closure > SLIPPED:
        return failed(
            "slipped",
            f"The readings at one mark differ by {1e3 * found.closure:.1f} mm "
            f"(limit {1e3 * SLIPPED:.1f} mm).",
            "The cable slipped, or the handle was not at the mark. Tighten the cable, then take all marks "
            "again.",
        )
    if apart > 3.0 * SLIPPED:
        return failed(
            "uneven",
            f"One mark is {1e3 * apart:.1f} mm away from where the other marks put it.",
            "The handle was not at that mark, or the cable slipped. Take all marks again.",
        )
    if inverted is False and found.sense != board.sense:
        return failed(
            "swapped",
            "Left and right are swapped: the step Sensor found the opposite direction.",
            "Take all marks again, with −20 mm on the left and 20 mm on the right.",
        )
    return _judge_ratio(found, board)


def _judge_ratio(found: Scale, board: Board) -> CheckResult:
    off = found.ratio - 1.0
    if abs(off) <= max(NEAR, 2.0 * found.quantum_half / found.quantum):
        return passed(
            f"{1e6 * found.quantum:.2f} ± {1e6 * found.quantum_half:.2f} µm per count; "
            f"the radii give {1e6 * found.quantum / found.ratio:.2f}."
        )
    pulley, handle = 1e3 * board.pulley_radius, 1e3 * board.handle_radius
    text = f"Per count, the handle moves {found.ratio:.2f} × as far as computed from the radii."
    for factor, meaning in ((0.5, "the pulley's diameter"), (2.0, "half the pulley's radius")):
        no_handle = not _HANDLES[0] <= board.handle_radius * found.ratio <= _HANDLES[1]
        if abs(found.ratio / factor - 1.0) <= _FACTOR or (no_handle and off * (factor - 1.0) > 0.0):
            return warn(
                "diameter",
                f"{text} {pulley:.1f} mm looks like {meaning}, not the pulley's radius.",
                f"Enter {pulley * factor:.1f} mm for the pulley and press Use these radii, "
                "or check the distances between the marks.",
            )
    return warn(
        "radius",
        f"{text} Perhaps the handle is {handle * found.ratio:.0f} mm from the axis, not {handle:.0f} mm.",
        f"Measure rh, rp and rs, or press Use this scale, which sets rh to {handle * found.ratio:.1f} mm.",
    )


def changes(found: Scale, board: Board) -> dict[str, float | int]:
    """Return the settings that the marks correct.

    The quantum is proportional to rh rp / rs, the force to rs / (rh rp), with the radii rh of the handle, rp
    of the pulley and rs of the sector. A wrong radius is therefore corrected together with the quantum, and
    the force changes with it.
    """
    made = {"quantum": found.quantum, "zero": round(found.zero), "sense": found.sense}
    radius = _wrong_radius(found)
    return made | {radius: getattr(board, radius) * found.ratio}


def in_force(found: Scale, before: Board) -> CheckResult:
    """Return the result of the scale check after the marks and the corrected radius are applied."""
    if found.result.key not in ("diameter", "radius"):
        return found.result
    radius = _wrong_radius(found)
    old, name = 1e3 * getattr(before, radius), _NAMES[radius]
    return passed(
        f"{1e6 * found.quantum:.2f} ± {1e6 * found.quantum_half:.2f} µm per count, from the marks. "
        f"{name} is now {old * found.ratio:.2f}\N{NO-BREAK SPACE}mm instead of {old:.2f} mm."
    )


def _wrong_radius(found: Scale) -> str:
    """Return the key of the radius whose error explains the deviation of the scale."""
    return "handle_radius" if found.result.key == "radius" else "pulley_radius"

"""A recording laid on an even grid of samples, and which of them say something about what."""

from dataclasses import dataclass

import numpy as np

from hapkit_studio.analysis.identify.recording import Recording
from hapkit_studio.haptics import rows

# Reasons to leave samples out, in the order in which they are told.
REASONS = {
    "clamped": rows.CLAMPED,
    "stopped": rows.STOPPED,
    "fault": rows.FAULT,
    "stale sensor": rows.STALE,
    "fading": rows.FADING,
}
_MOTOR_OFF = rows.STOPPED | rows.FAULT | rows.STALE
_NOT_AS_ASKED = _MOTOR_OFF | rows.CLAMPED | rows.FADING
_SLOPE_SECONDS = 0.009
_FEWEST = 5
# A longer break than that starts anew: what came before is of no use to what comes after.
_LONGEST_GAP = 1000


@dataclass(frozen=True)
class Grid:
    """Arrays (n,) on an even grid: position m about its middle, commands N, the hand's force N
    (what is smooth of it, and what is held from sample to sample).

    there: recorded at all; law: the law's force was applied as asked; known: the force in effect is known;
    contact: the law pushed; slope: the speed of a line through 9 ms; sign: its direction, 0 where that cannot
    be told; gone: how far it went that way, in m; seen and speed: what the law got as position and velocity;
    clamped: by nothing but the force limit; damped: the passivity controller added damping;
    target: where the hand pulls to, None where it is not known all the time.
    """

    period: float
    begin: float
    middle: float
    position: np.ndarray
    commands: np.ndarray
    hand: np.ndarray
    hand_held: np.ndarray
    hand_known: bool
    held: np.ndarray
    there: np.ndarray
    law: np.ndarray
    known: np.ndarray
    contact: np.ndarray
    slope: np.ndarray
    sign: np.ndarray
    gone: np.ndarray
    clamped: np.ndarray
    damped: np.ndarray
    seen: np.ndarray
    speed: np.ndarray
    target: np.ndarray | None
    left_out: dict[str, int]

    def __len__(self) -> int:
        return len(self.position)


def lay(recording: Recording) -> Grid:
    """Lay a recording on its grid; samples between rows that were lost are not there."""
    steps, period = _steps(recording)
    good = np.concatenate(([True], steps > 0))
    place = np.concatenate(([0], np.cumsum(np.clip(steps, 0, _LONGEST_GAP))))[good]
    count = int(place[-1]) + 1
    there = np.zeros(count, bool)
    there[place] = True

    def spread(column: np.ndarray) -> np.ndarray:
        values = np.zeros(count)
        values[place] = column[good]
        return values

    middle = float(recording.position[good].mean())
    flags = spread(recording.flags).astype(int)
    position = np.interp(np.arange(count), place, recording.position[good] - middle)
    hand_known = bool(np.isfinite(recording.hand_force).all())
    hand = np.nan_to_num(spread(recording.hand_force))
    law = there & (flags & _NOT_AS_ASKED == 0)
    along = slope(position, period)
    sign = direction(along, recording.setup.quantum, period)
    left_out = {word: int(((flags & bit) != 0).sum()) for word, bit in REASONS.items()}
    left_out["lost"] = int((~there).sum())
    return Grid(
        period=period,
        begin=float(recording.time[0]),
        middle=middle,
        position=position,
        commands=spread(recording.applied),
        hand=hand,
        hand_held=spread(recording.hand_held),
        hand_known=hand_known,
        held=(hand != 0.0) | (spread(recording.hand_held) != 0.0),
        there=there,
        law=law,
        known=there & (flags & _MOTOR_OFF == 0),
        contact=spread(recording.asked) != 0.0,
        slope=along,
        sign=sign,
        gone=_gone(position, sign),
        clamped=there & (flags & _NOT_AS_ASKED == rows.CLAMPED),
        damped=flags & rows.DAMPED != 0,
        seen=spread(recording.position),
        speed=spread(recording.velocity),
        target=_target(recording, place, good),
        left_out={word: number for word, number in left_out.items() if number},
    )


def _target(recording: Recording, place: np.ndarray, good: np.ndarray) -> np.ndarray | None:
    if recording.target is None or not np.isfinite(recording.target).all():
        return None
    return np.interp(np.arange(int(place[-1]) + 1), place, recording.target[good])


def _steps(recording: Recording) -> tuple[np.ndarray, float]:
    """Return how many periods each sample is after the one before (n - 1,), and the period in s."""
    gaps = np.diff(recording.time)
    usual = float(np.median(gaps[gaps > 0.0])) if (gaps > 0.0).any() else 1.0 / recording.setup.rate
    steps = np.rint(gaps / usual).astype(int)
    near = steps == 1
    return steps, float(gaps[near].mean()) if near.any() else usual


def slope(position: np.ndarray, period: float) -> np.ndarray:
    """Return the speed (n,) in m/s of a line through some 9 ms about each sample, 0 at the ends."""
    samples = _slope_samples(period)
    if len(position) < samples:
        return np.zeros(len(position))
    about = np.arange(samples) - samples // 2
    found = np.convolve(position, -about / (period * float(about @ about)), "same")
    found[: samples // 2] = found[-(samples // 2) :] = 0.0
    return found


def direction(speed: np.ndarray, quantum: float, period: float) -> np.ndarray:
    """Return the sign of a ``slope`` (n,), 0 where a count or two of the sensor could have made it."""
    least = max(2.0 * quantum / (_slope_samples(period) * period), 1e-6)
    return np.where(np.abs(speed) > least, np.sign(speed), 0.0)


def _slope_samples(period: float) -> int:
    return max(_FEWEST, int(_SLOPE_SECONDS / period) // 2 * 2 + 1)


def _gone(position: np.ndarray, sign: np.ndarray) -> np.ndarray:
    """Return how far the handle is from where it last turned or stood, in m, (n,)."""
    turned = np.flatnonzero(np.diff(sign, prepend=0.0) != 0.0)
    last = np.searchsorted(turned, np.arange(len(sign)), side="right") - 1
    origin = np.where(last >= 0, turned[last] if len(turned) else 0, 0)
    return np.abs(position - position[origin])

"""The sensor over the whole range: counts, their period, and whether it is reliable."""

from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.calibrate.result import PASS, CheckResult, passed, warn
from hapkit_studio.devices.board_runner import Track
from hapkit_studio.devices.profiles import quantum_of
from hapkit_studio.formatting import number
from hapkit_studio.protocol.messages import Board, Sensor

ENOUGH_TRAVEL = 0.060
"""m: smallest range for a check of the sensor; a kit has about 100 mm."""
NOISY = 4.0
"""Counts: a reading with a larger standard deviation is noisy."""
_STUCK = 3
_FEW_REPEATS = 4
_PLAUSIBLE = 0.15
_NEIGHBOURS = 3


@dataclass(frozen=True)
class SensorResult:
    """The result of the sensor check, in counts: lowest and highest reading, jumps, noise.

    The period is given in counts with half the width of its 95 % interval; both are NaN if there are too few
    jumps. The travel in m is computed from the radii.
    """

    low: int
    high: int
    repeats: int
    period: float
    half: float
    travel: float
    noise: float
    result: CheckResult


def noise_of(raw: np.ndarray) -> float:
    """Return the standard deviation in counts of white noise in readings (n,); repeated readings are ignored.

    The second differences of independent errors have six times the variance of the errors. The median
    absolute value of a normal distribution is 0.6745 standard deviations.
    """
    second = np.abs(np.diff(raw.astype(float), 2))
    if not len(second):
        return 0.0
    return float(np.median(second)) / 0.6745 / np.sqrt(6.0)


def too_noisy(noise: float) -> CheckResult:
    """Return the result for a reading with this noise in counts."""
    return warn(
        "noisy",
        f"The sensor's reading jumps by {noise:.0f} counts (limit {NOISY:.0f}).",
        "Move the magnet closer to the chip without touching it. Keep the motor's wires away from it.",
    )


def periods(raw: np.ndarray) -> np.ndarray:
    """Return the period (k,) in counts that each jump implies, corrected for the motion during the jump.

    A jump may take several readings. The motion during this time is interpolated from the speeds before and
    after.
    """
    reach = float(np.ptp(raw)) + 1.0
    jumps = np.flatnonzero(np.abs(np.diff(raw.astype(float))) > 0.5 * reach) + 1
    n = _NEIGHBOURS
    found = []
    for at in jumps:
        if at - 2 * n < 0 or at + 2 * n > len(raw):
            continue
        before, after = raw[at - 2 * n : at].astype(float), raw[at : at + 2 * n].astype(float)
        if max(np.ptp(before), np.ptp(after)) > 0.4 * reach:
            continue  # the handle reversed during the jump
        index = np.arange(2 * n)
        last = np.polyval(np.polyfit(index, before, 1), 2 * n - 0.5)
        first = np.polyval(np.polyfit(index, after, 1), -0.5)
        found.append(abs(last - first))
    return np.array(found)


def analyse(track: Track) -> SensorResult:
    """Analyse a track of several motions from the left end to the right end."""
    board, raw = track.settings, track.raw
    low, high = int(raw.min()), int(raw.max())
    noise = noise_of(raw)
    period = half = float("nan")
    if board.sensor == Sensor.QUADRATURE:
        sizes, turns = np.empty(0), track.count
    else:  # the readings wrap around: they jump by more than half the observed range
        sizes, turns = periods(raw), np.unwrap(raw.astype(float), period=float(np.ptp(raw)) + 1.0)
    if len(sizes) >= _FEW_REPEATS:
        middle = np.median(sizes)
        near = sizes[np.abs(sizes - middle) <= max(0.05 * middle, 5.0)]
        period, half = float(near.mean()), 1.96 * float(near.std(ddof=1)) / np.sqrt(len(near)) + 0.5
    travel = float(np.ptp(turns)) * quantum_of(board)
    found = SensorResult(low, high, len(sizes), period, half, travel, noise, passed(""))
    return replace(found, result=_judge(found, track, board))


def _judge(found: SensorResult, track: Track, board: Board) -> CheckResult:
    span = found.high - found.low
    if span <= _STUCK and np.ptp(track.count) <= _STUCK:
        return warn(
            "stuck",
            f"The sensor stays at {found.low} although the handle should move.",
            "Check the chosen kit, the magnet on the motor's shaft, and the plug. Then move the handle "
            "again.",
        )
    if found.noise > NOISY:
        return too_noisy(found.noise)
    if found.travel < ENOUGH_TRAVEL:
        return warn(
            "little",
            f"The handle moved {1e3 * found.travel:.0f} mm; {1e3 * ENOUGH_TRAVEL:.0f} mm are needed.",
            "Move the handle from the left end to the right end and back.",
        )
    return _judge_range(found, track, board)


def _judge_range(found: SensorResult, track: Track, board: Board) -> CheckResult:
    wrong = abs(found.period - board.counts_per_flip) > _PLAUSIBLE * board.counts_per_flip
    if np.isfinite(found.period) and wrong:
        return warn(
            "range",
            f"The reading starts again after {found.period:.0f} counts; with this kit, it should start again "
            f"after {board.counts_per_flip}.",
            "Check that the right kit is chosen, and that the magnet is straight.",
        )
    if np.mean(track.count[:50]) > 0.5 * (track.count.min() + track.count.max()):
        text = (
            "The sensor works. If you began at the left, the sensor counts in the wrong direction, and "
            "the next step corrects this."
        )
        return CheckResult(PASS, text, key="inverted")
    repeats = f", {found.repeats} repeats" if found.repeats else ""
    low, high = number(found.low, 0), number(found.high, 0)
    return passed(f"The sensor reads {low} to {high}{repeats}, over {1e3 * found.travel:.0f} mm.")


def changes(found: SensorResult, board: Board) -> dict[str, int]:
    """Return the settings that the sensor check corrects; empty if the check failed."""
    if not np.isfinite(found.period) or not found.result.good:
        return {}
    counts = round(found.period)
    return {"counts_per_flip": counts} if abs(counts - board.counts_per_flip) > found.half else {}

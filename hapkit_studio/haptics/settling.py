"""Simulate the release of a scene's handle, at rest or with a speed, and classify the motion that follows.

The run is evaluated in windows of a given number of samples, and ends as soon as the outcome is known. Every
sample is equal to the batch engine's sample, bit for bit.
"""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.dynamics.jit import compiled, inlined
from hapkit_studio.haptics import block, headless, patience, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.cell_batch import restart
from hapkit_studio.haptics.simulated_loop import Plant
from hapkit_studio.laws.native import call

# The outcomes. RESTS: the handle is at rest. LEAVES: the handle has moved far away. SHRINKS: the oscillation
# has not ended after a long time, but it still shrinks. STEADY, GROWS and IRREGULAR describe the other
# oscillations. OPEN: the outcome is undecided after MOST_WINDOWS windows.
RESTS, LEAVES, SHRINKS, STEADY, GROWS, IRREGULAR, OPEN = range(7)
FIRST_CHECK, MOST_WINDOWS, CALM_WINDOWS = 16, 256, 4
# An oscillation is steady if its relative change from one quarter of the run to the next is at most the first
# value. It grows if its relative increase is above the second value.
_STEADY_SHARE, _GROWING_SHARE = 0.002, 0.04
# After _LONG_CHECK windows, an oscillation that neither grows nor shrinks is steady if its last two quarters
# differ by at most this fraction; otherwise it is irregular.
_LONG_CHECK, _IRREGULAR_SHARE = 64, 0.05
# The oscillation converges to a limit cycle if the logarithmic decay of the last quarter is below this
# fraction of the decay in the quarter before.
_AS_FAST = 0.9
# hysteresis of a reversal, as a fraction of the window's range after removing drift
_TURNED = 0.25


class Quiet(NamedTuple):
    """Thresholds for rest, and the distance at which the handle has moved away."""

    least: float  # m: the handle is at rest if a window's positions span at most this
    reach: float  # m: the handle is at rest if a window's positions span at most this and its force is steady
    force: float  # N: largest peak-to-peak change of a steady force
    still: int  # number of samples without any motion after which the handle is at rest
    far: float  # m: distance from the start at which the handle has moved away
    # True if no force centres the handle; the amplitude is then measured between reversals, without the drift
    drifts: bool


class Swing(NamedTuple):
    """The oscillation in the last half of a run; each array is of shape (1,), except low and high."""

    # m: peak-to-peak amplitude; if the handle drifts, the mean width of the reversals, or the largest width
    # if the oscillation is irregular
    reach: np.ndarray
    frequency: np.ndarray  # Hz; NaN without a complete cycle
    clamped: np.ndarray  # fraction of the samples at which the force is at its limit
    samples: np.ndarray  # number of samples of the whole run, up to the end of its last window
    # (MOST_WINDOWS,) m: lowest and highest position of each window; if the handle drifts, 0 and the mean
    # width of the window's reversals
    low: np.ndarray
    high: np.ndarray


def new_swing() -> Swing:
    """Return an empty result."""
    return Swing(*np.zeros((4, 1)), *np.zeros((2, MOST_WINDOWS)))


@inlined
def _reach(low: np.ndarray, high: np.ndarray, first: int, end: int) -> float:
    """Return the range of positions in m over several windows."""
    lowest, highest = math.inf, -math.inf
    for i in range(first, end):
        lowest, highest = min(lowest, low[i]), max(highest, high[i])
    return highest - lowest


@inlined
def _outcome(low: np.ndarray, high: np.ndarray, count: int) -> int:
    """Return the outcome after `count` windows; OPEN if the run continues."""
    quarter = count // 4
    before = _reach(low, high, count - 2 * quarter, count - quarter)
    after = _reach(low, high, count - quarter, count)
    if count >= _LONG_CHECK:
        first, second = _reach(low, high, 0, quarter), _reach(low, high, quarter, 2 * quarter)
        falls, rises = first > second > before > after, first < second < before < after
        if falls and before > after * max(1.0 + _STEADY_SHARE, (second / before) ** _AS_FAST):
            return SHRINKS
        if not falls and not rises:
            return IRREGULAR if abs(after - before) > _IRREGULAR_SHARE * max(before, after) else STEADY
    if after > before * (1.0 + _GROWING_SHARE):
        return GROWS
    return STEADY if abs(after - before) <= _STEADY_SHARE * after else OPEN


@compiled
def let_go(
    r: LoopArrays,
    body: Plant,
    flat: np.ndarray,
    made: np.ndarray,
    hand: np.ndarray,
    start: np.ndarray,
    window: int,
    shrinks: bool,
    grows: bool,
    quiet: Quiet,
    row: np.ndarray,
    swing: Swing,
) -> int:
    """Render one run into ``swing`` and return the outcome; ``patience.check`` reports a cancelled run.

    ``flat`` is the memory of arrays and plant, and ``made`` a copy of its initial content. ``hand`` contains
    mass, damping and stiffness, or zeros without a hand. ``start`` contains the position in m, the speed in
    m/s and the hand's target in m. ``window`` is the number of samples in a window. If ``shrinks`` or
    ``grows`` is true, the run ends when the outcome is SHRINKS or GROWS, respectively. ``row`` (ROW_WIDTH,)
    is a buffer for one sample.
    """
    restart(r, body, flat, made, hand, start[:0], start[0])
    body.dev[simulated.V] = start[1]
    period = r.block.settings.period
    low, high = swing.low, swing.high
    limit = r.block.settings.max_force * (1.0 - 1e-9)
    next_check, waited, done, end = FIRST_CHECK, 0, 0, OPEN
    way, extreme, band, middle = 1.0, start[0], 0.0, start[0]
    turned, earlier, turn, widest, sides = start[0], start[0], 0.0, 0.0, 0
    turns, first, last, clamped, counted, calm = 0, 0, 0, 0, 0, 0
    for n in range(MOST_WINDOWS):
        swing.samples[0] = (n + 1) * window
        low[n], high[n] = math.inf, -math.inf
        least, most = math.inf, -math.inf
        before, seen = turn, sides
        for _ in range(window):
            row[rows.BOARD_TIME] = done * period
            if not headless.simulate_sample(r, body, row, start[2], start[2], start[2]):
                return OPEN
            done += 1
            x, force = row[rows.TRUE_POSITION], row[rows.APPLIED_FORCE]
            low[n], high[n] = min(low[n], x), max(high[n], x)
            least, most = min(least, force), max(most, force)
            waited = waited + 1 if row[rows.TRUE_VELOCITY] == 0.0 else 0
            clamped += 1 if abs(force) >= limit else 0
            counted += 1
            if way * (x - extreme) >= 0.0:
                extreme = x
            elif way * (extreme - x) > band:
                if way > 0.0:
                    first, last, turns = done if turns == 0 else first, done, turns + 1
                # The width is the distance of an extreme from the mean of its two neighbours, which removes a
                # linear drift.
                width = abs(turned - 0.5 * (earlier + extreme))
                turn, widest, sides = turn + width, max(widest, width), sides + 1
                earlier, turned = turned, extreme
                way, extreme = -way, x
            if not abs(x - start[0]) <= quiet.far:
                return LEAVES
            if waited >= quiet.still:
                return RESTS
        reach = high[n] - low[n]
        steady = reach <= quiet.reach and most - least <= quiet.force
        calm = calm + 1 if steady or reach <= quiet.least else 0
        if calm == CALM_WINDOWS:
            return RESTS
        drifted, middle = middle, 0.5 * (low[n] + high[n])
        swung = max(reach - abs(middle - drifted), 0.0)
        band = _TURNED * swung
        if quiet.drifts:
            low[n], high[n] = 0.0, (turn - before) / max(sides - seen, 1)
        if n + 1 == next_check:
            end = _outcome(low, high, n + 1)
            if end == SHRINKS and not shrinks:
                end = OPEN
            if end in (SHRINKS, STEADY, IRREGULAR) or (end == GROWS and grows) or n + 1 == MOST_WINDOWS:
                swing.reach[0] = _reach(low, high, (n + 1) // 2, n + 1)
                if quiet.drifts:
                    swing.reach[0] = widest if end == IRREGULAR else turn / max(sides, 1)
                swing.clamped[0] = clamped / counted
                swing.frequency[0] = (turns - 1) / ((last - first) * period) if turns > 1 else math.nan
                return end
            next_check *= 2
        if n + 1 == next_check // 2:  # keep only the last half of the run
            turns, clamped, counted, sides, turn, widest = 0, 0, 0, 0, 0.0, 0.0
    return OPEN


@compiled
def static_forces(r: LoopArrays, places: np.ndarray, forces: np.ndarray) -> None:
    """Fill in the law's static forces (n,) in N at positions (n,) in m, each with the initial state.

    ``patience.check`` reports a cancelled run.
    """
    settings = r.block.settings
    patience.begin(r)
    for i in range(places.shape[0]):
        for j in range(block.STATES):
            r.states[0, j] = settings.initial_state[j]
        state, at = r.states[0], places[i]
        forces[i] = call(settings.law, settings.params, state, at, 0.0, settings.period, r.fault)
        if not patience.goes_on(r):
            return

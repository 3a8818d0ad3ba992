"""A scene let go from rest, or kicked: does it come to rest; if not, how far and how fast does it swing?

The run is judged as it goes, in windows of a given number of samples, so that it ends as soon as it is known.
Every sample is the batch's, bit for bit.
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

# How a run ends: it rests, is beyond what is near, comes down from quarter to quarter for long, swings
# steadily, ever farther, now more now less, or is not known after the most windows.
RESTS, LEAVES, SHRINKS, STEADY, GROWS, IRREGULAR, OPEN = range(7)
FIRST_LOOK, MOST_WINDOWS, CALM_WINDOWS = 16, 256, 4
# From one quarter of the run to the next, a steady swing changes by no more than this share of itself, one
# that grows by more than that.
_STEADY_SHARE, _GROWING_SHARE = 0.002, 0.04
# After so many windows a swing that neither grows nor shrinks from quarter to quarter stays irregular, or is
# steady where its last two differ by less than a share.
_LONG_LOOK, _IRREGULAR_SHARE = 64, 0.05
# What comes down to a swing that lasts does so ever more slowly: the last quarter's share is not so much of
# the one before in the logarithm.
_AS_FAST = 0.9
# The motion has turned where it came back by so much of what a window reaches besides its drift.
_TURNED = 0.25


class Quiet(NamedTuple):
    """What counts as rest or as gone."""

    least: float  # m: a window's motion no wider than that is rest
    reach: float  # m: no wider than that is rest, too, where its force is steady
    force: float  # N: peak to peak, a steady one
    still: int  # samples without any motion
    far: float  # m from where it was let go
    drifts: bool  # nothing brings it back: how far it swings is that of its turns, beside their drift


class Swing(NamedTuple):
    """What a run left, of its last half; each of shape (1,), but low and high."""

    reach: np.ndarray  # m, peak to peak; where it drifts, a turn's: mean, or the most of an irregular one
    frequency: np.ndarray  # Hz: turns over their time, nan where there was not one whole turn
    clamped: np.ndarray  # share of the samples whose force is at the limit
    samples: np.ndarray  # of the whole run, up to its last window's end
    low: np.ndarray  # (MOST_WINDOWS,) m: of each window the lowest and highest position; 0 and a mean turn
    high: np.ndarray


def new_swing() -> Swing:
    """Return room for what a run leaves."""
    return Swing(*np.zeros((4, 1)), *np.zeros((2, MOST_WINDOWS)))


@inlined
def _reach(low: np.ndarray, high: np.ndarray, first: int, end: int) -> float:
    """Return how far apart the outermost positions of some windows are, in m."""
    lowest, highest = math.inf, -math.inf
    for i in range(first, end):
        lowest, highest = min(lowest, low[i]), max(highest, high[i])
    return highest - lowest


@inlined
def _looked(low: np.ndarray, high: np.ndarray, count: int) -> int:
    """Return how a run of `count` windows ends: OPEN if it goes on."""
    quarter = count // 4
    before = _reach(low, high, count - 2 * quarter, count - quarter)
    after = _reach(low, high, count - quarter, count)
    if count >= _LONG_LOOK:
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
    """Render one run, fill swing, return how it ended; ``patience.check`` says whether it was ended.

    flat is the memory of arrays and plant, made a copy of it as the scene made them; hand: mass, damping,
    stiffness, zeros for none; start: position m, speed m/s, the hand's target m; window: samples; shrinks,
    grows: whether to end a run that does; row (ROW_WIDTH,) is room for one sample.
    """
    restart(r, body, flat, made, hand, start[:0], start[0])
    body.dev[simulated.V] = start[1]
    period = r.block.settings.period
    low, high = swing.low, swing.high
    limit = r.block.settings.max_force * (1.0 - 1e-9)
    look, waited, done, end = FIRST_LOOK, 0, 0, OPEN
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
                # a turn's width beside a straight drift: its far end from the middle of its near ones
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
        if n + 1 == look:
            end = _looked(low, high, n + 1)
            if end == SHRINKS and not shrinks:
                end = OPEN
            if end in (SHRINKS, STEADY, IRREGULAR) or (end == GROWS and grows) or n + 1 == MOST_WINDOWS:
                swing.reach[0] = _reach(low, high, (n + 1) // 2, n + 1)
                if quiet.drifts:
                    swing.reach[0] = widest if end == IRREGULAR else turn / max(sides, 1)
                swing.clamped[0] = clamped / counted
                swing.frequency[0] = (turns - 1) / ((last - first) * period) if turns > 1 else math.nan
                return end
            look *= 2
        if n + 1 == look // 2:  # what is left is of the last half
            turns, clamped, counted, sides, turn, widest = 0, 0, 0, 0, 0.0, 0.0
    return OPEN


@compiled
def static_forces(r: LoopArrays, places: np.ndarray, forces: np.ndarray) -> None:
    """Fill the law's forces (n,) in N at rest at places (n,) in m, its state at the start each time.

    ``patience.check`` says whether it was ended before.
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

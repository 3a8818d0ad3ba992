"""Run one scene many times with different parameters; each run ends as soon as its outcome is known.

A thread computes hundreds of cells without Python, with one set of loop arrays and one plant. Their memory is
one flat array, so a single copy resets them. Every sample equals that of the batch engine bit for bit.
"""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.devices import simulated
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.dynamics.jit import compiled, inlined, internal
from hapkit_studio.haptics import headless, patience, rows, simulated_loop
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import load_acquire
from hapkit_studio.haptics.simulated_loop import Plant

# Each run is divided into parts of equal duration. For each part, the lowest and highest true position in m
# are stored, and the sum over its samples of a^2 + (w v)^2 in m2/s4 (acceleration a, velocity v). This term
# is constant during an oscillation at the angular frequency w.
PARTS = 12
LOW, HIGH, POWER = range(3)
# how a run ended
COMPLETED, LEFT_RANGE, SETTLED, DIED_OUT, STEADY = range(5)
# largest relative difference between the position ranges of the parts of a steady motion
_STEADY_SHARE = 0.01


class Cells(NamedTuple):
    """The values that differ between the runs; each run is one cell, with one entry or row in every array."""

    numbers: np.ndarray  # (n, p): the first p parameters of the law
    starts: np.ndarray  # (n,) m: position at which the handle is released at rest
    samples: np.ndarray  # (n,) int64: number of samples per part
    weights: np.ndarray  # (n,) rad/s: angular frequency w in POWER


class Limits(NamedTuple):
    """Conditions that end a run early."""

    far: float  # m: the handle has left its range if |x| exceeds this value or is not finite
    still: int  # samples: the handle has come to rest if it has not moved for this number of samples
    faint: float  # m: the motion has died out if it stays within this range for a whole part
    small: float  # m: a steady motion of at most this size needs no further samples


NEVER_STILL, NEVER_FAINT, NEVER_SMALL = 1 << 62, 0.0, 0.0


class CellResults(NamedTuple):
    """The outcome of the runs; one entry per cell."""

    parts: np.ndarray  # (n, PARTS, 3): LOW, HIGH, POWER; parts after the end of the run are zero
    ends: np.ndarray  # (n,) int64: COMPLETED, LEFT_RANGE, SETTLED, DIED_OUT or STEADY
    samples: np.ndarray  # (n,) int64: number of rendered samples


def packed(r: LoopArrays, body: Plant) -> tuple[LoopArrays, Plant, np.ndarray]:
    """Return copies of arrays and plant whose memory is one flat int64 array, and this array."""

    def leaves(tree):
        return [leaf for part in tree for leaf in (leaves(part) if isinstance(part, tuple) else [part])]

    flat = np.concatenate([np.frombuffer(leaf.tobytes(), np.int64) for leaf in leaves((r, body))])
    rest = flat

    def rebuilt(tree):
        return type(tree)(*(rebuilt(part) if isinstance(part, tuple) else piece(part) for part in tree))

    def piece(old):
        nonlocal rest
        first, rest = np.split(rest, [old.nbytes // 8])
        array = first.view(old.dtype).reshape(old.shape)
        return array if array.ndim else array[()]

    return rebuilt(r), rebuilt(body), flat


@inlined
def _end_of(parts: np.ndarray, part: int, limits: Limits) -> int:
    """Return the reason to end a run after a part; COMPLETED means that the run continues.

    The motion is steady if its range is the same in the last three parts and is at most ``small``.
    """
    if max(-parts[part, LOW], parts[part, HIGH]) < limits.faint:
        return DIED_OUT
    if part < 2:
        return COMPLETED
    reach = parts[part, HIGH] - parts[part, LOW]
    before = parts[part - 1, HIGH] - parts[part - 1, LOW]
    first = parts[part - 2, HIGH] - parts[part - 2, LOW]
    most = _STEADY_SHARE * reach
    steady = 0.0 < reach <= limits.small and abs(before - reach) <= most and abs(first - reach) <= most
    return STEADY if steady else COMPLETED


@internal
def _watch(
    r: LoopArrays,
    body: Plant,
    row: np.ndarray,
    samples: int,
    weight: float,
    limits: Limits,
    parts: np.ndarray,
) -> tuple[int, int]:
    """Render one run into parts (PARTS, 3); return how the run ended and its number of samples."""
    period = r.block.settings.period
    speed, waited, done, end = 0.0, 0, 0, COMPLETED
    for part in range(PARTS):
        low, high, power = math.inf, -math.inf, 0.0
        for _ in range(samples):
            row[rows.BOARD_TIME] = done * period
            if not headless.simulate_sample(r, body, row, 0.0, 0.0, 0.0):
                return end, done
            done += 1
            x, v = row[rows.TRUE_POSITION], row[rows.TRUE_VELOCITY]
            low, high = min(low, x), max(high, x)
            pull, turn = (v - speed) / period, weight * v
            power += pull * pull + turn * turn
            waited = waited + 1 if v == 0.0 and speed == 0.0 else 0
            speed = v
            if not abs(x) <= limits.far or waited >= limits.still:
                end = SETTLED if waited >= limits.still else LEFT_RANGE
                break
        parts[part, LOW], parts[part, HIGH], parts[part, POWER] = low, high, power
        end = _end_of(parts, part, limits) if end == COMPLETED else end
        if end != COMPLETED:
            break
    return end, done


@inlined
def restart(
    r: LoopArrays,
    body: Plant,
    flat: np.ndarray,
    made: np.ndarray,
    hand: np.ndarray,
    numbers: np.ndarray,
    start: float,
) -> None:
    """Reset arrays and plant to the scene's initial state, with new parameters and a start position in m."""
    for j in range(flat.shape[0]):
        flat[j] = made[j]
    for j in range(numbers.shape[0]):
        r.block.settings.params[j] = numbers[j]
    body.dev[simulated.X] = start
    simulated_loop.configure(body, r.block.settings, (hand[0], hand[1], hand[2]), True)


@compiled
def run(
    r: LoopArrays,
    body: Plant,
    flat: np.ndarray,
    made: np.ndarray,
    hand: np.ndarray,
    cells: Cells,
    limits: Limits,
    row: np.ndarray,
    found: CellResults,
) -> None:
    """Render every cell into ``found``; stop early if a law is too slow or the user cancels.

    ``flat`` is the memory of arrays and plant, and ``made`` a copy of its initial content. ``row``
    (ROW_WIDTH,) is a buffer for one sample. ``hand`` contains mass, damping and stiffness of a hand that
    rests at 0 m, or zeros without a hand.
    """
    for i in range(cells.starts.shape[0]):
        restart(r, body, flat, made, hand, cells.numbers[i], cells.starts[i])
        end, done = _watch(r, body, row, cells.samples[i], cells.weights[i], limits, found.parts[i])
        found.ends[i], found.samples[i] = end, done
        if load_acquire(r.control.quit, 0):
            return


def run_cells(scene: headless.Scene, grip: Grip | None, cells: Cells, limits: Limits) -> CellResults:
    """Return the results of a scene's runs with the parameters of the cells; a grip's hand rests at 0 m.

    Raise LawError if the law is too slow.
    """
    r, body, flat = packed(*scene.prepare())
    made = flat.copy()
    hand = np.array([grip.mass, grip.damping, grip.stiffness]) if grip else np.zeros(3)
    count = len(cells.starts)
    found = CellResults(np.zeros((count, PARTS, 3)), *np.zeros((2, count), dtype=np.int64))
    run(r, body, flat, made, hand, cells, limits, np.zeros(rows.ROW_WIDTH), found)
    patience.check(r, scene.environment.title)
    return found

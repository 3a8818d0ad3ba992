"""Delays from a sample to its force in effect, measured from what samples say of the force they had."""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal

OF_COMPUTER, OF_BOARD = 0, 1
DELAYS_KEPT = 4096
LONGEST_DELAY = 65.5e-3  # s: a delay from here on is only known to be longer
FAR_BEHIND = 1024  # samples behind which an answer is no answer


class Delays(NamedTuple):
    """The last delays in s of computer and board, (2, DELAYS_KEPT), and how many there ever were, (2,).

    last: number of the sample that the force in effect answered, and 1 where the next one follows on it.
    """

    values: np.ndarray
    counts: np.ndarray
    last: np.ndarray


def new_delays() -> Delays:
    """Return room for delays, none measured."""
    return Delays(np.zeros((2, DELAYS_KEPT)), *np.zeros((2, 2), dtype=np.int64))


@compiled
def note_force_age(
    delays: Delays, seq: int, answered: int, delay: float, period: float, follows: bool
) -> None:
    """Take what a sample of the board says about the force in effect over the period before it, in s.

    The force's age, meant over time, is half a period more than the delay of a loop that answers them all:
    that delay is kept. So a force that stays because answers are rare counts with the age it reaches.
    """
    behind, step = (seq - 1 - answered) & 0xFFFF, (answered - delays.last[0]) & 0xFFFF
    known = 0.0 < delay < LONGEST_DELAY and behind < FAR_BEHIND
    if known and follows and delays.last[1] and step < FAR_BEHIND:
        share = min(max(delay / period - behind, 0.0), 1.0)
        note_delay(delays, OF_COMPUTER, (behind + share * step) * period)
    delays.last[0], delays.last[1] = answered, known


@internal
def note_delay(delays: Delays, which: int, delay: float) -> None:
    """Take one measured delay in s; 0 stands for none."""
    if delay > 0.0:
        delays.values[which, delays.counts[which] % DELAYS_KEPT] = delay
        delays.counts[which] += 1


class MeasuredDelay(NamedTuple):
    """Mean and standard deviation in s of so many delays."""

    mean: float
    spread: float
    total: int


def measured_delay(delays: Delays, which: int, last: int = DELAYS_KEPT) -> MeasuredDelay | None:
    """Return what the last delays of the computer or the board were, None where there are none."""
    count = int(delays.counts[which])
    if count == 0:
        return None
    found = delays.values[which, (count - 1 - np.arange(min(count, last, DELAYS_KEPT))) % DELAYS_KEPT]
    return MeasuredDelay(float(found.mean()), float(found.std()), count)

"""The delay from a sample to its force as measured, of the last seconds, apart for computer and board."""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled

COMPUTER, BOARD = 0, 1
KEPT = 4096
LONGEST = 65.5e-3
"""s: a delay from here on is only known to be longer."""
FAR = 1024
"""Samples behind which an answer is no answer."""


class Delays(NamedTuple):
    """The last delays in s of each way, (2, KEPT), and how many there ever were, (2,).

    last: number of the sample that the force in effect answered, and 1 where the next one follows on it.
    """

    values: np.ndarray
    counts: np.ndarray
    last: np.ndarray


def new_delays() -> Delays:
    """Return room in which nothing is measured yet."""
    return Delays(np.zeros((2, KEPT)), np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.int64))


@compiled
def note_age(delays, seq, answered, delay, period, follows):
    """Take what a sample of the board says about the force in effect over the period before it, in s.

    The force's age, meant over time, is half a period more than the delay of a loop that answers them all:
    that delay is kept. So a force that stays because answers are rare counts with the age it reaches.
    """
    behind = (seq - 1 - answered) & 0xFFFF
    known = 0.0 < delay < LONGEST and behind < FAR
    if known and follows and delays.last[1]:
        share = min(max(delay / period - behind, 0.0), 1.0)
        note(delays, COMPUTER, (behind + share * ((answered - delays.last[0]) & 0xFFFF)) * period)
    delays.last[0], delays.last[1] = answered, known


@compiled
def note(delays, which, delay):
    """Take one measured delay in s; 0 stands for none."""
    if delay > 0.0:
        delays.values[which, delays.counts[which] % KEPT] = delay
        delays.counts[which] += 1


class Measured(NamedTuple):
    """Mean and standard deviation in s of so many delays."""

    mean: float
    spread: float
    total: int


def measured(delays: Delays, which: int, last: int = KEPT) -> Measured | None:
    """Return what the last delays of a way were, None where there are none."""
    count = int(delays.counts[which])
    if count == 0:
        return None
    found = delays.values[which, (count - 1 - np.arange(min(count, last, KEPT))) % KEPT]
    return Measured(float(found.mean()), float(found.std()), count)

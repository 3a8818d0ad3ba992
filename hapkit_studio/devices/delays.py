"""Delays from a sample until its force takes effect, computed from acknowledgements that samples contain."""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal

OF_COMPUTER, OF_BOARD = 0, 1
DELAYS_KEPT = 4096
LONGEST_DELAY = 65.5e-3  # s: a longer delay saturates the 16-bit field ``delay_us`` of a sample
FAR_BEHIND = 1024  # samples: an acknowledgement that is farther behind is invalid


class Delays(NamedTuple):
    """The last delays in s of computer and board, (2, DELAYS_KEPT), and their total numbers (2,).

    ``last`` contains the number of the sample that the force in effect answered, and 1 if the age of that
    force was known.
    """

    values: np.ndarray
    counts: np.ndarray
    last: np.ndarray


def new_delays() -> Delays:
    return Delays(np.zeros((2, DELAYS_KEPT)), *np.zeros((2, 2), dtype=np.int64))


@compiled
def note_force_age(
    delays: Delays, seq: int, answered: int, delay: float, period: float, follows: bool
) -> None:
    """Record the age in s of the force in effect over the last period, as a board reports it.

    If all samples are answered, the delay of the answer is recorded; it is the mean age of the force minus
    half a period. If answers are rare, a force that stays in effect is recorded with its increasing age.
    """
    behind, step = (seq - 1 - answered) & 0xFFFF, (answered - delays.last[0]) & 0xFFFF
    known = 0.0 < delay < LONGEST_DELAY and behind < FAR_BEHIND
    if known and follows and delays.last[1] and step < FAR_BEHIND:
        share = min(max(delay / period - behind, 0.0), 1.0)
        note_delay(delays, OF_COMPUTER, (behind + share * step) * period)
    delays.last[0], delays.last[1] = answered, known


@internal
def note_delay(delays: Delays, which: int, delay: float) -> None:
    """Record one measured delay in s; 0 means that there is no delay."""
    if delay > 0.0:
        delays.values[which, delays.counts[which] % DELAYS_KEPT] = delay
        delays.counts[which] += 1


class MeasuredDelay(NamedTuple):
    """Mean and standard deviation of the delay in s, and the number of delays."""

    mean: float
    spread: float
    total: int


def measured_delay(delays: Delays, which: int, last: int = DELAYS_KEPT) -> MeasuredDelay | None:
    """Return statistics of the last delays of the computer or the board; None if there are no delays."""
    count = int(delays.counts[which])
    if count == 0:
        return None
    found = delays.values[which, (count - 1 - np.arange(min(count, last, DELAYS_KEPT))) % DELAYS_KEPT]
    return MeasuredDelay(float(found.mean()), float(found.std()), count)

"""The delay from a sample to its force as measured, of the last seconds, apart for computer and board."""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled

COMPUTER, BOARD = 0, 1
KEPT = 4096


class Delays(NamedTuple):
    """The last delays in s of each way, (2, KEPT), and how many there ever were, (2,)."""

    values: np.ndarray
    counts: np.ndarray


def new_delays() -> Delays:
    """Return room in which nothing is measured yet."""
    return Delays(np.zeros((2, KEPT)), np.zeros(2, dtype=np.int64))


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

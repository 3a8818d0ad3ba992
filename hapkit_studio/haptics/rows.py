"""Telemetry: the row that every tick writes, in SI units, and a ring buffer of rows for readers.

HOST_TIME is the computer's monotonic clock (time.perf_counter), so rows before and after a lost connection
share a time axis. BOARD_TIME is the device's clock since the device started. The loop writes without waiting.
Each reader has a separate cursor.
"""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics.block import STATES
from hapkit_studio.haptics.clib import fence, load_acquire, store_release
from hapkit_studio.haptics.record import Record
from hapkit_studio.haptics.signals import COLUMN, SIGNALS

TICK, HOST_TIME, BOARD_TIME = COLUMN["tick"], COLUMN["time"], COLUMN["board_time"]
POSITION, VELOCITY = COLUMN["position"], COLUMN["velocity"]
FORCE, APPLIED_FORCE = COLUMN["force"], COLUMN["applied_force"]
ENERGY, ENERGY_GIVEN, ENERGY_LIMIT = COLUMN["energy"], COLUMN["energy_given"], COLUMN["energy_limit"]
LATENESS, COMPUTE, PERIOD, FLAGS = COLUMN["lateness"], COLUMN["compute"], COLUMN["period"], COLUMN["flags"]
TRUE_POSITION, TRUE_VELOCITY = COLUMN["true_position"], COLUMN["true_velocity"]
HAND_FORCE, HAND_TARGET = COLUMN["hand_force"], COLUMN["hand_target"]
STATE = len(SIGNALS)
ROW_WIDTH = STATE + STATES

CLAMPED, STOPPED, FAULT, STALE, FADING, GAP = 1, 2, 4, 8, 16, 32
# flags of the passivity observer: more energy was given than the limit; the controller adds damping
ACTIVE, DAMPED = 64, 128
CAPACITY = 1 << 16


class Ring(NamedTuple):
    """Rows (capacity, ROW_WIDTH), and the control words, which contain the number of rows written."""

    rows: np.ndarray
    control: Record  # a CONTROL record


def new_ring(control: Record, capacity: int = CAPACITY) -> Ring:
    """Return an empty ring; capacity must be a power of two."""
    return Ring(np.zeros((capacity, ROW_WIDTH)), control)


@internal
def next_index(ring: Ring) -> int:
    return ring.control.head[0] & (ring.rows.shape[0] - 1)


@internal
def publish(ring: Ring) -> None:
    """Publish the filled row to the readers with a release store."""
    store_release(ring.control.head, 0, ring.control.head[0] + 1)
    fence()


@compiled
def _head(ring):
    fence()
    return load_acquire(ring.control.head, 0)


class RingReader:
    """Reads every row once; ``lost`` counts the rows that were overwritten before they were read."""

    def __init__(self, ring: Ring):
        self._ring = ring
        self._cursor = int(_head(ring))
        self.lost = 0

    def rewind(self, count: int) -> None:
        """Go back by up to ``count`` rows, as far as these are still stored."""
        oldest = max(int(_head(self._ring)) - self._ring.rows.shape[0] + 1, 0)
        self._cursor = max(self._cursor - count, oldest)

    def read(self, most: int = CAPACITY) -> np.ndarray:
        """Return at most ``most`` rows written since the last call: (n, ROW_WIDTH), oldest first."""
        capacity = self._ring.rows.shape[0]
        # The writer may be overwriting the oldest row at this moment, so this row also counts as lost.
        head = int(_head(self._ring))
        first = max(self._cursor, head - capacity + 1)
        stop = min(head, first + most)
        block = self._ring.rows[np.arange(first, stop) % capacity]
        oldest = int(_head(self._ring)) - capacity + 1
        if oldest > first:
            block = block[min(oldest - first, len(block)) :]
        self.lost += stop - self._cursor - len(block)
        self._cursor = stop
        return block

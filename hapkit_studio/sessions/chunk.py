"""A chunk contains some tenths of a second of samples, compressed by column, and extremes for plots."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import ALWAYS, BY_NAME, COLUMN, ON_REQUEST, SIGNALS, Signal
from hapkit_studio.sessions.columns import MOST_WHOLE, DamagedError, decode, encode
from hapkit_studio.sessions.layout import LAYOUT, STATE, Layout

BLOCK = 64
"""Number of samples per block; the extremes of each block are stored."""
MOST_SAMPLES = 1 << 16  # maximum number of samples in a chunk; the recorder writes at most 1,000
MOST_STATES = rows.ROW_WIDTH - rows.STATE
MOST_TIME = 1e9  # maximum time in s since the computer's start: 31 years
_SAME_TIME = 1e-6  # s: resolution of times in a file
_WHOLE = frozenset(signal.name for signal in SIGNALS if signal.whole)


@dataclass(frozen=True)
class Chunk:
    """Consecutive samples: their number, and the times of the first and last in s of the computer's clock.

    ``columns`` has each signal's samples as ``encode`` returns them, or None if the signal was not recorded.
    Its entry "state" has all samples of the law's first state variable, then those of the next one, and so
    on; ``states`` is the number of variables. ``extremes`` has the encoded extremes of every BLOCK samples.
    """

    count: int
    start: float
    stop: float
    states: int
    extremes: bytes
    columns: Mapping[str, bytes | None]
    layout: Layout = LAYOUT

    def values(self, name: str) -> np.ndarray:
        """Return a signal's samples (count,) in SI, NaN if it was not recorded; for STATE, (count, states).

        Raise DamagedError if the data are damaged.
        """
        if name == STATE:
            return (
                decode(self.columns[STATE] or b"", self.states * self.count)
                .reshape(self.states, self.count)
                .T
            )
        data = self.columns.get(name)
        if data is None:
            return np.full(self.count, math.nan)
        values = decode(data, self.count)
        if base := self.layout.delta_to(name):
            return self.values(base) - values
        if name == "time" and not self._in_order(values):
            raise DamagedError(
                f"Between {self.start:g} and {self.stop:g} s, the samples' times are not in order."
            )
        if name in _WHOLE and not np.abs(values).max() < MOST_WHOLE:
            raise DamagedError(f"A value of {name} is too large: {MOST_WHOLE:,} or more.")
        return values

    def _in_order(self, times: np.ndarray) -> bool:
        within = self.start - _SAME_TIME <= times[0] and times[-1] <= self.stop + _SAME_TIME
        return bool(within and (np.diff(times) >= 0.0).all())

    def blocks(self) -> np.ndarray:
        """Return the extremes (signals with extremes, 2, blocks) in SI, as float32.

        Raise DamagedError if the data are damaged.
        """
        blocks, signals = -(-self.count // BLOCK), len(self.layout.with_extremes)
        with np.errstate(over="ignore"):  # a foreign file may contain values that overflow
            found = decode(self.extremes, signals * 2 * blocks).astype(np.float32)
        return found.reshape(signals, 2, blocks)


def pack(table: np.ndarray, quantum: float, states: int, truth: bool = False) -> Chunk:
    """Return telemetry rows (n, ROW_WIDTH), n > 0, as a chunk with the first ``states`` state variables.

    ``quantum`` is the sensor's step in m. If ``truth``, signals recorded only on request are included.
    """
    recorded = (s for s in SIGNALS if s.recorded == ALWAYS or (truth and s.recorded == ON_REQUEST))
    columns = {signal.name: _encoded(table, signal, quantum) for signal in recorded}
    columns[STATE] = encode(table[:, rows.STATE : rows.STATE + states].T.ravel())
    step = BY_NAME["time"].step or 1.0
    # these times are rounded like the samples' times
    start, stop = step * np.rint(table[[0, -1], rows.HOST_TIME] / step)
    extremes = encode(_extremes(table).ravel())
    return Chunk(len(table), float(start), float(stop), states, extremes, columns)


def _encoded(table: np.ndarray, signal: Signal, quantum: float) -> bytes:
    values = table[:, COLUMN[signal.name]]
    if signal.delta_to:
        values = table[:, COLUMN[signal.delta_to]] - values
    if signal.in_counts:
        return encode(values, quantum, rounded=False)
    return encode(values, signal.step or 0.0)


def _extremes(table: np.ndarray) -> np.ndarray:
    drawn = table[:, [COLUMN[name] for name in LAYOUT.with_extremes]].T
    starts = np.arange(0, len(table), BLOCK)
    return np.stack([pick.reduceat(drawn, starts, axis=1) for pick in (np.fmin, np.fmax)], axis=1)

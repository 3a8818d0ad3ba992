"""A chunk: some tenths of a second of samples, compressed column by column, with extremes to draw from."""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.haptics import rows
from hapkit_studio.sessions.columns import BY_NAME, COLUMNS, MOST_WHOLE, Column, DamagedError, decode, encode

BLOCK = 64
"""Samples of which the extremes are kept."""
DRAWN = ("position", "velocity", "asked", "applied", "energy")
"""The columns whose extremes are kept."""
MOST_SAMPLES = 1 << 16  # of a chunk; the recorder's have at most 1,000
MOST_STATES = rows.ROW_WIDTH - rows.STATE
MOST_TIME = 1e9  # s of a computer's clock since it started: 31 years
_SAME_TIME = 1e-6  # s, the step of times in a file
STATE = "state"
EVERY = (*BY_NAME, STATE)
"""The names of all columns."""


@dataclass(frozen=True)
class Chunk:
    """Consecutive samples: how many, when the first and the last came in s of the computer's clock.

    columns hold what ``encode`` made of each, "state" the law's values, ``states`` of them, one after the
    other; extremes those of every BLOCK samples.
    """

    count: int
    start: float
    stop: float
    states: int
    extremes: bytes
    columns: Mapping[str, bytes | None]

    def values(self, name: str) -> np.ndarray:
        """Return a column (count,) in SI, NaN where it was not kept, or the state (count, states).

        Raise DamagedError.
        """
        if name == STATE:
            return (
                decode(self.columns[STATE] or b"", self.states * self.count)
                .reshape(self.states, self.count)
                .T
            )
        data, column = self.columns[name], BY_NAME[name]
        if data is None:
            return np.full(self.count, math.nan)
        values = decode(data, self.count)
        if column.less_than:
            return self.values(column.less_than) - values
        if name == "time" and not self._in_order(values):
            raise DamagedError(f"Its times are not in order from {self.start:g} to {self.stop:g} s.")
        if column.whole and not np.abs(values).max() < MOST_WHOLE:
            raise DamagedError(f"Its {name} goes beyond {MOST_WHOLE:,}.")
        return values

    def _in_order(self, times: np.ndarray) -> bool:
        within = self.start - _SAME_TIME <= times[0] and times[-1] <= self.stop + _SAME_TIME
        return bool(within and (np.diff(times) >= 0.0).all())

    def blocks(self) -> np.ndarray:
        """Return the least and greatest values (len(DRAWN), 2, blocks) in SI, NaN for what is not finite.

        Raise DamagedError.
        """
        blocks = -(-self.count // BLOCK)
        found = decode(self.extremes, len(DRAWN) * 2 * blocks).reshape(len(DRAWN), 2, blocks)
        return np.where(np.isfinite(found), found, math.nan)


def pack(table: np.ndarray, quantum: float, states: int, truth: bool = False) -> Chunk:
    """Return telemetry rows (n, ROW_WIDTH), n > 0, as a chunk; quantum in m, of the law's values so many.

    truth: a simulation's true motion and its hand are kept as well.
    """
    kept: Iterable[Column] = (column for column in COLUMNS if truth or not column.requested)
    columns = {column.name: _encoded(table, column, quantum) for column in kept}
    columns[STATE] = encode(table[:, rows.STATE : rows.STATE + states].T.ravel())
    step = BY_NAME["time"].step or 1.0
    start, stop = step * np.rint(table[[0, -1], rows.HOST_TIME] / step)  # as the samples have it
    extremes = encode(_extremes(table).ravel())
    return Chunk(len(table), float(start), float(stop), states, extremes, columns)


def unpack(chunk: Chunk, names: Collection[str] = EVERY) -> np.ndarray:
    """Return a chunk's telemetry rows (count, ROW_WIDTH) with some columns, NaN in all that was not kept.

    Raise DamagedError.
    """
    table = np.full((chunk.count, rows.ROW_WIDTH), math.nan)
    for name in BY_NAME.keys() & chunk.columns.keys() & set(names):
        table[:, BY_NAME[name].place] = chunk.values(name)
    if STATE in names:
        states = chunk.values(STATE)[:, : rows.ROW_WIDTH - rows.STATE]
        table[:, rows.STATE : rows.STATE + states.shape[1]] = states
    whole = [rows.TICK, rows.FLAGS]
    table[:, whole] = np.nan_to_num(table[:, whole])
    return table


def _encoded(table: np.ndarray, column: Column, quantum: float) -> bytes:
    values = table[:, column.place]
    if column.less_than:
        values = table[:, BY_NAME[column.less_than].place] - values
    if column.counted:
        return encode(values, quantum, rounded=False)
    return encode(values, column.step or 0.0)


def _extremes(table: np.ndarray) -> np.ndarray:
    drawn = table[:, [BY_NAME[name].place for name in DRAWN]].T
    starts = np.arange(0, len(table), BLOCK)
    return np.stack([pick.reduceat(drawn, starts, axis=1) for pick in (np.fmin, np.fmax)], axis=1)

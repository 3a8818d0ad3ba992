"""Samples read from a chunk equal those written, within the precision of each column."""

import contextlib
import warnings

import numpy as np
import pytest

from hapkit_studio.haptics import rows
from hapkit_studio.haptics.signals import COLUMN, NEVER, ON_REQUEST, SIGNALS
from hapkit_studio.sessions.chunk import BLOCK, pack
from hapkit_studio.sessions.columns import DamagedError, decode, encode
from hapkit_studio.sessions.layout import LAYOUT

QUANTUM = 20.7e-6


def table(count: int = 500, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    made = np.zeros((count, rows.ROW_WIDTH))
    made[:, rows.TICK] = 1e9 + np.arange(count)
    made[:, rows.HOST_TIME] = 1e5 + np.cumsum(rng.uniform(5e-4, 2e-3, count))
    made[:, rows.POSITION] = QUANTUM * np.floor(rng.normal(0.0, 500.0, count))
    for column in (rows.VELOCITY, rows.FORCE, rows.ENERGY, *range(rows.STATE, rows.STATE + 3)):
        made[:, column] = rng.normal(size=count)
    made[:, rows.APPLIED_FORCE] = np.clip(made[:, rows.FORCE], -1.0, 1.0)
    made[:, rows.FLAGS] = rng.integers(0, 256, count)
    made[:, rows.LATENESS] = rng.exponential(1e-4, count)
    return made


@pytest.mark.parametrize("count", [1, 2, BLOCK, 1999])
def test_every_column_is_read_back_within_its_precision(count):
    made = table(count)
    chunk = pack(made, QUANTUM, 3, truth=True)
    for signal in SIGNALS:
        if signal.recorded == NEVER:
            continue
        values = made[:, COLUMN[signal.name]]
        most = np.abs(made[:, COLUMN[signal.delta_to or signal.name]]).max()
        within = 0.5 * signal.step if signal.step else 1e-12 if signal.in_counts else most * 2.0**-22
        assert np.abs(chunk.values(signal.name) - values).max() <= within * 1.001, signal
    assert np.allclose(chunk.values("state"), made[:, rows.STATE : rows.STATE + 3], rtol=2e-7)


def test_a_signal_that_was_not_recorded_is_nan():
    chunk = pack(table(), QUANTUM, 3)
    for signal in SIGNALS:
        if signal.recorded == ON_REQUEST:
            assert np.isnan(chunk.values(signal.name)).all()


def test_the_extremes_of_each_block_are_those_of_its_samples():
    made = table(3 * BLOCK + 5)
    blocks = pack(made, QUANTUM, 0).blocks()
    position = made[:, rows.POSITION]
    pieces = np.split(position, [BLOCK, 2 * BLOCK, 3 * BLOCK])
    index = LAYOUT.with_extremes.index("position")
    assert np.allclose(blocks[index, 0], [piece.min() for piece in pieces], rtol=1e-6)
    assert np.allclose(blocks[index, 1], [piece.max() for piece in pieces], rtol=1e-6)


def test_a_position_between_counts_is_stored_exactly():
    made = table()
    made[:, rows.POSITION] += 0.3 * QUANTUM
    back = pack(made, QUANTUM, 0).values("position")
    assert np.abs(back - made[:, rows.POSITION]).max() < 1e-8


def test_non_finite_numbers_are_read_back():
    values = np.array([0.0, np.nan, np.inf, -np.inf])
    assert np.array_equal(decode(encode(values, 1.0), 4), values, equal_nan=True)


def test_steps_of_every_size_are_read_back():
    values = np.cumsum([0, 1, 127, 128, 32767, 32768, 2**31 - 1, 2**31, 2**40, -(2**41)]).astype(float)
    for stop in range(1, len(values) + 1):
        assert np.array_equal(decode(encode(values[:stop], 1.0), stop), values[:stop])


def test_changed_data_are_detected_within_the_memory_limit():
    data = encode(np.arange(1000.0), 1.0)
    for place in range(len(data)):
        damaged = bytearray(data)
        damaged[place] ^= 0x10
        with contextlib.suppress(DamagedError):  # the changed bit may be a padding bit, which carries no data
            assert np.array_equal(decode(bytes(damaged), 1000), np.arange(1000.0))
    with pytest.raises(DamagedError):
        decode(data[:-4], 1000)
    with pytest.raises(DamagedError):
        decode(data, 999)
    with pytest.raises(DamagedError):
        decode(encode(np.zeros(10_000_000)), 100)


def test_numbers_beyond_the_exact_range_of_steps_are_stored_as_floats():
    """The motion diverges, as in an unstable simulation."""
    values = QUANTUM * np.array([0.0, 1.0, 1e16, -1e25])
    for rounded in (True, False):
        assert np.allclose(decode(encode(values, QUANTUM, rounded), 4), values, rtol=1e-7)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.array_equal(decode(encode(np.array([0.0, 1e300]), QUANTUM), 2), [0.0, np.inf])
    exact = np.array([2.0**53 - 1, -(2.0**53) + 1, 0.0])
    assert np.array_equal(decode(encode(exact, 1.0), 3), exact)

"""Every row once, in order; what was overwritten is counted; a row is never half old."""

import threading

import numpy as np
import pytest

from hapkit_studio.haptics import rig, ring, rows
from hapkit_studio.haptics.jit import compiled


@compiled
def write(out, first, count, pause):
    """Publish rows whose every number is their own; pause between them by a share of work."""
    kept = 0.0
    for k in range(first, first + count):
        row = out.rows[ring.next_index(out)]
        for i in range(rows.ROW_WIDTH):
            row[i] = k
        ring.publish(out)
        for i in range(pause):
            kept += i
            row[0] = k + 0.0 * kept
    return kept


def new_ring(capacity=64):
    return ring.new_ring(np.zeros(rig.CONTROL, dtype=np.int64), capacity)


def test_rows_come_once_and_in_order_round_and_round():
    out = new_ring()
    reader = ring.RingReader(out)
    seen, at = [], 0
    for count in (0, 1, 5, 63, 62, 30, 33, 1, 63):
        write(out, at, count, 0)
        at += count
        seen.append(reader.read()[:, 0])
        assert len(seen[-1]) == count
    np.testing.assert_array_equal(np.concatenate(seen), np.arange(at))
    assert reader.lost == 0


@pytest.mark.parametrize("count", [64, 65, 100, 1000])
def test_an_overrun_is_counted(count):
    out = new_ring()
    reader = ring.RingReader(out)
    write(out, 0, count, 0)
    found = reader.read()[:, 0]
    np.testing.assert_array_equal(found, np.arange(count - 63, count))
    assert reader.lost == count - 63
    write(out, count, 3, 0)
    np.testing.assert_array_equal(reader.read()[:, 0], np.arange(count, count + 3))
    assert reader.lost == count - 63


def test_each_reader_has_its_own_cursor():
    out = new_ring()
    early = ring.RingReader(out)
    write(out, 0, 5, 0)
    late = ring.RingReader(out)
    write(out, 5, 5, 0)
    assert len(late.read()) == 5
    assert len(early.read()) == 10
    assert len(early.read()) == 0


def test_what_was_read_does_not_change_any_more():
    out = new_ring()
    reader = ring.RingReader(out)
    write(out, 0, 10, 0)
    block = reader.read()
    write(out, 10, 100, 0)
    np.testing.assert_array_equal(block[:, 5], np.arange(10))


@pytest.mark.parametrize(("capacity", "pause"), [(64, 0), (256, 300), (4096, 300)])
def test_a_writer_at_full_speed(capacity, pause):
    out, count = new_ring(capacity), 100_000
    write(new_ring(), 0, 1, 0)
    reader = ring.RingReader(out)
    writer = threading.Thread(target=write, args=(out, 0, count, pause))
    writer.start()
    blocks = []
    while writer.is_alive():
        blocks.append(reader.read())
    blocks.append(reader.read())
    found = np.concatenate(blocks)
    assert len(found) + reader.lost == count
    assert len(found) > 0
    assert np.all(np.diff(found[:, 0]) > 0.0)
    np.testing.assert_array_equal(found[:, 1:], np.repeat(found[:, :1], rows.ROW_WIDTH - 1, axis=1))

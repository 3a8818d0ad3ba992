"""Every row is read once, in order; overwritten rows are counted; a row is never torn."""

import threading

import numpy as np
import pytest

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import arrays, rows
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.record import zeros


@compiled
def write(out, first, count):
    """Publish rows in which every number is the row's index."""
    for k in range(first, first + count):
        row = out.rows[rows.next_index(out)]
        for i in range(rows.ROW_WIDTH):
            row[i] = k
        rows.publish(out)


@compiled
def write_on(out, pause):
    """Publish rows until told to stop; the random pauses last as long as up to ``pause`` reads of a word."""
    k = 0
    while load_acquire(out.control.quit, 0) == 0:
        write(out, k, 1)
        k += 1
        for _ in range(k * 37 % pause):
            load_acquire(out.control.quit, 0)


def new_ring(capacity=64):
    return rows.new_ring(zeros(arrays.CONTROL), capacity)


def test_rows_are_read_once_and_in_order_over_every_wrap():
    out = new_ring()
    reader = rows.RingReader(out)
    seen, at = [], 0
    for count in (0, 1, 5, 63, 62, 30, 33, 1, 63):
        write(out, at, count)
        at += count
        seen.append(reader.read()[:, 0])
        assert len(seen[-1]) == count
    np.testing.assert_array_equal(np.concatenate(seen), np.arange(at))
    assert reader.lost == 0


@pytest.mark.parametrize("count", [64, 65, 100, 1000])
def test_overwritten_rows_are_counted(count):
    out = new_ring()
    reader = rows.RingReader(out)
    write(out, 0, count)
    found = reader.read()[:, 0]
    np.testing.assert_array_equal(found, np.arange(count - 63, count))
    assert reader.lost == count - 63
    write(out, count, 3)
    np.testing.assert_array_equal(reader.read()[:, 0], np.arange(count, count + 3))
    assert reader.lost == count - 63


def test_reading_a_few_rows_at_a_time_gives_all_and_losses_count_once():
    out = new_ring()
    reader = rows.RingReader(out)
    write(out, 0, 100)
    parts = [reader.read(25)[:, 0] for _ in range(4)]
    assert [len(part) for part in parts] == [25, 25, 13, 0]
    np.testing.assert_array_equal(np.concatenate(parts), np.arange(37, 100))
    assert reader.lost == 37


def test_each_reader_has_its_own_cursor():
    out = new_ring()
    early = rows.RingReader(out)
    write(out, 0, 5)
    late = rows.RingReader(out)
    write(out, 5, 5)
    assert len(late.read()) == 5
    assert len(early.read()) == 10
    assert len(early.read()) == 0


@pytest.mark.slow
@pytest.mark.parametrize(("capacity", "pause"), [(64, 10), (256, 300), (4096, 300)])
def test_rows_are_whole_while_a_writer_never_pauses(capacity, pause):
    out = new_ring(capacity)
    out.control.quit[0] = 1
    write_on(out, pause)
    out.control.quit[0] = 0
    reader = rows.RingReader(out)
    writer = threading.Thread(target=write_on, args=(out, pause))
    writer.start()
    blocks = []
    while sum(len(block) > 0 for block in blocks) < 60:
        blocks.append(reader.read())
    store_release(out.control.quit, 0, 1)
    writer.join()
    blocks.append(reader.read())
    found = np.concatenate(blocks)
    assert len(found) + reader.lost == out.control.head[0]
    assert np.all(np.diff(found[:, 0]) > 0.0)
    np.testing.assert_array_equal(found[:, 1:], np.repeat(found[:, :1], rows.ROW_WIDTH - 1, axis=1))


def test_a_reader_can_go_back_to_stored_rows():
    out = new_ring()
    write(out, 0, 40)
    reader = rows.RingReader(out)
    reader.rewind(10)
    np.testing.assert_array_equal(reader.read()[:, 0], np.arange(30, 40))
    reader.rewind(1000)
    np.testing.assert_array_equal(reader.read()[:, 0], np.arange(40))
    write(out, 40, 200)
    reader = rows.RingReader(out)
    reader.rewind(1000)
    np.testing.assert_array_equal(reader.read()[:, 0], np.arange(240 - 63, 240))
    assert reader.lost == 0

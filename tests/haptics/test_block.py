"""Blocks of parameters, and words with acquire and release ordering, are read correctly during writes."""

import threading

import numpy as np
import pytest

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import arrays, block, tick
from hapkit_studio.haptics.clib import load_acquire, store_release

STOP = 0
WANTED = 5000


@compiled
def fill(settings, program, k):
    """Set the first and last numbers of a block, and all numbers of its board law, to k."""
    for i in range(block.PARAMS):
        settings.params[i] = k
    for i in range(block.PROGRAM_WORDS):
        program[i] = k
    settings.period = settings.hand_target = k
    settings.law = settings.program_id = settings.board_moving = k
    settings.n_params = 0


@compiled
def publish_same(shared, new, k):
    """Publish a block with all numbers equal to k."""
    fill(new.settings, new.program, k)
    block.publish(shared, new)


@compiled
def hammer(shared, new, control):
    """Publish increasing numbers, with pauses of random length, until told to stop."""
    k = 1
    while load_acquire(control, STOP) == 0:
        k += 1
        publish_same(shared, new, k)
        for _ in range(k * 37 % 251):
            load_acquire(control, STOP)


@compiled
def is_whole(settings, program):
    """Return True if all numbers of a block are equal."""
    k = settings.board_moving
    for i in range(block.PROGRAM_WORDS):
        if program[i] != k:
            return False
    for i in range(block.PARAMS):
        if settings.params[i] != k:
            return False
    ends = settings.period == k and settings.hand_target == k
    return ends and settings.law == k and settings.program_id == k


@compiled
def listen(shared, copy, wanted):
    """Read ``wanted`` blocks; return how many were torn, and how many were older than the one read before."""
    torn = backwards = 0
    newest = 0.0
    while wanted > 0:
        if block.take(shared, copy):
            wanted -= 1
            torn += not is_whole(copy.settings, copy.program)
            backwards += copy.settings.params[0] < newest
            newest = copy.settings.params[0]
    return torn, backwards


@compiled
def adopt_many(r, wanted):
    """Copy new blocks into the loop's arrays, as the tick does, until ``wanted`` blocks have arrived.

    Return how many of these blocks were torn.
    """
    torn = 0
    last = r.settings.params[0]
    while wanted > 0:
        r.tick.blend = 1.0
        tick.adopt(r, 0.0)
        torn += not is_whole(r.settings, r.program)
        wanted -= r.settings.params[0] != last
        last = r.settings.params[0]
    return torn


@pytest.fixture
def shared():
    """Return a block with every number 1."""
    made = block.new_block()
    publish_same(made, block.new_block(), 1)
    return made


@pytest.mark.slow
def test_a_reader_and_the_loop_see_whole_blocks_in_order(shared):
    control = np.ones(8, dtype=np.int64)
    hammer(shared, block.new_block(), control)
    control[STOP] = 0
    writer = threading.Thread(target=hammer, args=(shared, block.new_block(), control))
    writer.start()
    try:
        assert listen(shared, block.new_block(), WANTED) == (0, 0)
        assert adopt_many(arrays.new_arrays(shared), WANTED // 10) == 0
    finally:
        store_release(control, STOP, 1)
        writer.join()


def test_the_newest_block_wins_and_the_reader_does_not_wait_for_the_writer(shared):
    for k in range(2, 6):
        publish_same(shared, block.new_block(), k)
    copy = block.new_block()
    assert block.take(shared, copy)
    assert copy.settings.params[0] == 5.0
    shared.sequence[0] += 1
    assert not block.take(shared, copy)


def test_the_boards_law_is_copied_only_if_it_has_changed(shared):
    copy = block.new_block()
    assert block.take(shared, copy)
    copy.program[:] = -1
    assert block.take(shared, copy)
    assert (copy.program == -1).all()
    publish_same(shared, block.new_block(), 2)
    assert block.take(shared, copy)
    assert (copy.program == 2).all()


@compiled
def send_pairs(words, count):
    """Write data and then a sequence number, many times; wait each time until the reader confirms it."""
    for k in range(1, count + 1):
        words[8] = 3 * k
        store_release(words, 0, k)
        while load_acquire(words, 16) != k:
            pass


@compiled
def take_pairs(words, count):
    """Return how often a sequence number was visible before its data."""
    missing = 0
    for k in range(1, count + 1):
        while load_acquire(words, 0) != k:
            pass
        missing += words[8] != 3 * k
        store_release(words, 16, k)
    return missing


def test_earlier_writes_are_visible_first():
    words = np.zeros(24, dtype=np.int64)
    send_pairs(words, 0)
    take_pairs(words, 0)
    writer = threading.Thread(target=send_pairs, args=(words, 100))
    writer.start()
    assert take_pairs(words, 100) == 0
    writer.join()

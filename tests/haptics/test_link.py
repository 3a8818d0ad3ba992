"""A serial link: its delays; what is too slow, lost or silent is noticed at once, said, and counted."""

import re

import numpy as np
import pytest

from hapkit_studio.analysis.stability import on_board
from hapkit_studio.haptics import arrays, link, rows, tick
from hapkit_studio.protocol.messages import BoardFlag, Stop
from tests.haptics.serial_support import sample
from tests.haptics.support import BROKEN, CONSTANT, LoopHarness


def lateness(conn, now, board_time):
    """Return how late the row of a frame is that came now."""
    row = np.zeros(rows.ROW_WIDTH)
    link.write_times(conn, board_time, row, now)
    return row[rows.LATENESS]


def test_a_frame_is_late_by_what_the_boards_clock_did_not_pass():
    conn = link.new_link(1.0)
    # prompt, prompt, held up 3 ms, queued behind it, after a lost one but on time, a board that stood
    arrivals = (50.0, 1.0), (50.001, 1.001), (50.005, 1.002), (50.005, 1.003), (50.007, 1.005), (50.5, 1.006)
    lates = [lateness(conn, *arrival) for arrival in arrivals]
    assert lates == pytest.approx([0.0, 0.0, 0.003, 0.0, 0.0, 0.492])


def test_silence_of_a_second_means_gone_unless_nothing_was_heard_or_the_computer_was_away():
    r = LoopHarness(CONSTANT).r

    def passes(conn):
        return [link.board_gone(r, conn, 54.0 + k * 0.020) for k in range(1, 61)]

    def heard():
        conn = link.new_link(1.0)
        lateness(conn, 54.0, 1.0)
        link.board_gone(r, conn, 54.0)
        conn.numbers[link.QUIET] = 0.0
        return conn

    assert not any(passes(link.new_link(1.0)))
    conn = heard()
    assert not link.board_gone(r, conn, 100.0)
    assert conn.numbers[link.QUIET] == pytest.approx(0.040)
    assert r.control[arrays.FAULT] == arrays.NO_FAULT
    said = passes(heard())
    assert not any(said[:49])
    assert all(said[51:])
    assert (r.control[arrays.FAULT], r.real[arrays.FAULT_VALUE]) == (arrays.DEVICE_GONE, link.GONE_AFTER)


OFF = int(BoardFlag.WATCHDOG)


def late(seq, by, **fields):
    """Return a sample whose force answers one so many before."""
    return sample(seq, 1000, answered=seq - 1 - by, delay_us=min(1000 * by + 600, 65_535), **fields)


def told_late(board, engine, by, most=300):
    """Send samples in which forces come too late by so many, until a fault; return how many it took."""
    for k in range(most):
        board.say(late(100 + k, by))
        if engine.fault is not None:
            return k
    return most


def test_a_link_slower_than_the_watchdog_stops_the_force_in_words(stepped):
    board, engine = stepped(environment=CONSTANT)
    assert 4 <= told_late(board, engine, 33, 20_000) < 20_000
    assert engine.fault.code == arrays.SLOW_LINK
    assert engine.fault.text == "Fault: 34 ms from a sample to its force; the board obeys none after 25 ms."
    assert "Let the board render" in engine.fault.detail
    assert board.say(sample(20_000))[-1, rows.APPLIED] == 0.0


@pytest.mark.parametrize(("by", "added"), [(23, 0.0), (40, 0.02)])
def test_a_link_within_the_watchdog_is_none_nor_is_an_added_delay_the_links(stepped, by, added):
    assert told_late(*stepped(environment=CONSTANT, delay=added), by) == 300


def test_some_late_answers_are_no_slow_link(stepped):
    """Bytes held back and let go of: the delay falls within milliseconds."""
    board, engine = stepped(environment=CONSTANT)
    board.say(b"".join(late(100 + k, by) for k, by in enumerate(range(300, 0, -10))))
    assert engine.fault is None


def test_a_board_that_cuts_its_motor_off_is_told_from_a_silent_one(stepped):
    board, engine = stepped(environment=CONSTANT)
    board.say_one_by_one(sample(k) for k in range(40))
    found = board.say_one_by_one(sample(40 + k, flags=OFF) for k in range(3))
    assert np.all(found[:, rows.FLAGS].astype(int) & rows.STALE)
    health = engine.health()
    assert (health.link.cut, health.link.no_sample, health.link.away) == (1, 0, 0)


def test_a_board_whose_motor_never_comes_on_is_not_taken_for_one_that_renders(stepped):
    board, engine = stepped(environment=CONSTANT)
    found = board.say_one_by_one(sample(k, flags=OFF) for k in range(320))
    assert not int(found[100, rows.FLAGS]) & rows.STALE
    assert int(found[-1, rows.FLAGS]) & rows.STALE
    assert engine.health().link.cut == 1


def test_silence_is_the_lines(stepped):
    board, engine = stepped(environment=CONSTANT)
    board.say_one_by_one(sample(k) for k in range(10))
    board.fall_silent()
    found = engine.health().link
    assert (found.no_sample, found.away, found.held_up, found.cut) == (1, 0, 0, 0)


@pytest.mark.parametrize(
    ("long", "looked", "answered", "cause"),
    [
        (0, 9.985, 9.97, arrays.NO_SAMPLE),
        (0, 9.90, 9.89, arrays.AWAY),
        (0, 9.96, 9.97, arrays.AWAY),
        (20, 9.96, 9.97, arrays.HELD_UP),
    ],
)
def test_why_nothing_was_answered(long, looked, answered, cause):
    harness, conn = LoopHarness(CONSTANT), link.new_link(2e-5)
    conn.numbers[link.LOOKED_AT], conn.numbers[link.LAST_ANSWER] = looked, answered
    conn.words[link.STARTED], harness.r.word[arrays.LONG] = 1, long
    link.note_gap(harness.r, conn, 10.0)
    assert harness.r.control[arrays.STALE_CAUSES + cause] == 1


def test_a_law_too_slow_for_its_rate_latches_and_a_busy_moment_does_not():
    harness = LoopHarness(BROKEN, {"how": "nan"})
    harness.tick(0.0)
    for _ in range(3):
        for _ in range(tick.MOST_LONG - 1):
            tick.note_time(harness.r, 1.3e-3)
        tick.note_time(harness.r, 0.2e-3)
    assert harness.r.control[arrays.FAULT] == arrays.NO_FAULT
    for _ in range(tick.MOST_LONG):
        tick.note_time(harness.r, 1.3e-3)
    assert harness.r.control[arrays.FAULT] == arrays.SLOW_LAW


def test_what_the_board_counts_is_added_up(rendering):
    """Forces refused, frames not read, and a motor that goes off while the board renders."""
    setup = rendering()
    setup.sample = {"stale": 250, "rx_errors": 9}
    setup.run(2)
    setup.sample = {"stale": 4, "rx_errors": 12}
    setup.run(2)
    found = setup.engine.health().link
    assert (found.stale_forces, found.board_errors) == (10, 3)
    setup.go()
    setup.run(5)
    setup.telemetry = {"flags": OFF}
    assert all(int(row[rows.FLAGS]) & rows.STALE for row in setup.run(4))
    assert setup.engine.health().link.cut == 1


def test_a_slow_link_is_none_for_the_board(rendering):
    setup = rendering(values={"stiffness": 100.0})
    setup.run(5)
    setup.engine.arrays.control[arrays.FAULT] = arrays.SLOW_LINK
    assert setup.engine.board_refusal(wait=True) == ""
    setup.engine.set_where("board")
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.engine.fault is None
    assert not setup.told(Stop)


def test_what_a_link_allows_is_said_where_it_is_too_little(rendering):
    setup = rendering(values={"stiffness": 100.0})
    assert on_board.link_warning(setup.engine) == on_board.UNKNOWN
    setup.run(40)
    assert on_board.link_warning(setup.engine) == ""
    setup.engine.set_parameter("stiffness", 2000.0)
    words = on_board.link_warning(setup.engine)
    assert words.startswith("The measured delay is 0.5 ms. In your hand: calm")
    assert re.search(r"Let go: settles below 0\.\d+ mm, buzzes above\. Lower the stiffness, or let", words)
    assert on_board.rendering_rate(setup.engine, "computer") == 1000.0

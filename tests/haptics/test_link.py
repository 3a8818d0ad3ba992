"""A link that is too slow, or loses what it carries: noticed at once, said with its cause, and counted."""

import numpy as np
import pytest

from hapkit_studio.analysis.stability import on_board
from hapkit_studio.haptics import arrays, link, rows, tick
from hapkit_studio.protocol.messages import BoardFlag, Stop
from tests.haptics.board_support import undisturbed as with_desk
from tests.haptics.serial_support import read, sample, undisturbed
from tests.haptics.support import BROKEN, CONSTANT, Bench
from tests.waiting import wait_until

OFF = int(BoardFlag.WATCHDOG)


def late(seq, by, **fields):
    """Return a sample whose force answers one so many before."""
    return sample(seq, 1000, answered=seq - 1 - by, delay_us=min(1000 * by + 600, 65_535), **fields)


def say_in_time(board, reader, frames):
    """Send frames one by one, each as soon as the one before is shown."""
    found = []
    for frame in frames:
        board.say(frame)
        found.append(read(reader, 1))
    return np.concatenate(found)


def told_late(board, reader, by, engine, most=600):
    """Send samples in which forces come too late by so many, until a fault; return how many it took."""
    for k in range(100, 100 + most):
        say_in_time(board, reader, [late(k, by)])
        if engine.fault is not None:
            return k - 100
    return most


@undisturbed(environment=CONSTANT)
def test_a_link_slower_than_the_watchdog_stops_the_force_in_words(board, engine, reader):
    count = told_late(board, reader, 33, engine, 10_000)
    assert engine.fault.code == arrays.SLOW_LINK
    assert engine.fault.text == "Fault: 34 ms from a sample to its force; the board obeys none after 25 ms."
    assert "Let the board render" in engine.fault.detail
    assert count >= 4
    assert read(reader, 0) is not None
    board.say(sample(20_000, 1000))
    assert read(reader, 1)[-1, rows.APPLIED] == 0.0


@undisturbed(environment=CONSTANT)
def test_a_link_within_the_watchdog_is_none(board, engine, reader):
    assert told_late(board, reader, 23, engine) == 600


@undisturbed(environment=CONSTANT, delay=0.02)
def test_an_added_delay_is_not_the_link_s(board, engine, reader):
    assert told_late(board, reader, 40, engine) == 600


@undisturbed(environment=CONSTANT)
def test_some_late_answers_are_no_slow_link(board, engine, reader):
    """Bytes held back and let go of: the delay falls within milliseconds."""
    frames = [late(100 + k, by) for k, by in enumerate(range(300, 0, -10))]
    say_in_time(board, reader, frames)
    assert engine.fault is None


@undisturbed(environment=CONSTANT)
def test_a_board_that_cuts_its_motor_off_is_told_from_a_silent_one(board, engine, reader):
    say_in_time(board, reader, [sample(k, 1000) for k in range(40)])
    found = say_in_time(board, reader, [sample(40 + k, 1000, flags=OFF) for k in range(3)])
    assert np.all(found[:, rows.FLAGS].astype(int) & rows.STALE)
    health = engine.health()
    assert (health.link.cut, health.link.no_sample, health.link.away) == (1, 0, 0)


@undisturbed(environment=CONSTANT)
def test_a_board_whose_motor_never_comes_on_is_not_taken_for_one_that_renders(board, engine, reader):
    found = say_in_time(board, reader, [sample(k, 1000, flags=OFF) for k in range(320)])
    assert not int(found[100, rows.FLAGS]) & rows.STALE
    assert int(found[-1, rows.FLAGS]) & rows.STALE
    assert engine.health().link.cut == 1


@undisturbed(environment=CONSTANT)
def test_silence_is_the_line_s_and_a_long_pass_the_computer_s(board, engine, reader):
    say_in_time(board, reader, [sample(k, 1000) for k in range(10)])
    wait_until(lambda: engine.health().stale)
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
    bench, conn = Bench(CONSTANT), link.new_link(2e-5)
    conn.numbers[link.LOOKED_AT], conn.numbers[link.LAST_ANSWER] = looked, answered
    conn.words[link.STARTED], bench.r.word[arrays.LONG] = 1, long
    link.note_gap(bench.r, conn, 10.0)
    assert bench.r.control[arrays.STALE_CAUSES + cause] == 1


def test_a_law_too_slow_for_its_rate_latches_and_a_busy_moment_does_not():
    bench = Bench(BROKEN, {"how": "nan"})
    bench.tick(0.0)
    for _ in range(3):
        for _ in range(tick.MOST_LONG - 1):
            tick.note_time(bench.r, 1.3e-3)
        tick.note_time(bench.r, 0.2e-3)
    assert bench.r.control[arrays.FAULT] == arrays.NO_FAULT
    for _ in range(tick.MOST_LONG):
        tick.note_time(bench.r, 1.3e-3)
    assert bench.r.control[arrays.FAULT] == arrays.SLOW_LAW


@with_desk()
def test_what_the_board_counts_is_added_up(desk):
    desk.sample = {"stale": 250, "rx_errors": 9}
    desk.run(2)
    desk.sample = {"stale": 4, "rx_errors": 12}
    desk.run(2)
    found = desk.engine.health().link
    assert (found.stale_forces, found.board_errors) == (10, 3)


@with_desk()
def test_a_motor_that_goes_off_while_the_board_renders_is_counted(desk):
    desk.go()
    desk.run(5)
    desk.telemetry = {"flags": OFF}
    found = desk.run(4)
    assert all(int(row[rows.FLAGS]) & rows.STALE for row in found)
    assert desk.engine.health().link.cut == 1


@with_desk(values={"stiffness": 100.0})
def test_a_slow_link_is_none_for_the_board(desk):
    desk.run(5)
    desk.engine.arrays.control[arrays.FAULT] = arrays.SLOW_LINK
    assert desk.engine.board_refusal(wait=True) == ""
    desk.engine.set_where("board")
    desk.until(lambda: desk.engine.rendering == "board")
    assert desk.engine.fault is None
    assert not desk.told(Stop)


@with_desk(values={"stiffness": 100.0})
def test_what_a_link_allows_is_said_where_it_is_too_little(desk):
    assert on_board.link_warning(desk.engine) == on_board.UNKNOWN
    desk.run(40)
    assert on_board.link_warning(desk.engine) == ""
    desk.engine.set_parameter("stiffness", 2000.0)
    words = on_board.link_warning(desk.engine)
    limit = on_board.rendering_limit(desk.engine, "computer")
    assert words.startswith(f"The measured delay of 0.5 ms allows {limit:,.0f} N/m at most")
    assert words.endswith(
        "2,000 N/m are in force: it may swing. Lower the stiffness, or let the board render."
    )
    assert on_board.rendering_rate(desk.engine, "computer") == 1000.0

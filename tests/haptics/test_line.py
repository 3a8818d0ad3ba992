"""What the serial drivers share, alone."""

import math

import pytest

from hapkit_studio.haptics import link


def test_a_frame_is_late_by_what_the_boards_clock_did_not_pass():
    conn = link.new_link(1.0)
    lates = [
        link.lateness(conn, *arrival)
        # prompt, prompt, held up 3 ms, queued behind it, after a lost one but on time, a board that stood
        for arrival in [
            (50.0, 1.0),
            (50.001, 1.001),
            (50.005, 1.002),
            (50.005, 1.003),
            (50.007, 1.005),
            (50.5, 1.006),
        ]
    ]
    assert lates == pytest.approx([0.0, 0.0, 0.003, 0.0, 0.0, 0.492])
    assert all(math.isfinite(late) for late in lates)


def passes(conn, start, count, apart):
    """Look so many times in a row whether the board is silent; return what was said."""
    return [link.silent_too_long(conn, start + k * apart) for k in range(1, count + 1)]


def heard():
    """Return a connection that got a frame at 54 s and looked then."""
    conn = link.new_link(1.0)
    link.lateness(conn, 54.0, 1.0)
    link.silent_too_long(conn, 54.0)
    conn.numbers[link.QUIET] = 0.0
    return conn


def test_a_board_that_was_heard_is_gone_after_a_second_of_silence():
    said = passes(heard(), 54.0, 60, 0.020)
    assert not any(said[:49])
    assert all(said[51:])


def test_a_board_that_was_never_heard_is_not_gone():
    assert not any(passes(link.new_link(1.0), 54.0, 60, 0.020))


def test_a_computer_that_was_away_does_not_take_that_for_the_boards_silence():
    conn = heard()
    assert not link.silent_too_long(conn, 100.0)
    assert conn.numbers[link.QUIET] == pytest.approx(0.040)

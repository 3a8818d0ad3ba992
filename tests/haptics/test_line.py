"""What the serial drivers share, alone."""

import math

import pytest

from hapkit_studio.haptics import line


def test_a_frame_is_late_by_what_the_boards_clock_did_not_pass():
    conn = line.new_line(1.0)
    lates = [
        line.lateness(conn, *arrival)
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

"""A serial link's delays are measured; slow, lossy and silent links are detected, reported and counted."""

import re

import numpy as np
import pytest

from hapkit_studio.analysis.stability import on_board
from hapkit_studio.haptics import arrays, link, rows
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.messages import BoardFlag, Stop
from tests.haptics.serial_support import sample
from tests.haptics.support import CONSTANT, LoopHarness


def lateness(conn, now, board_time):
    """Return the lateness of the row of a frame that arrives at the computer's time ``now``."""
    row = np.zeros(rows.ROW_WIDTH)
    link.write_times(conn, board_time, row, now)
    return row[rows.LATENESS]


def test_a_frames_lateness_is_its_delay_beyond_the_boards_clock():
    conn = link.new_link(1.0)
    # the frames are on time, on time, delayed by 3 ms, queued after the delayed one, on time after a lost
    # one, and on time after the board has paused
    arrivals = (50.0, 1.0), (50.001, 1.001), (50.005, 1.002), (50.005, 1.003), (50.007, 1.005), (50.5, 1.006)
    lates = [lateness(conn, *arrival) for arrival in arrivals]
    assert lates == pytest.approx([0.0, 0.0, 0.003, 0.0, 0.0, 0.492])


def test_a_second_of_silence_means_disconnected_unless_no_frame_came_before_or_the_computer_was_suspended():
    r = LoopHarness(CONSTANT).r

    def passes(conn):
        return [link.board_gone(r, conn, 54.0 + k * 0.020) for k in range(1, 61)]

    def heard():
        conn = link.new_link(1.0)
        lateness(conn, 54.0, 1.0)
        link.board_gone(r, conn, 54.0)
        conn.state.quiet = 0.0
        return conn

    assert not any(passes(link.new_link(1.0)))
    conn = heard()
    assert not link.board_gone(r, conn, 100.0)
    assert conn.state.quiet == pytest.approx(0.040)
    assert r.control.fault[0] == arrays.NO_FAULT
    row = passes(heard())
    assert not any(row[:49])
    assert all(row[51:])
    assert (r.control.fault[0], r.tick.fault_value) == (arrays.DEVICE_GONE, link.GONE_AFTER)


OFF = int(BoardFlag.WATCHDOG)


def late(seq, by, **fields):
    """Return a sample that reports a force computed from a sample that is ``by`` periods too old."""
    return sample(seq, 1000, answered=seq - 1 - by, delay_us=min(1000 * by + 600, 65_535), **fields)


def told_late(board, engine, by, most=300):
    """Send samples that report late forces, until a fault occurs; return their number."""
    for k in range(most):
        board.send(late(100 + k, by))
        if engine.fault is not None:
            return k
    return most


def test_a_link_slower_than_the_watchdog_stops_the_force_with_a_message(stepped):
    board, engine = stepped(environment=CONSTANT)
    assert 4 <= told_late(board, engine, 33, 20_000) < 20_000
    assert engine.fault.code == arrays.SLOW_LINK
    assert (
        engine.fault.text
        == "Fault: a force came 34 ms after its sample; the board rejects forces older than 25 ms."
    )
    assert "Let the board render" in engine.fault.detail
    assert board.send(sample(20_000))[-1, rows.APPLIED_FORCE] == 0.0


@pytest.mark.parametrize(("by", "added"), [(23, 0.0), (40, 0.02)])
def test_a_link_within_the_watchdog_time_is_accepted_and_added_delay_does_not_count(stepped, by, added):
    assert told_late(*stepped(environment=CONSTANT, delay=added), by) == 300


def test_a_few_late_answers_are_not_a_slow_link(stepped):
    """After a pause, delayed bytes arrive together, and the delay becomes normal within milliseconds."""
    board, engine = stepped(environment=CONSTANT)
    board.send(b"".join(late(100 + k, by) for k, by in enumerate(range(300, 0, -10))))
    assert engine.fault is None


def test_a_board_that_switches_its_motor_off_is_distinguished_from_a_silent_one(stepped):
    board, engine = stepped(environment=CONSTANT)
    board.say_one_by_one(sample(k) for k in range(40))
    found = board.say_one_by_one(sample(40 + k, flags=OFF) for k in range(3))
    assert np.all(found[:, rows.FLAGS].astype(int) & rows.STALE)
    health = engine.health()
    assert (health.link.cut, health.link.no_sample, health.link.away) == (1, 0, 0)


def test_a_board_whose_motor_never_switches_on_does_not_count_as_rendering(stepped):
    board, engine = stepped(environment=CONSTANT)
    found = board.say_one_by_one(sample(k, flags=OFF) for k in range(320))
    assert not int(found[100, rows.FLAGS]) & rows.STALE
    assert int(found[-1, rows.FLAGS]) & rows.STALE
    assert engine.health().link.cut == 1


def test_silence_is_attributed_to_the_line(stepped):
    board, engine = stepped(environment=CONSTANT)
    board.say_one_by_one(sample(k) for k in range(10))
    board.fall_silent()
    found = engine.health().link
    assert (found.no_sample, found.away, found.law_blocked, found.cut) == (1, 0, 0, 0)


@pytest.mark.parametrize(
    ("fault", "looked", "answered", "cause"),
    [
        (arrays.NO_FAULT, 9.985, 9.97, arrays.NO_SAMPLE),
        (arrays.NO_FAULT, 9.90, 9.89, arrays.AWAY),
        (arrays.NO_FAULT, 9.96, 9.97, arrays.AWAY),
        (arrays.SLOW_LAW, 9.96, 9.97, arrays.LAW_BLOCKED),
    ],
)
def test_a_missing_answer_has_a_reason(fault, looked, answered, cause):
    harness, conn = LoopHarness(CONSTANT), link.new_link(2e-5)
    conn.state.read_at, conn.state.last_answer = looked, answered
    conn.state.started, harness.r.control.fault[0] = 1, fault
    link.note_gap(harness.r, conn, 10.0)
    assert harness.r.control.stale_causes[cause] == 1


# --- the board's clock
def at(seq, time_us, **fields):
    """Return the frame of a sample at a time of the board's clock in µs."""
    return sample(seq, time_us=time_us & 0xFFFFFFFF, **fields)


def times(found):
    """Return the board times of rows in µs."""
    return np.round(1e6 * found[:, rows.BOARD_TIME]).astype(int).tolist()


@pytest.mark.parametrize("step", [-5_000_000, -1, 0, 2_000, 60_000_000, 2_000_000_000])
def test_a_clock_that_goes_back_stops_or_jumps_ahead_is_corrected_and_counted(stepped, step):
    """A step of 2 ms instead of 1 ms is no clock jump, because the board may have skipped a sample."""
    board, engine = stepped(environment=CONSTANT)
    board.say_one_by_one(at(k, 1000 * k) for k in range(40))
    assert board.answer_to(39).force == 1.0
    first = 39_000 + step
    found = board.say_one_by_one(at(40 + k, first + 1000 * k) for k in range(135))
    plausible = step == 2_000
    assert times(found) == [1000 * (40 + plausible + k) for k in range(135)]
    assert engine.health().link.clock_jumps == engine.clock_jumps == (0 if plausible else 1)
    assert int(found[0, rows.FLAGS]) & rows.GAP
    gains = np.ones(135) if plausible else np.clip((np.arange(135) - 99) / 30.0, 0.0, 1.0)
    np.testing.assert_allclose(found[:, rows.APPLIED_FORCE], gains, atol=1e-9)
    assert engine.fault is None


@pytest.mark.parametrize(("more", "lost", "jumps"), [(0.0999, 0, 0), (0.1001, 0, 1), (0.5, 500, 0)])
def test_a_clock_may_run_ahead_by_a_tenth_of_a_second_and_by_lost_samples(more, lost, jumps):
    r, conn, frame = LoopHarness(CONSTANT).r, link.new_link(1.0), np.zeros(codec.SAMPLE_WIDTH)
    r.settings.period = 1e-3
    for now, time, frame[codec.LOST] in ((10.0, 1.0, 0), (10.001, 1.001 + more, lost)):
        frame[codec.BOARD_TIME] = time
        link.check_clock(r, conn, frame, now)
    assert r.control.stale_causes[arrays.CLOCK_JUMP] == jumps
    assert frame[codec.BOARD_TIME] == pytest.approx(1.001 if jumps else 1.001 + more)


def test_a_clock_that_wraps_or_runs_on_while_the_computer_is_suspended_has_not_jumped(stepped):
    board, engine = stepped(environment=CONSTANT)
    begin = (1 << 32) - 5_000
    found = board.say_one_by_one(at(k, begin + 1000 * k) for k in range(10))
    assert times(found) == [begin + 1000 * k for k in range(10)]
    state = engine.driver.conn.state
    state.clock_at -= 3.0
    state.clock_ahead -= 3.0  # the computer's and the board's clock have advanced by 3 s
    found = board.send(at(10, begin + 3_010_000))
    assert times(found) == [begin + 3_010_000]
    assert engine.clock_jumps == 0


def test_a_clock_that_jumps_three_times_latches_and_every_jump_counts(stepped):
    board, engine = stepped(environment=CONSTANT)
    seq, clock, reasons = 0, 0, set()
    for _ in range(3):
        board.say_one_by_one(at(seq + k, clock + 1000 * k) for k in range(140))
        seq, clock = seq + 140, clock + 10_000_000
        board.say_one_by_one(at(seq + k, clock + 50_000_000 * k) for k in range(5))
        seq, clock = seq + 5, clock + 300_000_000
        reasons.add(engine.health().stale)
    assert reasons == {"the board's clock jumped"}
    assert engine.clock_jumps == 3 * 5 + 2
    assert engine.fault.text == "Fault: the board's clock jumped, three times in 10 s."
    assert not board.send(at(seq, clock))[:, rows.APPLIED_FORCE].any()


def test_telemetry_after_a_clock_jump_continues_at_its_own_rate(rendering):
    setup = rendering(values={"stiffness": 100.0})
    setup.go()
    before = setup.run(5)[-1][rows.BOARD_TIME]
    setup.clock -= 7_000_000
    found = setup.run(5)
    assert [row[rows.BOARD_TIME] - before for row in found] == pytest.approx(np.arange(1, 6) * 1e-3, abs=1e-6)
    assert setup.engine.clock_jumps == 1
    assert all(int(row[rows.FLAGS]) & rows.STALE for row in found)


def test_the_boards_counters_are_summed(rendering):
    """The board counts refused forces, unreadable frames, and (while it renders) switch-offs of its motor."""
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


def test_a_slow_link_does_not_affect_rendering_on_the_board(rendering):
    setup = rendering(values={"stiffness": 100.0})
    setup.run(5)
    setup.engine.arrays.control.fault[0] = arrays.SLOW_LINK
    assert setup.engine.decision(wait=True).refusal == ""
    setup.engine.set_where("board")
    setup.until(lambda: setup.engine.rendering == "board")
    assert setup.engine.fault is None
    assert not setup.messages(Stop)


def test_the_links_limit_is_reported_if_the_stiffness_exceeds_it(rendering):
    setup = rendering(values={"stiffness": 100.0})
    assert on_board.link_warning(setup.engine) == on_board.UNKNOWN
    setup.run(40)
    assert on_board.link_warning(setup.engine) == ""
    setup.engine.set_parameter("stiffness", 2000.0)
    text = on_board.link_warning(setup.engine)
    assert text.startswith("The measured delay is 0.5 ms. In your hand, the handle is stable")
    assert re.search(r"by more than 0\.\d+ mm and let go, it buzzes.*\. Lower the stiffness, or let", text)
    assert setup.engine.loop_of("computer", 0.0).rate == 1000.0

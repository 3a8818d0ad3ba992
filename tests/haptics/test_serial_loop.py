"""Both serial loops with a board that does what it is told: chunks, losses, stop, zero, silence, the end."""

import numpy as np
import pytest

from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, link, rows
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Stop
from tests.haptics.serial_support import QUANTUM, read, sample, undisturbed
from tests.haptics.support import CONSTANT
from tests.waiting import wait_until


@undisturbed()
def test_one_answer_a_chunk_the_newest(board, engine, reader):
    board.say(b"".join(sample(k, 1000 + k) for k in range(3)))
    assert len(read(reader, 3)) == 3
    wait_until(lambda: any(f.seq == 2 for f in board.forces()))
    assert not any(f.seq == 1 for f in board.forces())
    assert engine.health().missed == 2


@undisturbed()
def test_lost_and_broken_frames_are_counted(board, engine, reader):
    broken = bytearray(sample(3, 1000))
    broken[4] ^= 0x55
    board.say(b"".join((sample(0, 1000), sample(1, 1000), sample(2, 1000), bytes(broken), sample(6, 1040))))
    out = read(reader, 4)
    np.testing.assert_array_equal(out[:, rows.FLAGS].astype(int) & rows.GAP, [0, 0, 0, rows.GAP])
    assert out[3, rows.PERIOD] == pytest.approx(4e-3)
    assert out[3, rows.VELOCITY] == pytest.approx(40.0 * QUANTUM / 4e-3)
    health = engine.health()
    assert health.lost_frames == 3
    assert health.crc_errors == 1


@undisturbed(environment=CONSTANT, delay=0.002)
def test_a_lost_answer_leaves_no_old_force_in_the_delay(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(60)))
    read(reader, 60)
    board.say(sample(65, 1000))
    row = read(reader, 1)[-1]
    wait_until(lambda: any((f.seq, f.behind) == (65, 2) for f in board.forces()))
    assert next(f for f in board.forces() if f.seq == 65).force == np.float32(row[rows.APPLIED])


@undisturbed()
def test_the_clamp_of_the_board_is_flagged(board, engine, reader):
    board.say(sample(0, 1000, flags=int(BoardFlag.CLAMPED)))
    assert int(read(reader, 1)[0, rows.FLAGS]) & rows.CLAMPED


@undisturbed(environment=CONSTANT)
def test_stop_and_release_reach_the_board(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    read(reader, 40)
    engine.stop()
    board.say(sample(40, 1000))
    assert read(reader, 1)[0, rows.FLAGS] == rows.STOPPED
    wait_until(lambda: any(f.seq == 40 for f in board.forces()))
    told_to = [m for m in board.received if isinstance(m, Stop | Release) or getattr(m, "seq", 0) == 40]
    assert told_to[-2:] == [Stop(), Force(40, 0, 0.0)]
    engine.release_stop()
    board.say(sample(41, 1000))
    wait_until(lambda: any(f.seq == 41 for f in board.forces()))
    told_to = [m for m in board.received if isinstance(m, Stop | Release) or getattr(m, "seq", 0) == 41]
    assert told_to[-2] == Release()
    assert told_to[-1].force == pytest.approx(1.0 / 30.0)


@undisturbed(environment=CONSTANT, delay=0.05)
def test_the_stop_leaves_no_force_in_an_added_delay(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(100)))
    assert read(reader, 100)[-1, rows.APPLIED] == 1.0
    engine.stop()
    board.say(sample(100, 1000))
    read(reader, 1)
    engine.release_stop()
    board.say(sample(101, 1000))
    read(reader, 1)
    wait_until(lambda: any((f.seq, f.behind) == (101, 50) for f in board.forces()))
    assert all(f.force == 0.0 for f in board.forces() if f.seq in (100, 101))


@undisturbed(values={"stiffness": 100.0})
def test_zero_and_direction(board, engine, reader):

    def move(seq, count):
        board.say(b"".join(sample(seq + k, count) for k in range(40)))
        row = read(reader, 40)[-1]
        wait_until(lambda: any(f.seq == seq + 39 for f in board.forces()))
        return row, next(f.force for f in board.forces() if f.seq == seq + 39)

    row, force = move(0, 1000)
    assert row[rows.POSITION] == 0.0
    row, force = move(40, 1100)
    assert row[rows.POSITION] == pytest.approx(100.0 * QUANTUM)
    assert force == np.float32(row[rows.APPLIED]) == pytest.approx(-100.0 * 100.0 * QUANTUM)
    engine.flip_direction()
    row, turned = move(80, 1100)
    assert row[rows.POSITION] == pytest.approx(-100.0 * QUANTUM)
    assert row[rows.APPLIED] == pytest.approx(100.0 * 100.0 * QUANTUM)
    assert turned == force
    engine.zero_here()
    row, force = move(120, 1100)
    assert row[rows.POSITION] == 0.0
    assert force == 0.0
    row, force = move(160, 1110)
    assert row[rows.POSITION] == pytest.approx(-10.0 * QUANTUM)
    assert force < 0.0
    assert engine.fault is None


@undisturbed()
def test_the_board_sets_the_rate(board, engine, reader):
    engine.set_loop(rate=1000.0, delay=0.001)
    with pytest.raises(ParameterError, match="1000 Hz"):
        engine.set_loop(rate=5000.0)
    assert engine.loop.rate == 1000.0


@undisturbed(environment=CONSTANT)
def test_a_silent_board_gets_zero_and_comes_back_with_a_fade(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    assert read(reader, 40)[-1, rows.APPLIED] == 1.0
    wait_until(lambda: engine.health().stale)
    wait_until(lambda: board.forces()[-1] == Force(0, 0, 0.0))
    board.say(b"".join(sample(40 + k, 1000) for k in range(99)))
    out = read(reader, 99)
    assert not out[:, rows.APPLIED].any()
    assert engine.health().stale_count == 1
    board.say(b"".join(sample(139 + k, 1000) for k in range(35)))
    back = read(reader, 35)[:, rows.APPLIED]
    np.testing.assert_allclose(back[1:31], np.arange(1, 31) / 30.0, rtol=1e-9)


@undisturbed(environment=CONSTANT)
def test_a_computer_that_slept_comes_back_with_a_fade(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    read(reader, 40)
    engine._driver.conn.numbers[link.LAST_ANSWER] -= 0.2
    board.say(b"".join(sample(40 + k, 1000) for k in range(90)))
    out = read(reader, 90)
    assert out[-1, rows.APPLIED] == 0.0
    assert int(out[-1, rows.FLAGS]) & rows.STALE


@undisturbed(environment=CONSTANT)
def test_a_board_that_is_pulled_ends_the_loop_in_words(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    read(reader, 40)
    board.unplug()
    wait_until(lambda: not engine.health().running)
    assert engine.fault.code == arrays.DEVICE_GONE
    assert not engine.health().connected
    assert engine.arrays.control[arrays.DONE] == 1
    engine.close()

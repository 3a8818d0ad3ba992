"""The live loop on a serial port, compiled and in plain Python: rows, answers, and every way to end."""

import contextlib
import itertools
import os
import socket
import threading
import time
from functools import partial

import numpy as np
import pytest

from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, clock, drivers, health, link, rows, serial_loop
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Stop
from tests.haptics.serial_support import (
    QUANTUM,
    SteppedBoard,
    connector,
    played,
    read,
    sample,
    stream,
    undisturbed,
)
from tests.haptics.support import CONSTANT, LoopHarness
from tests.waiting import PATIENCE, wait_until


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
    assert health.link.lost_frames == 3
    assert health.link.crc_errors == 1


@undisturbed(environment=CONSTANT, delay=0.002)
def test_a_lost_answer_leaves_no_old_force_in_the_delay(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(60)))
    read(reader, 60)
    board.say(sample(65, 1000))
    row = read(reader, 1)[-1]
    wait_until(lambda: any((f.seq, f.behind) == (65, 2) for f in board.forces()))
    assert next(f for f in board.forces() if f.seq == 65).force == np.float32(row[rows.APPLIED])


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
def test_the_board_sets_the_rate_and_its_clamp_is_flagged(board, engine, reader):
    engine.set_loop(rate=1000.0, delay=0.001)
    with pytest.raises(ParameterError, match="1,000 Hz"):
        engine.set_loop(rate=5000.0)
    assert engine.loop.rate == 1000.0
    board.say(sample(0, 1000, flags=int(BoardFlag.CLAMPED)))
    assert int(read(reader, 1)[0, rows.FLAGS]) & rows.CLAMPED


@undisturbed(environment=CONSTANT)
def test_a_silent_board_gets_zero_and_comes_back_with_a_fade(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    assert read(reader, 40)[-1, rows.APPLIED] == 1.0
    wait_until(lambda: engine.health().stale)
    wait_until(lambda: board.forces()[-1] == Force(0, 0, 0.0))
    board.say(b"".join(sample(40 + k, 1000) for k in range(99)))
    out = read(reader, 99)
    assert not out[:, rows.APPLIED].any()
    assert engine.arrays.control[arrays.STALE_COUNT] == 1
    board.say(b"".join(sample(139 + k, 1000) for k in range(35)))
    back = read(reader, 35)[:, rows.APPLIED]
    np.testing.assert_allclose(back[1:31], np.arange(1, 31) / 30.0, rtol=1e-9)


@undisturbed(environment=CONSTANT)
def test_a_computer_that_slept_comes_back_with_a_fade(board, engine, reader):
    board.say(b"".join(sample(k, 1000) for k in range(40)))
    read(reader, 40)
    engine.driver.conn.numbers[link.LAST_ANSWER] -= 0.2
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
    assert engine.arrays.control[arrays.DONE] == 1
    engine.close()


def cpu_seconds(thread):
    return time.clock_gettime(time.pthread_getcpuclockid(thread.ident))


class Direct:
    """The compiled loop on one end of a socket pair, the test on the other."""

    def __init__(self):
        harness = LoopHarness(CONSTANT, {"level": 1.0}, full=False)
        self.harness, self.r = harness, harness.r
        self.near, self.far = socket.socketpair()
        self.near.setblocking(False)
        self.late = health.new_histogram()
        self.out = rows.new_ring(self.r.control, 1024)
        self.conn = link.new_link(QUANTUM)
        self.thread = threading.Thread(target=self.run, args=(self.near.fileno(),))

    def run(self, fd):
        self.tid = threading.get_native_id()
        serial_loop.run(self.r, self.conn, self.out, self.late, fd)

    def forces(self):
        self.far.setblocking(False)
        data = b""
        try:
            while chunk := self.far.recv(65536):
                data += chunk
        except BlockingIOError:
            pass
        return Decoder().feed(data)


@pytest.fixture
def direct():
    made = Direct()
    yield made
    made.r.control[arrays.QUIT] = 1
    if made.thread.ident:
        made.thread.join(PATIENCE)
    made.near.close()
    made.far.close()


def push(direct):
    """Start the loop and feed it samples until it pushes."""
    reader = rows.RingReader(direct.out)
    direct.thread.start()
    seq = itertools.count()

    def pushes():
        direct.far.send(sample(next(seq), 1000))
        out = reader.read()
        return len(out) and out[-1, rows.APPLIED] > 0.5

    wait_until(pushes)


@pytest.mark.parametrize("line_ends", [True, False])
def test_the_last_act_is_a_zero_command(direct, line_ends):
    push(direct)
    if line_ends:
        direct.far.shutdown(socket.SHUT_WR)
    else:
        direct.r.control[arrays.QUIT] = 1
    direct.thread.join(PATIENCE)
    assert not direct.thread.is_alive()
    sent = direct.forces()
    assert sent[-1] == Force(0, 0, 0.0)
    assert any(f.force > 0.5 for f in sent)
    assert direct.r.control[arrays.FAULT] == (arrays.DEVICE_GONE if line_ends else arrays.NO_FAULT)


def test_a_closed_descriptor_ends_the_loop(direct):
    fd = os.dup(direct.near.fileno())
    os.close(fd)
    direct.run(fd)
    assert direct.r.control[arrays.FAULT] == arrays.DEVICE_GONE
    assert direct.r.control[arrays.DONE] == 1


def test_a_silent_line_costs_next_to_nothing(direct):
    reader = rows.RingReader(direct.out)
    direct.thread.start()
    direct.far.send(sample(0, 1000))
    wait_until(lambda: len(reader.read()))  # it is compiled
    before, start = cpu_seconds(direct.thread), time.monotonic()
    time.sleep(0.5)
    assert cpu_seconds(direct.thread) - before < 0.05 * (time.monotonic() - start)


def test_a_pulled_pseudo_terminal_leaves_the_processor_idle(direct):
    fds = os.openpty()
    os.set_blocking(fds[1], False)
    thread = threading.Thread(target=direct.run, args=(fds[1],))
    thread.start()
    used = time.process_time()
    os.close(fds[0])
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert time.process_time() - used < 0.5
    assert direct.r.control[arrays.FAULT] == arrays.DEVICE_GONE
    os.close(fds[1])


def test_a_machine_that_keeps_up_again_can_be_cleared(direct):
    """A board goes on while the loop holds back: bytes that are there then say nothing of the machine."""
    control, most = direct.r.control, serial_loop.MOST_PASSES_WITHOUT_WAITING
    passes = most + 1
    for _ in range(3):
        passes = serial_loop.hold_back(direct.r, clock.now(), passes) + 1
        assert control[arrays.FAULT] == arrays.RUNAWAY
    assert passes == most + 4
    control[arrays.FAULT] = arrays.NO_FAULT
    assert serial_loop.hold_back(direct.r, clock.now(), passes) == 0
    assert control[arrays.FAULT] == arrays.NO_FAULT


def test_a_flood_of_garbage_is_demoted_and_latched(direct, rng):
    garbage = rng.integers(0, 256, 1 << 16, dtype=np.uint8).tobytes()
    quit_ = threading.Event()

    def flood():
        direct.far.settimeout(0.1)
        while not quit_.is_set():
            try:
                direct.far.send(garbage)
            except OSError:
                time.sleep(0.001)

    flooder = threading.Thread(target=flood)

    def run(fd):
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        direct.run(fd)

    direct.thread = threading.Thread(target=run, args=(direct.near.fileno(),))
    flooder.start()
    direct.thread.start()
    wait_until(lambda: direct.r.control[arrays.FAULT] == arrays.RUNAWAY)
    wait_until(lambda: os.sched_getscheduler(direct.tid) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER)
    before, start = cpu_seconds(direct.thread), time.monotonic()
    time.sleep(0.3)
    assert cpu_seconds(direct.thread) - before < 0.5 * (time.monotonic() - start)
    quit_.set()
    flooder.join()


KINDS = (drivers.SerialDriver, drivers.PortableDriver)
HOST = [rows.TICK, rows.HOST_TIME, rows.LATENESS, rows.COMPUTE]
SPRING = {"stiffness": 300.0, "damping": 1.0}


def counts_of(count=300, start=1000):
    """Return sensor counts of a handle that swings by some millimetres."""
    k = np.arange(count)
    return [int(c) for c in start + 150.0 * np.sin(k / 23.0) + 40.0 * np.sin(k / 7.0)]


def test_every_sample_is_answered_with_the_force_of_the_tick(connect):
    counts = counts_of()
    out, answers = stream(connect, partial(SteppedBoard, counts, first=65_400), values=SPRING)
    x = (np.array(counts) - counts[0]) * QUANTUM
    np.testing.assert_allclose(out[:, rows.POSITION], x, rtol=1e-12, atol=1e-15)
    v = np.diff(x, prepend=x[0]) * 1000.0
    gain = np.minimum(np.arange(1, 301) / 30.0, 1.0)
    applied = np.clip(gain * (-300.0 * x - 1.0 * v), -2.5, 2.5)
    np.testing.assert_allclose(out[:, rows.APPLIED], applied, rtol=1e-9, atol=1e-12)
    assert [a.seq for a in answers] == [(65_400 + k) % 65_536 for k in range(300)]
    np.testing.assert_array_equal([a.force for a in answers], np.float32(out[:, rows.APPLIED]))
    assert np.all(np.isnan(out[:, rows.TRUE_POSITION]))


def test_both_loops_give_the_same(monkeypatch, request):
    found = []
    for kind in KINDS:
        connect = connector(kind, monkeypatch, request.addfinalizer)
        found.append(
            stream(
                connect, lambda: SteppedBoard(counts_of(), 300), values=SPRING, estimator="iir", delay=0.002
            )
        )
    (one, sent), (other, also_sent) = found
    assert sent == also_sent
    same = [c for c in range(rows.ROW_WIDTH) if c not in HOST]
    np.testing.assert_array_equal(one[:, same], other[:, same])


@pytest.mark.parametrize("added", [0, 3])
def test_an_added_delay_answers_older_samples_and_energy_knows_it(connect, added):
    """Of 3.25 periods: before sample k the answer to k - 5 for a quarter, then that to k - 4."""
    board = partial(SteppedBoard, counts_of(), 1000 * added + 250)
    out, answers = stream(connect, board, values=SPRING, delay=1e-3 * added)
    assert [(a.seq, a.behind) for a in answers] == [(k, added) for k in range(300)]
    late = np.concatenate((np.zeros(added + 1), out[:, rows.APPLIED]))
    np.testing.assert_array_equal([a.force for a in answers], np.float32(late[1:301]))
    effect = 0.25 * late[:299] + 0.75 * late[1:300]
    moved = np.diff(out[:, rows.POSITION])
    np.testing.assert_allclose(out[1:, rows.ENERGY], np.cumsum(effect * moved), rtol=1e-6, atol=1e-9)


def test_the_delay_is_measured_while_the_force_is_held_at_zero(connect):
    board = partial(SteppedBoard, counts_of(600), 730)
    out, answers, health = played(connect, board, hold=drivers.HOLD_SECONDS, values=SPRING)
    held = np.count_nonzero(out[:, rows.APPLIED] == 0.0)
    assert 500 <= held <= 510
    assert not any(a.force for a in answers[:500])
    assert any(a.force for a in answers[520:])
    assert health.delay == pytest.approx(730e-6)


# --- the portable loop by itself, its port in the test's hands
class Port:
    """Hands out what is to be read, then fails; keeps what is written."""

    def __init__(self, *reads, broken=False):
        self.reads, self.broken, self.written = list(reads), broken, b""

    def read(self, seconds):
        if not self.reads:
            raise OSError("gone")
        return self.reads.pop(0)

    def write(self, data):
        if self.broken:
            raise OSError("gone")
        self.written += data


def run(port):
    harness = LoopHarness(CONSTANT, full=False)
    conn = link.new_link(QUANTUM)
    out = rows.new_ring(harness.r.control, 1024)
    reader = rows.RingReader(out)
    serial_loop.run_portable(harness.r, conn, out, health.new_histogram(), port.read, port.write)
    assert harness.r.control[arrays.FAULT] == arrays.DEVICE_GONE
    assert harness.r.control[arrays.DONE] == 1
    return reader.read(), Decoder().feed(port.written)


def test_a_port_that_fails_or_takes_nothing_ends_with_a_zero_command():
    serial_loop.warm_up()  # leaves nothing behind
    out, sent = run(Port(b"".join(sample(k, 1000) for k in range(40))))
    assert out[-1, rows.APPLIED] == 1.0
    assert sent[-2:] == [Force(39, 0, 1.0), Force(0, 0, 0.0)]
    out, sent = run(Port(sample(0, 1000), sample(1, 1000), broken=True))
    assert len(out) == 1  # seen, though its answer could not be sent
    assert not sent


def test_more_than_a_buffer_at_once_is_read():
    count = 2 * link.CHUNK // len(sample(300, 1000))
    out, _ = run(Port(b"".join(sample(k, 1000) for k in range(count))))
    np.testing.assert_allclose(out[:, rows.BOARD_TIME], 1e-3 * np.arange(count), atol=1e-9)

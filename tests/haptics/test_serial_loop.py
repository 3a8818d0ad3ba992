"""The live loop on a serial port, compiled and in plain Python: rows, answers, and every way to end."""

import contextlib
import os
import socket
import threading
import time

import numpy as np
import pytest

from hapkit_studio import environments
from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import arrays, clock, drivers, health, link, rows, serial_loop
from hapkit_studio.haptics import engine as engine_module
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import BoardFlag, Force, Release, Stop
from tests.devices.fake_board import FakeKit
from tests.haptics.serial_support import QUANTUM, sample, samples
from tests.haptics.support import CONSTANT, LoopHarness, read
from tests.lateness import ATTEMPTS
from tests.waiting import PATIENCE, wait_until


def test_each_chunk_gets_one_answer_to_its_newest_sample(stepped):
    board, engine = stepped()
    assert len(board.send(samples(0, 1, 2))) == 3
    assert [f.seq for f in board.messages(Force)] == [2]
    assert engine.health().missed == 2


@pytest.mark.parametrize(
    ("law_time", "shown"),
    [
        (1e-6, 10),
        (0.55e-3, 10),  # nine older samples take 4.95 ms, so all ten are rendered
        (0.56e-3, 9),  # nine older samples would take 5.04 ms, so the first is skipped
        (0.99e-3, 6),  # five older samples take 4.95 ms
        (1.01e-3, 1),  # the law takes longer than a period: the machine cannot keep up
    ],
)
def test_of_a_backlog_only_samples_with_time_for_the_law_are_rendered_and_always_the_newest(
    stepped, law_time, shown
):
    """The loop computes from the law's duration how many of the oldest samples to skip.

    It counts the skipped samples.
    """
    board, engine = stepped(environment=CONSTANT)
    board.send(sample(0, 1000))
    engine.arrays.tick.law_time = law_time
    found = board.send(b"".join(sample(k, 1000 + 10 * k) for k in range(1, 11)))
    assert len(found) == shown
    skipped = 10 - shown
    np.testing.assert_allclose(found[:, rows.PERIOD], [1e-3 * (1 + skipped), *[1e-3] * (shown - 1)])
    assert bool(int(found[0, rows.FLAGS]) & rows.GAP) == (skipped > 0)
    np.testing.assert_allclose(found[:, rows.VELOCITY], 10.0 * QUANTUM / 1e-3)
    assert board.messages(Force)[-1].seq == 10
    health = engine.health()
    assert (health.missed, health.link.lost_frames) == (9, 0)


def test_lost_and_broken_frames_are_counted(stepped):
    board, engine = stepped()
    broken = bytearray(sample(3))
    broken[4] ^= 0x55
    out = board.send(samples(0, 1, 2) + bytes(broken) + sample(6, 1040))
    np.testing.assert_array_equal(out[:, rows.FLAGS].astype(int) & rows.GAP, [0, 0, 0, rows.GAP])
    assert out[3, rows.PERIOD] == pytest.approx(4e-3)
    assert out[3, rows.VELOCITY] == pytest.approx(40.0 * QUANTUM / 4e-3)
    health = engine.health()
    assert health.link.lost_frames == 3
    assert health.link.crc_errors == 1


def test_a_lost_answer_leaves_no_old_force_in_the_delay(stepped):
    board, _ = stepped(environment=CONSTANT, delay=0.002)
    board.send(samples(*range(60)))
    row = board.send(sample(65))[-1]
    answer = board.answer_to(65)
    assert (answer.behind, answer.force) == (2, np.float32(row[rows.APPLIED_FORCE]))


def test_stop_and_release_are_sent_to_the_board(stepped):
    board, engine = stepped(environment=CONSTANT)
    board.send(samples(*range(40)))
    engine.stop()
    assert board.send(sample(40))[0, rows.FLAGS] == rows.STOPPED
    assert board.received[-2:] == [Stop(), Force(40, 0, 0.0)]
    engine.release_stop()
    board.send(sample(41))
    assert board.received[-2] == Release()
    assert board.received[-1].force == pytest.approx(1.0 / 30.0)


def test_the_stop_removes_forces_in_an_added_delay(stepped):
    board, engine = stepped(environment=CONSTANT, delay=0.05)
    assert board.send(samples(*range(100)))[-1, rows.APPLIED_FORCE] == 1.0
    engine.stop()
    board.send(sample(100))
    engine.release_stop()
    board.send(sample(101))
    assert [(f.seq, f.behind, f.force) for f in board.messages(Force)[-2:]] == [
        (100, 50, 0.0),
        (101, 50, 0.0),
    ]


def test_zero_and_direction_can_be_set(stepped):
    board, engine = stepped(values={"stiffness": 100.0})

    def move(seq, count):
        row = board.send(b"".join(sample(seq + k, count) for k in range(40)))[-1]
        return row, board.answer_to(seq + 39).force

    row, force = move(0, 1000)
    assert row[rows.POSITION] == 0.0
    row, force = move(40, 1100)
    assert row[rows.POSITION] == pytest.approx(100.0 * QUANTUM)
    assert force == np.float32(row[rows.APPLIED_FORCE]) == pytest.approx(-100.0 * 100.0 * QUANTUM)
    engine.flip_direction()
    row, turned = move(80, 1100)
    assert row[rows.POSITION] == pytest.approx(-100.0 * QUANTUM)
    assert row[rows.APPLIED_FORCE] == pytest.approx(100.0 * 100.0 * QUANTUM)
    assert turned == force
    engine.zero_here()
    row, force = move(120, 1100)
    assert row[rows.POSITION] == 0.0
    assert force == 0.0
    row, force = move(160, 1110)
    assert row[rows.POSITION] == pytest.approx(-10.0 * QUANTUM)
    assert force < 0.0
    assert engine.fault is None


def test_the_board_sets_the_rate_and_its_clamp_sets_a_flag(stepped):
    board, engine = stepped()
    engine.set_loop(rate=1000.0, delay=0.001)
    with pytest.raises(ParameterError, match="1,000 Hz"):
        engine.set_loop(rate=5000.0)
    assert engine.loop.rate == 1000.0
    row = board.send(sample(0, flags=int(BoardFlag.CLAMPED)))[0]
    assert int(row[rows.FLAGS]) & rows.CLAMPED


def test_a_silent_board_gets_zero_force_and_returns_with_a_fade(stepped):
    board, engine = stepped(environment=CONSTANT)
    assert board.send(samples(*range(40)))[-1, rows.APPLIED_FORCE] == 1.0
    board.fall_silent()
    assert engine.health().stale
    assert board.received[-1] == Force(0, 0, 0.0)
    assert not board.send(samples(*range(40, 139)))[:, rows.APPLIED_FORCE].any()
    assert engine.arrays.control.stale_count[0] == 1
    back = board.send(samples(*range(139, 174)))[:, rows.APPLIED_FORCE]
    np.testing.assert_allclose(back[1:31], np.arange(1, 31) / 30.0, rtol=1e-9)


def test_after_the_computer_was_suspended_the_force_is_zero(stepped):
    board, _ = stepped(environment=CONSTANT)
    board.send(samples(*range(40)))
    row = board.send(samples(*range(40, 130)), late=0.2)[-1]
    assert row[rows.APPLIED_FORCE] == 0.0
    assert int(row[rows.FLAGS]) & rows.STALE


SPRING = {"stiffness": 300.0, "damping": 1.0}


def counts_of(count=300, start=1000):
    """Return the sensor's counts of a handle that oscillates by some millimetres."""
    k = np.arange(count)
    return [int(c) for c in start + 150.0 * np.sin(k / 23.0) + 40.0 * np.sin(k / 7.0)]


def frames_of(counts, first=0, **fields):
    """Return one frame per sensor count."""
    return [sample(first + k, count, **fields) for k, count in enumerate(counts)]


def test_every_sample_is_answered_with_the_force_of_the_tick(stepped):
    board, _ = stepped(values=SPRING)
    counts = counts_of()
    out = board.say_one_by_one(frames_of(counts, 65_400))
    answers = board.messages(Force)
    x = (np.array(counts) - counts[0]) * QUANTUM
    np.testing.assert_allclose(out[:, rows.POSITION], x, rtol=1e-12, atol=1e-15)
    v = np.diff(x, prepend=x[0]) * 1000.0
    gain = np.minimum(np.arange(1, 301) / 30.0, 1.0)
    applied = np.clip(gain * (-300.0 * x - 1.0 * v), -2.5, 2.5)
    np.testing.assert_allclose(out[:, rows.APPLIED_FORCE], applied, rtol=1e-9, atol=1e-12)
    assert [a.seq for a in answers] == [(65_400 + k) % 65_536 for k in range(300)]
    np.testing.assert_array_equal([a.force for a in answers], np.float32(out[:, rows.APPLIED_FORCE]))
    assert np.all(np.isnan(out[:, rows.TRUE_POSITION]))


@pytest.mark.parametrize("added", [0, 3])
def test_an_added_delay_answers_older_samples_and_the_energy_includes_it(stepped, added):
    """With a delay of 3.25 periods, a quarter of each period has an older answer than the rest.

    In the period before sample k, the answer to k - 5 acts for a quarter, then the answer to k - 4.
    """
    board, _ = stepped(values=SPRING, delay=1e-3 * added)
    delay, counts = 1000 * added + 250, counts_of()
    frames = [sample(0, counts[0])]
    frames += [sample(k, counts[k], max(k - 1 - added, 0), delay) for k in range(1, 300)]
    out = board.say_one_by_one(frames)
    answers = board.messages(Force)
    assert [(a.seq, a.behind) for a in answers] == [(k, added) for k in range(300)]
    late = np.concatenate((np.zeros(added + 1), out[:, rows.APPLIED_FORCE]))
    np.testing.assert_array_equal([a.force for a in answers], np.float32(late[1:301]))
    effect = 0.25 * late[:299] + 0.75 * late[1:300]
    moved = np.diff(out[:, rows.POSITION])
    np.testing.assert_allclose(out[1:, rows.ENERGY], np.cumsum(effect * moved), rtol=1e-6, atol=1e-9)


def test_the_delay_is_measured_while_the_force_is_zero(stepped):
    board, engine = stepped(values=SPRING, hold=drivers.ZERO_FORCE_SECONDS)
    assert engine.health().delay is None
    out = board.say_one_by_one(
        sample(k, count, max(k - 1, 0), 730 if k else 0) for k, count in enumerate(counts_of(600))
    )
    held = np.count_nonzero(out[:, rows.APPLIED_FORCE] == 0.0)
    answers = board.messages(Force)
    assert 500 <= held <= 510
    assert not any(a.force for a in answers[:500])
    assert any(a.force for a in answers[520:])
    assert engine.health().delay == pytest.approx(730e-6)


# --- both loops on a real serial line
HOST = [rows.TICK, rows.HOST_TIME, rows.LATENESS, rows.COMPUTE]


def by_file(r, conn, out, data):
    """Run the compiled loop on the available data; return the bytes that it has sent."""
    near, far = socket.socketpair()
    with near, far:
        near.setblocking(False)
        far.sendall(data)
        far.shutdown(socket.SHUT_WR)
        serial_loop.run(r, conn, out, health.new_histogram(), near.fileno())
        return far.recv(1 << 16)


def by_port(r, conn, out, data):
    """Run the plain Python loop on the same data; return the bytes that it has sent."""
    port = Port(*(data[at : at + link.CHUNK] for at in range(0, len(data), link.CHUNK)))
    serial_loop.run_portable(r, conn, out, health.new_histogram(), port.read, port.write)
    return port.written


def test_both_loops_give_the_same_rows_and_answers():
    """A busy machine may delay a loop, so that its force becomes zero; in that case both loops run again."""
    data = b"".join(frames_of(counts_of(), delay_us=300))

    def played(loop):
        harness = LoopHarness(environments.named("spring"), SPRING, full=False, estimator="iir")
        conn, out = link.new_link(QUANTUM), rows.new_ring(harness.r.control, 1024)
        reader = rows.RingReader(out)
        sent = loop(harness.r, conn, out, data)
        assert harness.r.control.fault[0] == arrays.DEVICE_GONE
        return reader.read(), Decoder().feed(sent), harness.r.control.stale_count[0]

    for _ in range(ATTEMPTS):
        (one, sent, late), (other, also_sent, also_late) = played(by_file), played(by_port)
        if not late and not also_late:
            break
    assert len(one) == 300
    assert sent == also_sent
    assert [f.seq for f in sent[-2:]] == [299, 0]
    same = [c for c in range(rows.ROW_WIDTH) if c not in HOST]
    np.testing.assert_array_equal(one[:, same], other[:, same])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "pulled"),
    [(drivers.SerialDriver, True), (drivers.PortableDriver, True), (drivers.SerialDriver, False)],
)
def test_an_unplugged_or_silent_board_ends_the_loop_with_a_message(kind, pulled, monkeypatch, fake_board):
    monkeypatch.setattr(engine_module, "driver_for", kind)
    peer = fake_board(FakeKit(burst=40))
    engine = Engine(HapkitBoard(peer.path), CONSTANT, realtime=False)
    reader = engine.reader()
    engine.start()
    try:
        read(reader, lambda found: len(found) == 40)
        if pulled:
            peer.unplug()
        wait_until(lambda: not engine.health().running)
        assert pulled or "has sent nothing for 1 s" in engine.health().message
        assert engine.fault.code == arrays.DEVICE_GONE
        assert engine.arrays.control.done[0] == 1
    finally:
        engine.close()


def share_of_processor(thread, seconds=0.2):
    """Return the fraction of a processor that a thread uses during some seconds."""
    clock_id = time.pthread_getcpuclockid(thread.ident)
    used, start = time.clock_gettime(clock_id), time.monotonic()
    time.sleep(seconds)
    return (time.clock_gettime(clock_id) - used) / (time.monotonic() - start)


class Direct:
    """A socket pair with the compiled loop at one end and the test at the other."""

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

    def close(self):
        self.r.control.quit[0] = 1
        if self.thread.ident:
            self.thread.join(PATIENCE)
        self.near.close()
        self.far.close()


@pytest.fixture
def direct():
    with contextlib.closing(Direct()) as made:
        yield made


def ended(line_ends):
    """Close the line, or stop the loop, while a force acts; return the sent forces and the loop's fault."""
    with contextlib.closing(Direct()) as direct:
        direct.far.send(samples(*range(60)))
        if line_ends:
            direct.far.shutdown(socket.SHUT_WR)
        direct.thread.start()
        wait_until(lambda: direct.r.control.head[0] == 60)
        direct.r.control.quit[0] = not line_ends
        direct.thread.join(PATIENCE)
        assert not direct.thread.is_alive()
        return Decoder().feed(direct.far.recv(65536)), direct.r.control.fault[0]


@pytest.mark.parametrize(("line_ends", "fault"), [(True, arrays.DEVICE_GONE), (False, arrays.NO_FAULT)])
def test_the_last_message_is_a_zero_command(line_ends, fault):
    """The test is repeated if a busy machine delayed the loop before the samples, or this test after them."""
    for _ in range(ATTEMPTS):
        sent, found = ended(line_ends)
        assert sent[-1] == Force(0, 0, 0.0)
        if sent[0].force == 1.0 and found == fault:
            break
    assert (sent[0], found) == (Force(59, 0, 1.0), fault)


def test_a_closed_descriptor_ends_the_loop(direct):
    fd = os.dup(direct.near.fileno())
    os.close(fd)
    direct.run(fd)
    assert direct.r.control.fault[0] == arrays.DEVICE_GONE
    assert direct.r.control.done[0] == 1


def test_a_silent_line_uses_almost_no_processor_time(direct):
    reader = rows.RingReader(direct.out)
    direct.thread.start()
    direct.far.send(sample(0, 1000))
    wait_until(lambda: len(reader.read()))  # the loop has been compiled once rows arrive
    assert share_of_processor(direct.thread) < 0.05


def test_an_unplugged_pseudo_terminal_leaves_the_processor_idle(direct):
    fds = os.openpty()
    os.set_blocking(fds[1], False)
    thread = threading.Thread(target=direct.run, args=(fds[1],))
    thread.start()
    used = time.process_time()
    os.close(fds[0])
    thread.join(PATIENCE)
    assert not thread.is_alive()
    assert time.process_time() - used < 0.5
    assert direct.r.control.fault[0] == arrays.DEVICE_GONE
    os.close(fds[1])


def test_after_a_machine_keeps_up_again_the_fault_can_be_cleared(direct):
    """The board sends bytes while the loop waits; bytes found after a wait do not mean a slow machine."""
    control, most = direct.r.control, serial_loop.MOST_PASSES_WITHOUT_WAITING
    passes = most + 1
    for _ in range(3):
        passes = serial_loop.wait_if_too_slow(direct.r, clock.now(), passes) + 1
        assert control.fault[0] == arrays.RUNAWAY
    assert passes == most + 4
    control.fault[0] = arrays.NO_FAULT
    assert serial_loop.wait_if_too_slow(direct.r, clock.now(), passes) == 0
    assert control.fault[0] == arrays.NO_FAULT


def test_an_endless_flood_is_demoted_and_latched(direct):
    flood = os.open("/dev/zero", os.O_RDWR)

    def run():
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(10))
        direct.run(flood)

    direct.thread = threading.Thread(target=run)
    direct.thread.start()
    wait_until(lambda: direct.r.control.fault[0] == arrays.RUNAWAY)
    wait_until(lambda: os.sched_getscheduler(direct.tid) & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER)
    assert share_of_processor(direct.thread) < 0.5
    direct.close()
    os.close(flood)


# --- the portable loop on a port that the test controls
class Port:
    """A port that returns the prepared data, then fails; it records the written bytes."""

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
    assert harness.r.control.fault[0] == arrays.DEVICE_GONE
    assert harness.r.control.done[0] == 1
    return reader.read(), Decoder().feed(port.written)


def test_a_port_that_fails_or_accepts_no_data_ends_with_a_zero_command():
    serial_loop.warm_up()  # a warm-up must not affect later runs
    out, sent = run(Port(b"".join(sample(k, 1000) for k in range(40))))
    assert out[-1, rows.APPLIED_FORCE] == 1.0
    assert sent[-2:] == [Force(39, 0, 1.0), Force(0, 0, 0.0)]
    out, sent = run(Port(sample(0, 1000), sample(1, 1000), broken=True))
    assert len(out) == 1  # the sample is recorded, although its answer could not be sent
    assert not sent


def test_more_data_than_a_buffer_are_read():
    count = 2 * link.CHUNK // len(sample(300, 1000))
    out, _ = run(Port(b"".join(sample(k, 1000) for k in range(count))))
    np.testing.assert_allclose(out[:, rows.BOARD_TIME], 1e-3 * np.arange(count), atol=1e-9)

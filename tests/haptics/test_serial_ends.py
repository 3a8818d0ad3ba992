"""How the compiled serial loop ends, on a line whose other end the test holds: zero force, idle processor."""

import contextlib
import itertools
import os
import socket
import threading
import time

import numpy as np
import pytest

from hapkit_studio.haptics import arrays, clock, health, link, rows, serial_loop
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import Force
from tests.haptics.serial_support import QUANTUM, sample
from tests.haptics.support import CONSTANT, Bench
from tests.waiting import PATIENCE, wait_until


def cpu_seconds(thread):
    return time.clock_gettime(time.pthread_getcpuclockid(thread.ident))


class Direct:
    """The compiled loop on one end of a socket pair, the test on the other."""

    def __init__(self):
        bench = Bench(CONSTANT, {"level": 1.0}, full=False)
        self.bench, self.r = bench, bench.r
        self.near, self.far = socket.socketpair()
        self.near.setblocking(False)
        self.late = health.new_histogram()
        self.out = rows.new_ring(self.r.control, 1024)
        self.conn = link.new_link(QUANTUM)
        self.thread = threading.Thread(target=self.run, args=(self.near.fileno(),))

    def run(self, fd):
        self.tid = threading.get_native_id()
        serial_loop.run(self.r, self.conn, self.out, self.late, fd, serial_loop.new_spec())

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


def test_the_last_act_is_a_zero_command_when_the_line_ends(direct):
    push(direct)
    direct.far.shutdown(socket.SHUT_WR)
    direct.thread.join(PATIENCE)
    assert not direct.thread.is_alive()
    sent = direct.forces()
    assert sent[-1] == Force(0, 0, 0.0)
    assert any(f.force > 0.5 for f in sent)
    assert direct.r.control[arrays.FAULT] == arrays.DEVICE_GONE


def test_the_last_act_is_a_zero_command_when_told_to_quit(direct):
    push(direct)
    direct.r.control[arrays.QUIT] = 1
    direct.thread.join(PATIENCE)
    assert direct.forces()[-1] == Force(0, 0, 0.0)
    assert direct.r.control[arrays.FAULT] == arrays.NO_FAULT


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

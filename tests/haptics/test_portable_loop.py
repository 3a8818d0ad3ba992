"""Both serial loops, sample by sample: every frame answered with the tick's force, and the same by both."""

import numpy as np
import pytest

from hapkit_studio.haptics import arrays, drivers, health, link, rows, serial_loop
from hapkit_studio.protocol.framing import Decoder
from hapkit_studio.protocol.messages import Force
from tests.haptics.serial_support import QUANTUM, SteppedBoard, connector, played, sample, stream
from tests.haptics.support import CONSTANT, Bench

KINDS = (drivers.SerialDriver, drivers.PortableDriver)
HOST = [rows.TICK, rows.HOST_TIME, rows.LATENESS, rows.COMPUTE]
SPRING = {"stiffness": 300.0, "damping": 1.0}


def counts_of(count=300, start=1000):
    """Return sensor counts of a handle that swings by some millimetres."""
    k = np.arange(count)
    return [int(c) for c in start + 150.0 * np.sin(k / 23.0) + 40.0 * np.sin(k / 7.0)]


def test_every_sample_is_answered_with_the_force_of_the_tick(connect):
    counts = counts_of()
    out, answers = stream(connect, lambda: SteppedBoard(counts, first=65_400), values=SPRING)
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


def test_energy_is_that_of_the_force_in_effect(connect):
    counts = counts_of()
    out, _ = stream(connect, lambda: SteppedBoard(counts, 250), values=SPRING)
    applied, moved = out[:, rows.APPLIED], np.diff(out[:, rows.POSITION])
    before = np.concatenate(([0.0], applied[:-2]))
    effect = 0.25 * before + 0.75 * applied[:-1]
    np.testing.assert_allclose(out[1:, rows.ENERGY], np.cumsum(effect * moved), rtol=1e-9, atol=1e-12)


def test_energy_knows_an_added_delay(connect):
    counts = counts_of()
    out, _ = stream(connect, lambda: SteppedBoard(counts, 3250), values=SPRING, delay=0.003)
    applied = np.concatenate((np.zeros(4), out[:-1, rows.APPLIED]))
    newer, older = applied[1:301], applied[0:300]
    # 3.25 periods: in the period before sample k, the answer to k - 5 for a quarter, then that to k - 4
    effect = 0.25 * older[:-1] + 0.75 * newer[:-1]
    moved = np.diff(out[:, rows.POSITION])
    np.testing.assert_allclose(out[1:, rows.ENERGY], np.cumsum(effect * moved), rtol=1e-6, atol=1e-9)


def test_added_delay_answers_older_samples(connect):
    out, answers = stream(connect, lambda: SteppedBoard(counts_of(), 3250), values=SPRING, delay=0.003)
    assert [(a.seq, a.behind) for a in answers] == [(k, 3) for k in range(300)]
    sent = np.concatenate(([0.0, 0.0, 0.0], out[:-3, rows.APPLIED]))
    np.testing.assert_array_equal([a.force for a in answers], np.float32(sent))


def test_the_delay_is_measured_while_the_force_is_held_at_zero(connect):
    out, answers = stream(
        connect, lambda: SteppedBoard(counts_of(600), 730), hold=drivers.HOLD_SECONDS, values=SPRING
    )
    held = np.count_nonzero(out[:, rows.APPLIED] == 0.0)
    assert 500 <= held <= 510
    assert not any(a.force for a in answers[:500])
    assert any(a.force for a in answers[520:])
    assert drivers.HOLD_SECONDS == 0.5


def test_the_measured_delay_is_the_board_s(connect):
    *_, health = played(connect, lambda: SteppedBoard(counts_of(200), 730))
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
    bench = Bench(CONSTANT, full=False)
    loop = serial_loop.PortableLoop(link.new_link(QUANTUM), port.read, port.write)
    out = rows.new_ring(bench.r.control, 1024)
    reader = rows.RingReader(out)
    loop.run(bench.r, out, health.new_histogram())
    assert bench.r.control[arrays.FAULT] == arrays.DEVICE_GONE
    assert bench.r.control[arrays.DONE] == 1
    return reader.read(), Decoder().feed(port.written)


def test_a_port_that_fails_ends_with_a_zero_command():
    out, sent = run(Port(b"".join(sample(k, 1000) for k in range(40))))
    assert out[-1, rows.APPLIED] == 1.0
    assert sent[-2:] == [Force(39, 0, 1.0), Force(0, 0, 0.0)]


def test_a_port_that_takes_nothing_ends_the_loop():
    out, sent = run(Port(sample(0, 1000), sample(1, 1000), broken=True))
    assert len(out) == 1  # seen, though its answer could not be sent
    assert not sent


def test_more_than_a_buffer_at_once_is_read():
    count = 2 * link.CHUNK // len(sample(300, 1000))
    out, _ = run(Port(b"".join(sample(k, 1000) for k in range(count))))
    np.testing.assert_allclose(out[:, rows.BOARD_TIME], 1e-3 * np.arange(count), atol=1e-9)


def test_warming_up_leaves_nothing_behind():
    serial_loop.warm_up()
    out, _ = run(Port(sample(0, 1000)))
    assert len(out) == 1

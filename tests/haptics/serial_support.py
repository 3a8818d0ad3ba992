"""A board controlled by the test; the serial loop runs chunk by chunk, without thread, port or clock."""

import math
import time

import numpy as np

from hapkit_studio.devices.hapkit import HapkitBoard
from hapkit_studio.devices.port_errors import no_answer
from hapkit_studio.haptics import clock, drivers, serial_loop
from hapkit_studio.haptics import engine as engine_module
from hapkit_studio.haptics.engine import Engine
from hapkit_studio.haptics.tick import adopt
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import Force, Hello, HelloRequest, Sample
from tests.devices.fake_board import KIT, FakeKit

QUANTUM = float(np.float32(KIT.quantum))


def sample(seq, count=1000, answered=0, delay_us=0, flags=0, time_us=None):
    """Return the frame of a sample with these fields."""
    time_us = 1000 * seq & 0xFFFFFFFF if time_us is None else time_us
    return encode(Sample(seq & 0xFFFF, time_us, count, 0, answered & 0xFFFF, delay_us, flags, *6 * (0,)))


def samples(*seqs):
    """Return frames with these sequence numbers, and with the handle at rest."""
    return b"".join(map(sample, seqs))


class SteppedBoard(HapkitBoard):
    """A board that receives messages at once; ``send`` returns after the loop has answered the data.

    The function answer(message) returns bytes that the board sends before its next data, or None.
    """

    def __init__(self, answer=None):
        super().__init__("/dev/ttyTEST")
        self.answer = answer or FakeKit(arena=0)
        self.received, self._reply = [], b""

    def open(self, handshake_time=0.0):
        self._hello = self.request(HelloRequest(), Hello)

    def close(self):
        self._hello = None

    def send_messages(self, *messages):
        for message in messages:
            self.received.append(message)
            self._reply += self.answer(message) or b""

    def request(self, message, reply, seconds=0.0):
        self.send_messages(message)
        answers, self._reply = Decoder().feed(self._reply), b""
        for found in answers:
            if isinstance(found, reply):
                return found
        raise no_answer(self.port, "a question", seconds)

    def begin(self, engine, r, conn, out, late):
        """Store the loop's arrays and its reader."""
        self._loop, self._reader = (r, conn, out, late), engine.reader()

    def send(self, data, late=0.0):
        """Let the loop handle a chunk; return its rows.

        By the loop's clock, the chunk arrives on time. If ``late`` is not 0, it arrives ``late`` s after the
        last answer.
        """
        _, conn, _, _ = self._loop
        data, self._reply = self._reply + data, b""
        conn.data[: len(data)] = np.frombuffer(data, dtype=np.uint8)
        conn.state.last_answer = clock.now() - late if late else math.inf
        self.hear(conn, serial_loop.take(*self._loop, len(data)))
        return self._reader.read()

    def say_one_by_one(self, frames):
        """Return the rows of frames that are sent as separate chunks."""
        return np.concatenate([self.send(frame) for frame in frames])

    def fall_silent(self):
        """Let the loop time out once, without its thread being late."""
        r, conn, _, _ = self._loop
        conn.state.last_answer, conn.state.read_at = 0.0, math.inf
        self.hear(conn, serial_loop.answer_silence(r, conn))

    def hear(self, conn, size):
        self.send_messages(*Decoder().feed(conn.frame[:size].tobytes()))

    def messages(self, *kinds):
        """Return the received messages of some kinds."""
        return [m for m in self.received if isinstance(m, kinds)]

    def answer_to(self, seq):
        """Return the force that answers a sample."""
        return next(f for f in self.messages(Force) if f.seq == seq)


class SteppedDriver(drivers.SerialDriver):
    """A driver that lets the board run the loop, while the loop's own thread only waits for the end."""

    def _loop(self, r, out, late):
        if r.control.quit[0]:
            return
        while not r.control.quit[0]:
            time.sleep(1e-3)
        self.device.hear(self.conn, serial_loop.encode_zero(self.conn))


def stepped_engine(monkeypatch, finally_, board, hold=0.0, environment="spring", values=None, **loop):
    """Return a running engine that handles the board's data as soon as the board sends them."""
    monkeypatch.setattr(engine_module, "driver_for", SteppedDriver)
    monkeypatch.setattr(SteppedDriver, "zero_force_seconds", hold)
    engine = Engine(board, environment, realtime=False)
    engine.set_environment(environment, values or {})
    engine.set_loop(**loop)
    finally_(engine.close)
    engine.start()
    adopt(engine.arrays, 0.0)
    board.begin(engine, engine.arrays, engine.driver.conn, engine._ring, engine.lateness_bins)
    return engine

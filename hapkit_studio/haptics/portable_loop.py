"""The serial loop as a plain Python thread, for systems whose ports are no file descriptors.

The same tick, codec and answers as the compiled loop; only waiting, reading and writing differ.
"""

import contextlib

import numpy as np

from hapkit_studio.haptics import block, histogram, line, rig, ring, rows, settings, sleep
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.line import Line, new_line
from hapkit_studio.haptics.rig import Rig, new_rig
from hapkit_studio.haptics.ring import Ring, new_ring
from hapkit_studio.haptics.tick import STALE_AFTER, latch, mark_stale
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Sample


def warm_up() -> None:
    """Compile or load all that a sample needs, by rendering one under a latched fault, that calls no law."""
    r, conn = new_rig(*block.new_block()), new_line(1.0)
    r.control[rig.FAULT] = rig.RUNAWAY
    frame = np.frombuffer(encode(Sample(0, 0, 0, 0, 0, 0, 0, 0)), dtype=np.uint8)
    loop = PortableLoop(conn, None, lambda data: None)
    loop._take(r, new_ring(r.control, 2), histogram.new_histogram(), frame)
    loop._last_act()
    mark_stale(r, 0.0)


class PortableLoop:
    """Runs one connection through callables: read(seconds) -> bytes, write(bytes); both may raise OSError."""

    def __init__(self, conn: Line, read, write):
        self.conn, self.read, self.write = conn, read, write

    def run(self, r: Rig, out: Ring, late: np.ndarray) -> None:
        """Render until told to quit or the port fails; the last act is a zero command."""
        settings.adopt(r, 0.0)
        self.conn.numbers[line.LAST_ANSWER] = sleep.now()
        try:
            while not load_acquire(r.control, rig.QUIT):
                data = np.frombuffer(self.read(STALE_AFTER), dtype=np.uint8)
                for start in range(0, len(data), line.CHUNK):
                    self._take(r, out, late, data[start : start + line.CHUNK])
                self._silent(r)
        except OSError:
            latch(r, rig.DEVICE_GONE, 0.0, 0.0)
        finally:
            self._last_act()
            store_release(r.control, rig.DONE, 1)

    def _take(self, r: Rig, out: Ring, late: np.ndarray, data: np.ndarray) -> None:
        conn = self.conn
        conn.data[: len(data)] = data
        count = codec.feed(conn.reader, conn.buffer, conn.data, len(data), conn.samples)
        now = sleep.now()
        for k in range(count):
            newest = k == count - 1
            if newest:
                line.overslept(r, conn, now)
            line.render(r, conn, out, k, now)
            if newest:
                self._answer(r, k, now)
            row = out.rows[ring.next_index(out)]
            row[rows.COMPUTE] = sleep.now() - now
            histogram.add(late, row[rows.LATENESS])
            ring.publish(out)
        if count > 1:
            store_release(r.control, rig.MISSED, int(r.control[rig.MISSED]) + count - 1)

    def _answer(self, r: Rig, k: int, now: float) -> None:
        word = line.stop_word(r, self.conn)
        if word:
            self._send(codec.encode_simple(self.conn.frame, word))
        self._send(line.answer(r, self.conn, k, now))

    def _send(self, size: int) -> None:
        self.write(self.conn.frame[:size].tobytes())

    def _silent(self, r: Rig) -> None:
        now = sleep.now()
        if now - self.conn.numbers[line.LAST_ANSWER] < STALE_AFTER:
            return
        if self.conn.words[line.STARTED]:
            mark_stale(r, now)
        self._send(codec.encode_force(self.conn.frame, 0, 0.0))
        self.conn.numbers[line.LAST_ANSWER] = now

    def _last_act(self) -> None:
        # where the line is gone, the board's own watchdog cuts the motor
        with contextlib.suppress(OSError):
            self._send(codec.encode_force(self.conn.frame, 0, 0.0))

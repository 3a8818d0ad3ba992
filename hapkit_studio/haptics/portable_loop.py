"""The serial loop as a plain Python thread, for systems whose ports are no file descriptors.

The same tick, codec and answers as the compiled loop; only waiting, reading and writing differ.
"""

import contextlib

import numpy as np

from hapkit_studio.haptics import block, exchange, histogram, line, rig, settings, sleep
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.line import Line, new_line
from hapkit_studio.haptics.rig import Rig, new_rig
from hapkit_studio.haptics.ring import Ring, new_ring
from hapkit_studio.haptics.tick import STALE_AFTER, latch
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Sample


def warm_up() -> None:
    """Compile or load all that a sample needs, by rendering one under a latched fault, that calls no law."""
    r, conn = new_rig(*block.new_block()), new_line(1.0)
    r.control[rig.FAULT] = rig.RUNAWAY
    frame = np.frombuffer(encode(Sample(*13 * (0,))), dtype=np.uint8)
    conn.data[: len(frame)] = frame
    exchange.take(r, conn, new_ring(r.control, 2), histogram.new_histogram(), len(frame))
    exchange.silence(r, conn)
    exchange.given_up(r, conn)
    exchange.zero(conn)


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
                    part = data[start : start + line.CHUNK]
                    self.conn.data[: len(part)] = part
                    self._send(exchange.take(r, self.conn, out, late, len(part)))
                self._send(exchange.silence(r, self.conn))
                if exchange.given_up(r, self.conn):
                    break
        except OSError:
            latch(r, rig.DEVICE_GONE, 0.0, 0.0)
        finally:
            self._last_act()
            store_release(r.control, rig.DONE, 1)

    def _send(self, size: int) -> None:
        if size:
            self.write(self.conn.frame[:size].tobytes())

    def _last_act(self) -> None:
        # where the line is gone, the board's own watchdog cuts the motor
        with contextlib.suppress(OSError):
            self._send(exchange.zero(self.conn))

"""The live loop on a serial port: wakes on a frame, answers at once, never spins.

What hangs up, errs or ends (poll(2): HUP, ERR, NVAL; read(2): 0, EIO) ends the loop with a latched fault, and
so does a board that sends nothing any more: one that began anew in mid-motion has forgotten to stream.
"""

import errno

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, clib, exchange, line, rig, settings, sleep
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.priority import demote
from hapkit_studio.haptics.simulated_loop import MOST_PASSES_WITHOUT_WAITING
from hapkit_studio.haptics.tick import STALE_AFTER, latch

_POLLIN = 1
_POLL_ENDED = 8 | 16 | 32
_EAGAIN, _EINTR = errno.EAGAIN, errno.EINTR
_TIMEOUT_MS = int(1e3 * STALE_AFTER)
# A poll that finds bytes there returns in a few microseconds; one that waited took longer.
_NO_WAIT = 10e-6


@internal
def send(fd, frame, size):
    """Write what is to be sent, if anything; a full line drops it, the board's watchdog covers that."""
    if size > 0:
        clib.write(fd, frame.ctypes.data, size)


@internal
def wait(fd, spec):
    """Wait for bytes for up to STALE_AFTER; return 1 for bytes, 0 for none, -1 where the line has ended."""
    spec[0] = fd | (_POLLIN << 32)
    ready = clib.poll(spec.ctypes.data, 1, _TIMEOUT_MS)
    if ready < 0:
        return 0 if clib.last_error() == _EINTR else -1
    events = (spec[0] >> 48) & 0xFFFF
    if events & _POLLIN:
        return 1
    return -1 if events & _POLL_ENDED else 0


@compiled
def hold_back(r, before, hurried):
    """Latch once that the machine cannot keep up, and wait a period a pass until that is cleared.

    Return how many passes in a row found bytes there. After a period's wait the next one does as well, so
    clearing begins the count anew: else no board at its own rate could ever be cleared.
    """
    if hurried == MOST_PASSES_WITHOUT_WAITING + 1:
        latch(r, rig.RUNAWAY, 1.0 / r.values[block.PERIOD], 0.0)
        demote()
    sleep.until(before + r.values[block.PERIOD])
    return hurried if load_acquire(r.control, rig.FAULT) else 0


@compiled
def run(r, conn, out, late, fd, spec):
    """Own the calling thread until told to quit or the line ends; the last act is a zero command."""
    settings.adopt(r, 0.0)
    conn.numbers[line.LAST_ANSWER] = sleep.now()
    hurried = 0
    while load_acquire(r.control, rig.QUIT) == 0:
        before = sleep.now()
        state = wait(fd, spec)
        hurried = hurried + 1 if sleep.now() - before < _NO_WAIT else 0
        size = 0
        if state > 0:
            size = clib.read(fd, conn.data.ctypes.data, conn.data.size)
            if size == 0 or (size < 0 and clib.last_error() not in (_EAGAIN, _EINTR)):
                state = -1
        if state < 0:
            latch(r, rig.DEVICE_GONE, 0.0, r.real[rig.LAST_POSITION])
            break
        if size > 0:
            send(fd, conn.frame, exchange.take(r, conn, out, late, size))
        send(fd, conn.frame, exchange.silence(r, conn))
        if exchange.given_up(r, conn):
            break
        if hurried > MOST_PASSES_WITHOUT_WAITING:
            hurried = hold_back(r, before, hurried)
    send(fd, conn.frame, exchange.zero(conn))
    store_release(r.control, rig.DONE, 1)


def new_spec() -> np.ndarray:
    """Return room for one pollfd structure."""
    return np.zeros(1, dtype=np.int64)

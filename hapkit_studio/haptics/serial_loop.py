"""The live loop on a serial port: a frame wakes the loop, which answers at once and never busy-waits.

Each chunk of received bytes gets one answer. The compiled loop, and the plain Python thread for systems whose
ports are not file descriptors, use the same functions. These write the answer to the start of the link's
``frame`` and return its length.

A hang-up, an error or the end of the line (poll(2): HUP, ERR, NVAL; read(2): 0, EIO) ends the loop with a
latched fault. The loop also ends if the board stops sending, because a restarted board no longer streams.
"""

import contextlib
import errno
from collections.abc import Callable

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import arrays, block, board_rendering, clib, clock, health, link, rows
from hapkit_studio.haptics.arrays import LoopArrays, new_arrays
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.link import Link, new_link
from hapkit_studio.haptics.priority import demote
from hapkit_studio.haptics.rows import Ring, new_ring
from hapkit_studio.haptics.simulated_loop import MOST_PASSES_WITHOUT_WAITING
from hapkit_studio.haptics.tick import STALE_AFTER, adopt, latch
from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.framing import encode
from hapkit_studio.protocol.messages import Sample

# s: time limit for rendering the samples before the newest one. After a longer time, the forces for these
# samples and for the newest one would be too old.
CATCH_UP = 0.005


@compiled
def take(r: LoopArrays, conn: Link, out: Ring, late: np.ndarray, size: int) -> int:
    """Render the samples in the first ``size`` bytes of the line's data, and answer the newest sample.

    Older samples in the same chunk count as missed, because their answers would be too late. If the law is
    too slow for them, they are skipped. Telemetry is written to rows.
    """
    count = codec.feed(conn.reader, conn.buffer, conn.data, size, conn.samples)
    now, length, skipped = clock.now(), 0, 0
    if count > 0:
        conn.state.quiet = 0.0
    for k in range(count):
        sample = conn.samples[k]
        link.check_clock(r, conn, sample, now)
        if k == count - 1:
            link.note_gap(r, conn, now)
        elif has_no_time_for(r, conn, sample, count - 1 - k):
            skipped += 1 + int(sample[codec.LOST])
            continue
        sample[codec.LOST] += skipped
        skipped = 0
        shown = fill_row(r, conn, out, k, now)
        store_release(r.control.lost_frames, 0, conn.reader[codec.LOST_FRAMES])
        store_release(r.control.crc_errors, 0, conn.reader[codec.BAD_FRAMES])
        if k == count - 1:
            length = answer(r, conn, k, now)
        if not shown:
            continue
        row = out.rows[rows.next_index(out)]
        row[rows.COMPUTE] = clock.now() - now
        health.add_lateness(late, row[rows.LATENESS])
        rows.publish(out)
    if count > 1 and link.computer_answers(conn):
        store_release(r.control.missed, 0, r.control.missed[0] + count - 1)
    return length


@internal
def has_no_time_for(r: LoopArrays, conn: Link, sample: np.ndarray, older: int) -> bool:
    """Return True if the law's last duration leaves no time to render samples before the newest one."""
    if sample[codec.KIND] != codec.SAMPLE or not conn.state.last_was_sample:
        return False
    each = r.tick.law_time
    return each > r.settings.period or older * each > CATCH_UP


@internal
def fill_row(r: LoopArrays, conn: Link, out: Ring, k: int, now: float) -> bool:
    """Fill the ring's next row from frame k; return False if the row must not be published.

    While the board changes its zero no row is published, because the count may refer to the old zero.
    """
    state = conn.state
    count_errors(r, conn, conn.samples[k])
    if conn.samples[k, codec.KIND] == codec.TELEMETRY:
        state.last_was_sample = 0
        board_rendering.show(r, conn, out, k, now)
        return True
    if state.handover == link.SENDING_SETTINGS or state.handover == link.SENDING_LAW:
        # a board that applies settings or verifies a law skips samples: these are not lost on the line
        conn.reader[codec.LOST_FRAMES] -= int(conn.samples[k, codec.LOST])
    if state.handover == link.SENDING_SETTINGS:
        state.left_out, state.last_was_sample = 1, 0
        return False
    if state.handover == link.RETURNING:
        state.handover, state.last_was_sample = link.ON_COMPUTER, 0
    elif state.handover == link.ON_BOARD:  # the board has lost its law
        state.handover, state.law_due = link.SENDING_LAW, 1
    if not state.last_was_sample:
        # the computer's tick continues from the motion that the board measured
        link.resume(r, conn, conn.samples[k, codec.COUNT], r.tick.velocity)
        conn.forces[:] = 0.0
        conn.state.effect = 0.0
        state.last_was_sample = 1
    link.render(r, conn, out, k, now)
    return True


@internal
def count_errors(r: LoopArrays, conn: Link, sample: np.ndarray) -> None:
    """Count forces that the board refused, and frames that it could not read, from its 8-bit counters."""
    state = conn.state
    errors, stale = int(sample[codec.RX_ERRORS]), int(sample[codec.STALE])
    if state.started and sample[codec.KIND] == codec.SAMPLE:
        more = (stale - state.stale_reported) & 0xFF
        store_release(r.control.stale_forces, 0, r.control.stale_forces[0] + more)
    if state.started:
        more = (errors - state.errors_reported) & 0xFF
        store_release(r.control.board_errors, 0, r.control.board_errors[0] + more)
    state.errors_reported = errors
    if sample[codec.KIND] == codec.SAMPLE:
        state.stale_reported = stale


@internal
def answer(r: LoopArrays, conn: Link, k: int, now: float) -> int:
    """Encode the answer to frame k: an E-stop change, then a force or a message to a rendering board.

    While the board renders, a latched fault also stops the board. With added delay the answer belongs to an
    earlier sample.
    """
    state, length, stopped = conn.state, 0, load_acquire(r.control.stop, 0)
    conn.state.last_answer = now
    if state.handover != link.ON_COMPUTER and load_acquire(r.control.fault, 0) != arrays.NO_FAULT:
        stopped = 1
    if stopped != state.sent_stop:
        state.sent_stop = stopped
        if not stopped:
            state.law_due = 1  # the law's state has changed since it was sent
        length = codec.encode_simple(conn.frame, codec.STOP if stopped else codec.RELEASE)
    if not link.computer_answers(conn):
        return length + board_rendering.answer(r, conn, k, now, conn.frame[length:])
    newest, behind = int(conn.samples[k, codec.SEQ]), link.added_periods(r)
    force = conn.forces[(newest - behind) % link.HISTORY]
    return length + codec.encode_force(conn.frame[length:], newest, behind, force)


@compiled
def answer_silence(r: LoopArrays, conn: Link) -> int:
    """If no frame was answered for STALE_AFTER, mark the sensor stale and encode zero force.

    A rendering board gets a keep-alive message, because it switches off without one.
    """
    now = clock.now()
    if not link.note_gap(r, conn, now):
        return 0
    conn.state.last_answer = now
    if conn.state.handover < link.SENDING_LAW:
        return encode_zero(conn)
    return codec.encode_simple(conn.frame, law_frames.HELLO_REQUEST)


@compiled
def encode_zero(conn: Link) -> int:
    """Encode zero force, the last message of every loop; a rendering board is told to stop rendering first.

    After a single such message the board's force fades out over 30 ms; after a second one the board stops at
    once.
    """
    length = 0
    if conn.state.handover >= link.SENDING_LAW:
        length = codec.encode_simple(conn.frame, law_frames.LEAVE)
        length += codec.encode_simple(conn.frame[length:], law_frames.LEAVE)
    return length + codec.encode_force(conn.frame[length:], 0, 0, 0.0)


_POLLIN = 1
_POLL_ENDED = 8 | 16 | 32
_EAGAIN, _EINTR = errno.EAGAIN, errno.EINTR
_TIMEOUT_MS = int(1e3 * STALE_AFTER)
# s: poll takes less time than this if bytes are already available, and more if it has to wait
_NO_WAIT = 10e-6


@internal
def send(fd: int, frame: np.ndarray, size: int) -> None:
    """Write ``size`` bytes of a frame; drop them if the line's buffer is full, which the board tolerates."""
    if size > 0:
        clib.write(fd, frame.ctypes.data, size)


@internal
def wait(fd: int, spec: np.ndarray) -> int:
    """Wait up to STALE_AFTER for bytes; return 1 for bytes, 0 for a time-out, -1 if the line has ended."""
    spec[0] = fd | (_POLLIN << 32)
    ready = clib.poll(spec.ctypes.data, 1, _TIMEOUT_MS)
    if ready < 0:
        return 0 if clib.last_error() == _EINTR else -1
    events = (spec[0] >> 48) & 0xFFFF
    if events & _POLLIN:
        return 1
    return -1 if events & _POLL_ENDED else 0


@compiled
def wait_if_too_slow(r: LoopArrays, before: float, hurried: int) -> int:
    """Latch a fault if the machine is too slow; wait a period per iteration until the fault is cleared.

    Return the number of consecutive iterations that found bytes without waiting. Clearing the fault resets
    this number. Without the reset, the fault of a board with its own rate could never be cleared, because
    bytes are always available after a wait of a period.
    """
    if hurried == MOST_PASSES_WITHOUT_WAITING + 1:
        latch(r, arrays.RUNAWAY, 1.0 / r.settings.period, 0.0)
        demote()
    clock.until(before + r.settings.period)
    return hurried if load_acquire(r.control.fault, 0) else 0


@compiled
def run(r: LoopArrays, conn: Link, out: Ring, late: np.ndarray, fd: int) -> None:
    """Run the loop in the calling thread until it must quit or the line ends; always send zero force last."""
    adopt(r, 0.0)
    conn.state.last_answer = clock.now()
    hurried = 0
    while load_acquire(r.control.quit, 0) == 0:
        before = clock.now()
        state = wait(fd, conn.poll)
        hurried = hurried + 1 if clock.now() - before < _NO_WAIT else 0
        size = 0
        if state > 0:
            size = clib.read(fd, conn.data.ctypes.data, conn.data.size)
            if size == 0 or (size < 0 and clib.last_error() not in (_EAGAIN, _EINTR)):
                state = -1
        if state < 0:
            latch(r, arrays.DEVICE_GONE, 0.0, r.tick.last_position)
            break
        if size > 0:
            send(fd, conn.frame, take(r, conn, out, late, size))
        send(fd, conn.frame, answer_silence(r, conn))
        if link.board_gone(r, conn, clock.now()):
            break
        if hurried > MOST_PASSES_WITHOUT_WAITING:
            hurried = wait_if_too_slow(r, before, hurried)
    send(fd, conn.frame, encode_zero(conn))
    store_release(r.control.done, 0, 1)


def warm_up() -> None:
    """Compile or load everything that a sample needs by rendering one with a latched fault and no law."""
    r, conn = new_arrays(block.new_block()), new_link(1.0)
    r.control.fault[0] = arrays.RUNAWAY
    frame = np.frombuffer(encode(Sample(*13 * (0,))), dtype=np.uint8)
    conn.data[: len(frame)] = frame
    take(r, conn, new_ring(r.control, 2), health.new_histogram(), len(frame))
    answer_silence(r, conn)
    link.board_gone(r, conn, 0.0)
    encode_zero(conn)


def run_portable(
    r: LoopArrays,
    conn: Link,
    out: Ring,
    late: np.ndarray,
    read: Callable[[float], bytes],
    write: Callable[[bytes], object],
) -> None:
    """Run the loop in a plain Python thread, for systems whose ports are not file descriptors.

    Tick, codec and answers are those of ``run``. The loop waits, reads and writes with read(seconds) and
    write(bytes), which may raise OSError.
    """

    def send(size: int) -> None:
        if size:
            write(conn.frame[:size].tobytes())

    adopt(r, 0.0)
    conn.state.last_answer = clock.now()
    try:
        while not load_acquire(r.control.quit, 0):
            data = np.frombuffer(read(STALE_AFTER), dtype=np.uint8)
            for start in range(0, len(data), link.CHUNK):
                part = data[start : start + link.CHUNK]
                conn.data[: len(part)] = part
                send(take(r, conn, out, late, len(part)))
            send(answer_silence(r, conn))
            if link.board_gone(r, conn, clock.now()):
                break
    except OSError:
        latch(r, arrays.DEVICE_GONE, 0.0, 0.0)
    finally:
        # if the line has ended, the board's watchdog switches the motor off
        with contextlib.suppress(OSError):
            send(encode_zero(conn))
        store_release(r.control.done, 0, 1)

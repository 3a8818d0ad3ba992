"""One chunk of bytes in, one answer out: what both serial loops do, whatever reads and writes for them.

Each function leaves the bytes to send at the start of the line's ``frame`` and returns how many they are.
"""

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics import histogram, line, rig, ring, rows, sleep
from hapkit_studio.haptics.fences import store_release
from hapkit_studio.haptics.tick import STALE_AFTER, mark_stale
from hapkit_studio.protocol import codec


@compiled
def take(r, conn, out, late, size):
    """Render every sample in the first size bytes of the line's data, answer the newest.

    Older samples of the same chunk count as missed: their answers would come too late.
    """
    count = codec.feed(conn.reader, conn.buffer, conn.data, size, conn.samples)
    now, length = sleep.now(), 0
    for k in range(count):
        if k == count - 1:
            line.overslept(r, conn, now)
        line.render(r, conn, out, k, now)
        if k == count - 1:
            length = answer(r, conn, k, now)
        row = out.rows[ring.next_index(out)]
        row[rows.COMPUTE] = sleep.now() - now
        histogram.add(late, row[rows.LATENESS])
        ring.publish(out)
    if count > 1:
        store_release(r.control, rig.MISSED, r.control[rig.MISSED] + count - 1)
    return length


@compiled
def answer(r, conn, k, now):
    """Encode what answers sample k: a changed E-stop first, then the force."""
    word = line.stop_word(r, conn)
    length = codec.encode_simple(conn.frame, word) if word else 0
    return length + line.answer(r, conn, k, now, conn.frame[length:])


@compiled
def silence(r, conn):
    """Where nothing was answered for STALE_AFTER, mark the sensor stale and encode a zero force."""
    now = sleep.now()
    if now - conn.numbers[line.LAST_ANSWER] < STALE_AFTER:
        return 0
    if conn.words[line.STARTED]:
        mark_stale(r, now)
    conn.numbers[line.LAST_ANSWER] = now
    return zero(conn)


@compiled
def zero(conn):
    """Encode a zero force, the last act of every loop."""
    return codec.encode_force(conn.frame, 0, 0.0)

"""One chunk of bytes in, one answer out: what both serial loops do, whatever reads and writes for them.

Each function leaves the bytes to send at the start of the line's ``frame`` and returns how many they are.
"""

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import board_line, board_words, histogram, line, rig, ring, rows, sleep, way
from hapkit_studio.haptics.fences import store_release
from hapkit_studio.haptics.tick import STALE_AFTER, latch, mark_stale, note_time
from hapkit_studio.protocol import codec


@compiled
def take(r, conn, out, late, size):
    """Render every sample in the first size bytes of the line's data, answer the newest.

    Older samples of the same chunk count as missed: their answers would come too late. Telemetry is shown.
    """
    count = codec.feed(conn.reader, conn.buffer, conn.data, size, conn.samples)
    now, length = sleep.now(), 0
    if count > 0:
        conn.numbers[line.QUIET] = 0.0
    begun = now
    for k in range(count):
        if k == count - 1:
            line.overslept(r, conn, now)
        shown = row_of(r, conn, out, k, now)
        if k == count - 1:
            length = answer(r, conn, k, now)
        if not shown:
            continue
        row = out.rows[ring.next_index(out)]
        done = sleep.now()
        row[rows.COMPUTE] = done - now
        note_time(r, done - begun)
        begun = done
        histogram.add(late, row[rows.LATENESS])
        ring.publish(out)
    if count > 1 and way.computer_speaks(conn):
        store_release(r.control, rig.MISSED, r.control[rig.MISSED] + count - 1)
    return length


@compiled
def row_of(r, conn, out, k, now):
    """Fill the ring's next row from frame k; return whether it is one to be shown.

    What comes while the board takes over another zero is not: nobody knows which zero it counts from.
    """
    words = conn.words
    count_errors(r, conn, conn.samples[k])
    if conn.samples[k, codec.KIND] == codec.TELEMETRY:
        words[way.TICKED] = 0
        board_line.render(r, conn, out, k, now)
        return True
    if words[way.WAY] == way.SETTING or words[way.WAY] == way.ASKING:
        # a board that takes over settings or checks a law leaves a sample out: the line lost none
        conn.reader[codec.LOST_FRAMES] -= int(conn.samples[k, codec.LOST])
    if words[way.WAY] == way.SETTING:
        words[way.UNSHOWN], words[way.TICKED] = 1, 0
        return False
    if words[way.WAY] == way.RETURNING:
        words[way.WAY], words[way.TICKED] = way.HERE, 0
    elif words[way.WAY] == way.THERE:  # the board has lost its law
        words[way.WAY], words[way.LAW_DUE] = way.ASKING, 1
    if not words[way.TICKED]:
        board_line.come_back(r, conn, conn.samples[k, codec.COUNT])
        words[way.TICKED] = 1
    line.render(r, conn, out, k, now)
    return True


@internal
def count_errors(r, conn, sample):
    """Add up what the board counts in a byte: forces refused as too old, frames that it could not read."""
    words = conn.words
    errors, stale = int(sample[codec.RX_ERRORS]), int(sample[codec.STALE])
    if words[line.STARTED] and sample[codec.KIND] == codec.SAMPLE:
        more = (stale - words[way.STALE_TOLD]) & 0xFF
        store_release(r.control, rig.STALE_FORCES, r.control[rig.STALE_FORCES] + more)
    if words[line.STARTED]:
        more = (errors - words[way.ERRORS_TOLD]) & 0xFF
        store_release(r.control, rig.BOARD_ERRORS, r.control[rig.BOARD_ERRORS] + more)
    words[way.ERRORS_TOLD] = errors
    if sample[codec.KIND] == codec.SAMPLE:
        words[way.STALE_TOLD] = stale


@compiled
def answer(r, conn, k, now):
    """Encode what answers frame k: a changed E-stop first, then force, or a word where the board renders."""
    word = line.stop_word(r, conn)
    length = codec.encode_simple(conn.frame, word) if word else 0
    if way.computer_speaks(conn):
        return length + line.answer(r, conn, k, now, conn.frame[length:])
    return length + board_words.speak(r, conn, k, now, conn.frame[length:])


@compiled
def given_up(r, conn):
    """Return whether the board has been silent for too long; that is latched as gone, with how long in s."""
    if not line.quiet(conn, sleep.now()):
        return False
    latch(r, rig.DEVICE_GONE, line.GONE_AFTER, r.real[rig.LAST_POSITION])
    return True


@compiled
def silence(r, conn):
    """Where nothing was answered for STALE_AFTER, mark the sensor stale and encode a zero force.

    A board that renders hears a question: without a word that the computer is there it switches off.
    """
    now = sleep.now()
    if now - conn.numbers[line.LAST_ANSWER] < STALE_AFTER:
        return 0
    if conn.words[line.STARTED]:
        mark_stale(r, now, line.cause(r, conn, now))
    conn.numbers[line.LAST_ANSWER] = now
    if conn.words[way.WAY] < way.ASKING:
        return zero(conn)
    return board_words.hello(conn.frame)


@compiled
def zero(conn):
    """Encode a zero force, the last act of every loop."""
    if conn.words[way.WAY] >= way.ASKING:
        return board_words.last_act(conn, conn.frame)
    return codec.encode_force(conn.frame, 0, 0, 0.0)

"""What the computer says to a board that renders, or is to: settings, the law, its constants, presence.

Each function writes its frames to ``frame`` and returns their length.
"""

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, line, rig, way
from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.law_frames import PIECE, TUNED

ALIVE_APART = 4e-3
"""s between two words that the computer is there. A board goes silent 25 ms after the last: five may be lost.

Each costs it 300 cycles.
"""
_HALF_FRAME = 0.5e-3
AT_ONCE = 3
"""Pieces of a law that may go out together, one for each frame that has come.

The board works one off in a millisecond, and has room for 128 bytes that wait.
"""
WINDOW = 16 * PIECE
"""Bytes of a law that may be under way."""
REPEAT = 0.02
"""s beyond a round trip after which pieces that have not arrived are sent again."""
TUNE_AGAIN = 0.05
"""The same for constants; those before them have moved by then and left their room."""
STUCK = 0.5
"""s in which a law that has arrived whole begins."""
_GENERATIONS = 255
FIRST_SLOT = 2
"""The first slot behind position and velocity."""


@compiled
def speak(r, conn, k, now, frame):
    """Answer frame k."""
    n, words = conn.numbers, conn.words
    n[line.LAST_ANSWER] = now
    at = words[way.WAY]
    if at == way.LEAVING:
        length = zero(conn, k, frame)
        return length + begin(r, conn, k, now, frame[length:])
    if at == way.SETTING:
        return settle(conn, k, now, frame)
    form = way.wanted(r, conn)
    if at != way.RETURNING and form == 0:
        at = turn_back(conn)
    if at == way.RETURNING:
        return give_over(conn, k, now, frame)
    if at == way.ASKING:
        return ask(r, conn, k, now, frame, form)
    return go_on(r, conn, k, now, frame, form)


@internal
def zero(conn, k, frame):
    """Encode a force of zero in answer to sample k."""
    return codec.encode_force(frame, int(conn.samples[k, codec.SEQ]), 0, 0.0)


@internal
def begin(r, conn, k, now, frame):
    """Begin to hand over, the force at zero: the zero first, where the board has another one."""
    n, words = conn.numbers, conn.words
    words[way.LAW_DUE] = 1
    if words[way.CONFIGURABLE] and (n[line.ZERO] != 0.0 or n[line.SIGN] < 0.0):
        fold(conn)
        words[way.WAY] = way.SETTING
        n[way.ASKED_AT] = -way.PATIENCE
        words[way.SETTINGS_SEEN] = conn.reader[codec.SETTINGS_FRAMES]
        return settle(conn, k, now, frame)
    words[way.WAY] = way.ASKING
    return ask(r, conn, k, now, frame, way.wanted(r, conn))


@internal
def fold(conn):
    """Put the zero and direction that a person has set into the settings that the board is to take over.

    The board's zero counts before its sense; its force follows its direction.
    """
    body, n = conn.settings, conn.numbers
    sense = law_frames.signed(body, law_frames.AT_SENSE, 1)
    zero = law_frames.signed(body, law_frames.AT_ZERO, 4) + sense * int(n[line.ZERO])
    law_frames.put_whole(body, law_frames.AT_ZERO, 4, zero)
    if n[line.SIGN] < 0.0:
        direction = law_frames.signed(body, law_frames.AT_DIRECTION, 1)
        law_frames.put_whole(body, law_frames.AT_SENSE, 1, -sense)
        law_frames.put_whole(body, law_frames.AT_DIRECTION, 1, -direction)


@internal
def settle(conn, k, now, frame):
    """Wait until the board has the settings; from the next frame on its counts are ours."""
    n, words = conn.numbers, conn.words
    if conn.reader[codec.SETTINGS_FRAMES] != words[way.SETTINGS_SEEN]:
        n[line.ZERO], n[line.SIGN] = 0.0, 1.0
        words[way.WAY] = way.ASKING
        return zero(conn, k, frame)
    if now - n[way.ASKED_AT] < way.PATIENCE:
        return zero(conn, k, frame)
    n[way.ASKED_AT] = now
    return law_frames.encode_body(frame, conn.settings)


@internal
def ask(r, conn, k, now, frame, form):
    """Say what the board is to render until it has heard, then send it in pieces; hear why it refuses."""
    n, words, sample = conn.numbers, conn.words, conn.samples[k]
    if words[way.LAW_DUE] or words[way.FORM] != form:
        choose(r, conn, k, form)
    heard = sample[codec.KIND] == codec.SAMPLE and int(sample[codec.GENERATION]) == words[way.LAW_GENERATION]
    if not heard:
        if now - n[way.ASKED_AT] < way.PATIENCE:
            return now_and_then(conn, k, frame, law_frames.ALIVE)
        n[way.ASKED_AT] = n[way.MOVED_AT] = now
        return announce(conn, frame)
    if sample[codec.REFUSAL] != 0.0:
        words[way.REFUSED], words[way.REFUSAL] = form, int(sample[codec.REFUSAL])
        turn_back(conn)
        return give_over(conn, k, now, frame)
    return pieces(conn, k, now, frame)


@internal
def choose(r, conn, k, form):
    """Take the law in force to send it to the board, with a generation of its own."""
    n, words = conn.numbers, conn.words
    words[way.LAW_GENERATION] = next_generation(conn, k)
    words[way.FORM], words[way.PROGRAM] = form, r.words[block.PROGRAM]
    for i in range(block.PROGRAM_WORDS):
        conn.program[i] = r.program[i]
    for i in range(conn.law.size):
        conn.law[i] = r.words[block.BOARD_RATE + i]
    conn.unsure[:] = 0
    words[way.LAW_DUE] = words[way.RECEIVED] = words[way.SENT] = words[way.TUNING] = 0
    n[way.FIRST], n[way.SECOND] = r.values[block.BOARD_FIRST], r.values[block.BOARD_SECOND]
    n[way.ASKED_AT] = -way.PATIENCE


@internal
def next_generation(conn, k):
    """Return a number from 1 to 255 that is neither the last law's nor what the board says now."""
    words, told = conn.words, int(conn.samples[k, codec.GENERATION])
    generation = words[way.GENERATION]
    for _ in range(3):
        generation = generation % _GENERATIONS + 1
        if generation != words[way.LAW_GENERATION] and generation != told:
            break
    words[way.GENERATION] = generation
    return generation


@internal
def announce(conn, frame):
    """Encode what the law is like that the board is to get."""
    n, law = conn.numbers, conn.law
    return law_frames.encode_law(
        frame,
        conn.words[way.LAW_GENERATION],
        law[line.RATE],
        law[line.ESTIMATOR],
        n[way.FIRST],
        n[way.SECOND],
        law[line.STATES],
        law[line.GIVEN],
        law[line.SLOTS],
        law[line.CODE],
        law[line.CHECK],
    )


@internal
def pieces(conn, k, now, frame):
    """Send the next bytes of the law; go back to the first one missing where none has arrived for a while."""
    n, words = conn.numbers, conn.words
    whole = 4 * conn.law[line.GIVEN] + conn.law[line.CODE]
    received = min(int(conn.samples[k, codec.RECEIVED]), whole)
    if received != words[way.RECEIVED]:
        grown = received > words[way.RECEIVED]
        words[way.SENT] = max(words[way.SENT], received) if grown else received
        words[way.RECEIVED], n[way.MOVED_AT] = received, now
    elif received == whole:
        words[way.LAW_DUE] = now - n[way.MOVED_AT] > STUCK
    elif now - n[way.MOVED_AT] > REPEAT + n[way.ROUND_TRIP]:
        words[way.SENT], n[way.MOVED_AT] = received, now
    length = 0
    for _ in range(min(k + 1, AT_ONCE)):
        sent = words[way.SENT]
        if sent < min(whole, received + WINDOW):
            generation = words[way.LAW_GENERATION]
            length += law_frames.encode_piece(frame[length:], generation, sent, conn.program)
            words[way.SENT] = min(sent + PIECE, whole)
    return length if length else now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def turn_back(conn):
    """Let the computer render again, once the board has given over; return that way."""
    conn.words[way.WAY] = way.RETURNING
    conn.numbers[way.ASKED_AT] = -way.PATIENCE
    return way.RETURNING


@internal
def give_over(conn, k, now, frame):
    """Tell the board that the computer renders; again where telemetry goes on."""
    n = conn.numbers
    if now - n[way.ASKED_AT] < way.PATIENCE:
        return now_and_then(conn, k, frame, law_frames.ALIVE)
    n[way.ASKED_AT] = now
    return codec.encode_simple(frame, law_frames.LEAVE)


@internal
def go_on(r, conn, k, now, frame, form):
    """Say which law is new, or which constants, or only that the computer is there."""
    n, words = conn.numbers, conn.words
    if r.word[rig.STALE]:
        return now_and_then(conn, k, frame, law_frames.HELLO_REQUEST)
    if words[way.TUNING] != 0:
        if int(conn.samples[k, codec.GENERATION]) == words[way.TUNING]:
            words[way.TUNING] = 0
            conn.unsure[:] = 0
        elif now - n[way.TUNED_AT] > TUNE_AGAIN + n[way.ROUND_TRIP]:
            words[way.TUNING] = words[way.PROGRAM] = 0
    changed = 0
    if words[way.TUNING] == 0 and words[way.PROGRAM] != r.words[block.PROGRAM]:
        changed = changes(r, conn)
    if words[way.LAW_DUE] or words[way.FORM] != form or changed > r.words[block.BOARD_MOVING]:
        words[way.WAY], words[way.LAW_DUE] = way.ASKING, 1
        return ask(r, conn, k, now, frame, form)
    if changed > 0:
        return tune(r, conn, k, now, frame)
    if words[way.TUNING] == 0:
        words[way.PROGRAM] = r.words[block.PROGRAM]
    return now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def other(r, conn, i):
    """Return whether the board may have another i-th constant than it is to have."""
    return conn.unsure[i] or law_frames.constant_of(conn.program, i) != law_frames.constant_of(r.program, i)


@internal
def changes(r, conn):
    """Return how many constants the board may have otherwise than it is to have them."""
    count = 0
    for i in range(conn.law[line.STATES], conn.law[line.GIVEN]):
        count += other(r, conn, i)
    return count


@internal
def tune(r, conn, k, now, frame):
    """Send the first constants that are new; until the board says so nobody knows whether it has them."""
    n, words = conn.numbers, conn.words
    words[way.TUNING], n[way.TUNED_AT] = next_generation(conn, k), now
    law_frames.begin_tune(frame, words[way.LAW_GENERATION], words[way.TUNING])
    left = TUNED
    for i in range(conn.law[line.STATES], conn.law[line.GIVEN]):
        if left > 0 and other(r, conn, i):
            bits = law_frames.constant_of(r.program, i)
            law_frames.add_constant(frame, FIRST_SLOT + i, bits)
            law_frames.put_constant(conn.program, i, bits)
            conn.unsure[i] = 1
            left -= 1
    return law_frames.end_tune(frame)


@internal
def now_and_then(conn, k, frame, word):
    """Say a word without fields every few milliseconds by the board's clock."""
    time = conn.samples[k, codec.BOARD_TIME]
    if 0.0 <= time - conn.numbers[way.ALIVE_AT] < ALIVE_APART - _HALF_FRAME:
        return 0
    conn.numbers[way.ALIVE_AT] = time
    return codec.encode_simple(frame, word)


@compiled
def last_act(conn, frame):
    """Take the board's law away, then command zero: the last act of a loop while the board renders.

    Told twice the board does so at once; told once it lets its force go out over 30 ms.
    """
    length = codec.encode_simple(frame, law_frames.LEAVE)
    length += codec.encode_simple(frame[length:], law_frames.LEAVE)
    return length + codec.encode_force(frame[length:], 0, 0, 0.0)


@compiled
def hello(frame):
    """Ask whether anybody is there: what does not keep the motor on."""
    return codec.encode_simple(frame, law_frames.HELLO_REQUEST)

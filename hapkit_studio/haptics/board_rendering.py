"""A board that renders: what the computer sends it, and how its telemetry becomes rows.

Settings, the law, its constants and that the computer is there are sent. Each such function writes its
frames to ``frame`` and returns their length.
"""

import math

import numpy as np

from hapkit_studio.devices import delays
from hapkit_studio.dynamics.jit import internal
from hapkit_studio.haptics import arrays, block, link, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.link import Link
from hapkit_studio.haptics.rows import Ring
from hapkit_studio.haptics.tick import due, latch, recover, refresh
from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.law_frames import PIECE, TUNED

FRAME = 1e-3  # s: the least from one frame of telemetry to the next
TICK = 0.5e-6  # s: the unit of a board's period
_FADE = 0.030
_OFF = codec.FLAG_WATCHDOG | codec.FLAG_REFUSED | codec.FLAG_OVER_SPEED | codec.FLAG_STOPPED


@internal
def frame_seconds(period: int) -> float:
    """Return the s from one frame of telemetry to the next at a board's period; at least FRAME."""
    if period <= 0:
        return FRAME
    return TICK * period * math.ceil(FRAME / (TICK * period) - 1e-9)


@internal
def show(r: LoopArrays, conn: Link, out: Ring, k: int, now: float) -> None:
    """Show the k-th decoded frame, telemetry, in the ring's next row."""
    sample, n = conn.samples[k], conn.numbers
    row = out.rows[rows.next_index(out)]
    note_who_renders(r, conn, sample)
    passed = link.time_since_last(conn, sample)
    period = passed if passed > 0.0 else FRAME
    position = link.position_of(conn, sample[codec.COUNT])
    if due(r):
        fault = r.control.fault[0]
        refresh(r, position, period)
        if fault != arrays.NO_FAULT and r.control.fault[0] == arrays.NO_FAULT:
            n[link.EXCUSED] = now + link.REPEAT_AFTER + n[link.ROUND_TRIP]
    if r.tick.stale:
        recover(r, period)
    link.write_times(conn, sample[codec.BOARD_TIME], row, now)
    delays.note_delay(conn.delays, delays.OF_BOARD, sample[codec.DELAY])
    n[link.SEEN_SPEED] = (position - r.tick.last_position) / period
    fill_row(r, conn, sample, row, position, period)
    frames = period / frame_seconds(conn.law[link.PERIOD])
    if sample[codec.LOST] > 0.0 and conn.law[link.PERIOD] > 0:  # ticks are not all shown
        conn.reader[codec.LOST_FRAMES] += max(int(frames + 0.5) - 1, 0)
    r.tick.row_flags = flags_of(r, conn, sample, now, frames >= 1.5)
    row[rows.FLAGS] = r.tick.row_flags
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT | rows.STALE):
        r.tick.applied = row[rows.APPLIED_FORCE]


@internal
def note_who_renders(r: LoopArrays, conn: Link, sample: np.ndarray) -> None:
    """Notice that the board renders what it was told to, or that it was not told to."""
    n, words = conn.numbers, conn.words
    at, generation = words[link.HANDOVER], int(sample[codec.GENERATION])
    if at == link.SENDING_LAW and generation == words[link.LAW_GENERATION]:
        words[link.HANDOVER], words[link.MOTOR_SEEN_ON] = link.ON_BOARD, 1
        n[link.FADED_AT] = sample[codec.BOARD_TIME] + _FADE
        words[link.OVERRUNS] = int(sample[codec.OVERRUNS])
    elif at <= link.SENDING_SETTINGS:
        return_to_computer(conn)
    r.tick.gain = 0.0


@internal
def finite(value: float) -> float:
    """Return a number, 0 in place of what is none."""
    return value if math.isfinite(value) else 0.0


@internal
def fill_row(
    r: LoopArrays, conn: Link, sample: np.ndarray, row: np.ndarray, position: float, period: float
) -> None:
    """Fill what the board says of motion, force and state; state is kept where its law is in force."""
    t, sign = r.tick, conn.numbers[link.SIGN]
    duty = int(sample[codec.PWM])
    applied = sign * math.copysign(conn.motor[min(abs(duty), conn.motor.size - 1)], duty)
    row[rows.TICK] = t.number
    t.number += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = sign * finite(sample[codec.VELOCITY])
    row[rows.FORCE] = sign * finite(sample[codec.ASKED])
    row[rows.APPLIED_FORCE] = applied
    row[rows.PERIOD] = period
    t.energy += 0.5 * (t.applied + applied) * (position - t.last_position)
    row[rows.ENERGY] = t.energy
    t.applied = applied
    t.last_position = position
    t.velocity = row[rows.VELOCITY]
    r.watch.renew = 1  # the passivity observer does not watch here
    row[rows.ENERGY_GIVEN] = row[rows.ENERGY_LIMIT] = math.nan
    states, at = r.states[t.slot], int(sample[codec.STATE_AT])
    same = conn.words[link.HANDOVER] == link.ON_BOARD and r.settings.board_law == r.settings.law
    if at < r.settings.n_state and same and r.settings.code_id == conn.words[link.CODE_ID]:
        states[at] = sample[codec.STATE]
    for i in range(rows.STATES):
        row[rows.STATE + i] = states[i]


@internal
def flags_of(r: LoopArrays, conn: Link, sample: np.ndarray, now: float, gap: bool) -> int:
    """Return the row's flags; what the board latched is latched here, with words.

    gap: frames are missing before this one, or were not shown. What the sensor left out is one as well.
    """
    n, said = conn.numbers, int(sample[codec.FLAGS])
    missed = (int(sample[codec.OVERRUNS]) - conn.words[link.OVERRUNS]) & 0xFF
    if missed and conn.words[link.HANDOVER] >= link.ON_BOARD:
        store_release(r.control.missed, 0, r.control.missed[0] + missed)
        conn.words[link.SKIPPED] += missed
    conn.words[link.OVERRUNS] = int(sample[codec.OVERRUNS])
    latch_reported_faults(r, n, said, now)
    off = said & codec.FLAG_WATCHDOG != 0 and said & codec.FLAG_STOPPED == 0
    if off and conn.words[link.MOTOR_SEEN_ON] and not r.tick.stale:
        causes = r.control.stale_causes  # switched off although it was told that someone is there
        store_release(causes, arrays.CUT, causes[arrays.CUT] + 1)
    conn.words[link.MOTOR_SEEN_ON] = not off
    flags = rows.GAP if gap or said & codec.FLAG_SENSOR else 0
    if said & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    if said & codec.FLAG_STOPPED:
        flags |= rows.STOPPED
    if said & codec.FLAG_WATCHDOG or r.tick.stale:
        flags |= rows.STALE
    if r.control.fault[0] != arrays.NO_FAULT:
        flags |= rows.FAULT
    if said & _OFF:
        n[link.FADED_AT] = sample[codec.BOARD_TIME] + _FADE
    elif sample[codec.BOARD_TIME] < n[link.FADED_AT]:
        flags |= rows.FADING
    return flags


@internal
def latch_reported_faults(r: LoopArrays, n: np.ndarray, said: int, now: float) -> None:
    """Latch over-speed and a force that is no number, unless the board was told just now to forget them.

    A board that saw a leap gives up its estimate: then the speed is what its positions come to.
    """
    speed, position = r.tick.velocity, r.tick.last_position
    if now < n[link.EXCUSED]:
        return
    if said & codec.FLAG_OVER_SPEED or abs(speed) > r.settings.max_speed:
        seen = n[link.SEEN_SPEED]
        latch(r, arrays.OVER_SPEED, speed if abs(speed) > r.settings.max_speed else seen, position)
    if said & codec.FLAG_REFUSED:
        latch(r, arrays.NOT_A_NUMBER, math.nan, position)


# s between two words that the computer is there. A board goes silent 25 ms after the last: five may be lost.
# Each costs it 300 cycles.
ALIVE_APART = 4e-3
_HALF_FRAME = 0.5e-3
# Pieces of a law that may go out together, one for each frame that has come: the board works one off in a
# millisecond, and has room for 128 bytes that wait.
AT_ONCE = 3
WINDOW = 16 * PIECE  # bytes of a law that may be under way
REPEAT = 0.02  # s beyond a round trip after which pieces that have not arrived are sent again
TUNE_AGAIN = 0.05  # the same for constants; those before them have moved by then and left their room
STUCK = 0.5  # s in which a law that has arrived whole begins
_GENERATIONS = 255
FIRST_SLOT = 2  # behind position and velocity


@internal
def answer(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Encode what answers frame k, as the handover stands; return its length."""
    at, code_id = conn.words[link.HANDOVER], link.wanted_code(r, conn)
    if at == link.FADING_OUT:
        length = encode_zero(conn, k, frame)
        return length + begin_handover(r, conn, k, now, frame[length:])
    if at == link.SENDING_SETTINGS:
        return send_settings(conn, k, now, frame)
    if at != link.RETURNING and code_id == 0:
        return_to_computer(conn)
    if at == link.RETURNING or code_id == 0:
        return send_leave(conn, k, now, frame)
    if at == link.SENDING_LAW:
        return send_law(r, conn, k, now, frame, code_id)
    return update(r, conn, k, now, frame, code_id)


@internal
def encode_zero(conn: Link, k: int, frame: np.ndarray) -> int:
    """Encode a force of zero in answer to sample k."""
    return codec.encode_force(frame, int(conn.samples[k, codec.SEQ]), 0, 0.0)


@internal
def begin_handover(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Begin to hand over, the force at zero: zero and direction first, where a person has set another one.

    The board's zero counts before its sense; its force follows its direction.
    """
    n, words, body = conn.numbers, conn.words, conn.settings
    words[link.LAW_DUE] = 1
    if not words[link.CONFIGURABLE] or (n[link.ZERO] == 0.0 and n[link.SIGN] > 0.0):
        words[link.HANDOVER] = link.SENDING_LAW
        return send_law(r, conn, k, now, frame, link.wanted_code(r, conn))
    sense = law_frames.signed(body, law_frames.AT_SENSE, 1)
    zero = law_frames.signed(body, law_frames.AT_ZERO, 4) + sense * int(n[link.ZERO])
    law_frames.put_integer(body, law_frames.AT_ZERO, 4, zero)
    if n[link.SIGN] < 0.0:
        direction = law_frames.signed(body, law_frames.AT_DIRECTION, 1)
        law_frames.put_integer(body, law_frames.AT_SENSE, 1, -sense)
        law_frames.put_integer(body, law_frames.AT_DIRECTION, 1, -direction)
    words[link.HANDOVER], n[link.ASKED_AT] = link.SENDING_SETTINGS, -link.REPEAT_AFTER
    words[link.SETTINGS_SEEN] = conn.reader[codec.SETTINGS_FRAMES]
    return send_settings(conn, k, now, frame)


@internal
def send_settings(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Wait until the board has the settings; from the next frame on its counts are ours."""
    n, words = conn.numbers, conn.words
    if conn.reader[codec.SETTINGS_FRAMES] != words[link.SETTINGS_SEEN]:
        n[link.ZERO], n[link.SIGN] = 0.0, 1.0
        words[link.HANDOVER] = link.SENDING_LAW
        return encode_zero(conn, k, frame)
    if now - n[link.ASKED_AT] < link.REPEAT_AFTER:
        return encode_zero(conn, k, frame)
    n[link.ASKED_AT] = now
    return law_frames.encode_body(frame, conn.settings)


@internal
def send_law(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray, code_id: int) -> int:
    """Announce the law until the board acknowledges it, then send its code; take note of a refusal."""
    n, words, sample = conn.numbers, conn.words, conn.samples[k]
    if words[link.LAW_DUE] or words[link.CODE_ID] != code_id:
        take_law(r, conn, k, code_id)
    heard = sample[codec.KIND] == codec.SAMPLE and int(sample[codec.GENERATION]) == words[link.LAW_GENERATION]
    if not heard:
        if now - n[link.ASKED_AT] < link.REPEAT_AFTER:
            return send_now_and_then(conn, k, frame, law_frames.ALIVE)
        n[link.ASKED_AT] = n[link.MOVED_AT] = now
        return encode_law(conn, frame)
    if sample[codec.REFUSAL] != 0.0:
        words[link.REFUSED], words[link.REFUSAL] = code_id, int(sample[codec.REFUSAL])
        return_to_computer(conn)
        return send_leave(conn, k, now, frame)
    return send_pieces(conn, k, now, frame)


@internal
def take_law(r: LoopArrays, conn: Link, k: int, code_id: int) -> None:
    """Take the law in force to send it to the board, with a generation of its own."""
    n, words = conn.numbers, conn.words
    words[link.LAW_GENERATION] = next_generation(conn, k)
    words[link.CODE_ID], words[link.PROGRAM_ID] = code_id, r.settings.program_id
    for i in range(block.PROGRAM_WORDS):
        conn.program[i] = r.program[i]
    for i in range(conn.law.size):
        conn.law[i] = r.settings.board_form[i]
    conn.unsure[:] = 0
    words[link.LAW_DUE] = words[link.RECEIVED] = words[link.SENT] = words[link.TUNING] = 0
    n[link.FIRST], n[link.SECOND] = r.settings.board_first, r.settings.board_second
    n[link.ASKED_AT] = -link.REPEAT_AFTER


@internal
def next_generation(conn: Link, k: int) -> int:
    """Return a number from 1 to 255 that is neither the last law's nor what the board says now."""
    words, told = conn.words, int(conn.samples[k, codec.GENERATION])
    generation = words[link.GENERATION]
    for _ in range(3):
        generation = generation % _GENERATIONS + 1
        if generation != words[link.LAW_GENERATION] and generation != told:
            break
    words[link.GENERATION] = generation
    return generation


@internal
def encode_law(conn: Link, frame: np.ndarray) -> int:
    """Encode the law's header: rate, estimator and sizes."""
    n, law = conn.numbers, conn.law
    return law_frames.encode_law(
        frame,
        conn.words[link.LAW_GENERATION],
        law[link.PERIOD],
        law[link.ESTIMATOR],
        n[link.FIRST],
        n[link.SECOND],
        law[link.STATES],
        law[link.CONSTANTS],
        law[link.SLOTS],
        law[link.CODE],
        law[link.CHECK],
    )


@internal
def send_pieces(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Send the next bytes of the law; go back to the first one missing where none has arrived for a while."""
    n, words = conn.numbers, conn.words
    whole = 4 * conn.law[link.CONSTANTS] + conn.law[link.CODE]
    received = min(int(conn.samples[k, codec.RECEIVED]), whole)
    if received != words[link.RECEIVED]:
        grown = received > words[link.RECEIVED]
        words[link.SENT] = max(words[link.SENT], received) if grown else received
        words[link.RECEIVED], n[link.MOVED_AT] = received, now
    elif received == whole:
        words[link.LAW_DUE] = now - n[link.MOVED_AT] > STUCK
    elif now - n[link.MOVED_AT] > REPEAT + n[link.ROUND_TRIP]:
        words[link.SENT], n[link.MOVED_AT] = received, now
    length = 0
    for _ in range(min(k + 1, AT_ONCE)):
        sent = words[link.SENT]
        if sent < min(whole, received + WINDOW):
            generation = words[link.LAW_GENERATION]
            length += law_frames.encode_piece(frame[length:], generation, sent, conn.program)
            words[link.SENT] = min(sent + PIECE, whole)
    return length if length else send_now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def return_to_computer(conn: Link) -> None:
    """Begin to hand back to the computer."""
    conn.words[link.HANDOVER] = link.RETURNING
    conn.numbers[link.ASKED_AT] = -link.REPEAT_AFTER


@internal
def send_leave(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Encode Leave: the computer renders; again while telemetry goes on."""
    n = conn.numbers
    if now - n[link.ASKED_AT] < link.REPEAT_AFTER:
        return send_now_and_then(conn, k, frame, law_frames.ALIVE)
    n[link.ASKED_AT] = now
    return codec.encode_simple(frame, law_frames.LEAVE)


@internal
def update(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray, code_id: int) -> int:
    """Send a new law, changed constants, or only a sign of life."""
    n, words = conn.numbers, conn.words
    if r.tick.stale:
        return send_now_and_then(conn, k, frame, law_frames.HELLO_REQUEST)
    if words[link.TUNING] != 0:
        if int(conn.samples[k, codec.GENERATION]) == words[link.TUNING]:
            words[link.TUNING] = 0
            conn.unsure[:] = 0
        elif now - n[link.TUNED_AT] > TUNE_AGAIN + n[link.ROUND_TRIP]:
            words[link.TUNING] = words[link.PROGRAM_ID] = 0
    changed = 0
    if words[link.TUNING] == 0 and words[link.PROGRAM_ID] != r.settings.program_id:
        for i in range(conn.law[link.STATES], conn.law[link.CONSTANTS]):
            changed += constant_differs(r, conn, i)
    if words[link.LAW_DUE] or words[link.CODE_ID] != code_id or changed > r.settings.board_moving:
        words[link.HANDOVER], words[link.LAW_DUE] = link.SENDING_LAW, 1
        return send_law(r, conn, k, now, frame, code_id)
    if changed > 0:
        return send_constants(r, conn, k, now, frame)
    if words[link.TUNING] == 0:
        words[link.PROGRAM_ID] = r.settings.program_id
    return send_now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def constant_differs(r: LoopArrays, conn: Link, i: int) -> bool:
    """Return whether the board may have another i-th constant than it is to have."""
    return conn.unsure[i] or law_frames.constant_of(conn.program, i) != law_frames.constant_of(r.program, i)


@internal
def send_constants(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Send the first constants that are new; until the board says so nobody knows whether it has them."""
    n, words = conn.numbers, conn.words
    words[link.TUNING], n[link.TUNED_AT] = next_generation(conn, k), now
    law_frames.begin_tune(frame, words[link.LAW_GENERATION], words[link.TUNING])
    left = TUNED
    for i in range(conn.law[link.STATES], conn.law[link.CONSTANTS]):
        if left > 0 and constant_differs(r, conn, i):
            bits = law_frames.constant_of(r.program, i)
            law_frames.add_constant(frame, FIRST_SLOT + i, bits)
            law_frames.put_constant(conn.program, i, bits)
            conn.unsure[i] = 1
            left -= 1
    return law_frames.end_tune(frame)


@internal
def send_now_and_then(conn: Link, k: int, frame: np.ndarray, word: int) -> int:
    """Encode a message without fields, once every few milliseconds of the board's clock."""
    time = conn.samples[k, codec.BOARD_TIME]
    if 0.0 <= time - conn.numbers[link.ALIVE_AT] < ALIVE_APART - _HALF_FRAME:
        return 0
    conn.numbers[link.ALIVE_AT] = time
    return codec.encode_simple(frame, word)

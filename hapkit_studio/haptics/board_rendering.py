"""Rendering on the board: the messages that the computer sends, and the rows made from telemetry.

The computer sends settings, the law, changed constants and keep-alive messages. A function that sends
something writes its frames to ``frame`` and returns their length in bytes.
"""

import math

import numpy as np

from hapkit_studio.devices import delays
from hapkit_studio.dynamics.jit import internal
from hapkit_studio.haptics import arrays, block, link, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.link import Link
from hapkit_studio.haptics.record import Record
from hapkit_studio.haptics.rows import Ring
from hapkit_studio.haptics.tick import due, latch, recover, refresh
from hapkit_studio.protocol import codec, law_frames
from hapkit_studio.protocol.law_frames import PIECE, TUNED

FRAME = 1e-3  # s: shortest time between telemetry frames
TICK = 0.5e-6  # s: unit of a board's period
_FADE = 0.030
_OFF = codec.FLAG_WATCHDOG | codec.FLAG_REFUSED | codec.FLAG_OVER_SPEED | codec.FLAG_STOPPED


@internal
def frame_seconds(period: int) -> float:
    """Return the time in s between telemetry frames for a board's period in ticks; it is at least FRAME."""
    if period <= 0:
        return FRAME
    return TICK * period * math.ceil(FRAME / (TICK * period) - 1e-9)


@internal
def show(r: LoopArrays, conn: Link, out: Ring, k: int, now: float) -> None:
    """Write the k-th decoded frame, which is telemetry, to the ring's next row."""
    sample, state = conn.samples[k], conn.state
    row = out.rows[rows.next_index(out)]
    note_who_renders(r, conn, sample)
    passed = link.time_since_last(conn, sample)
    period = passed if passed > 0.0 else FRAME
    position = link.position_of(conn, sample[codec.COUNT])
    if due(r):
        fault = r.control.fault[0]
        refresh(r, position, period)
        if fault != arrays.NO_FAULT and r.control.fault[0] == arrays.NO_FAULT:
            state.excused = now + link.REPEAT_AFTER + state.round_trip
    if r.tick.stale:
        recover(r, period)
    link.write_times(conn, sample[codec.BOARD_TIME], row, now)
    delays.note_delay(conn.delays, delays.OF_BOARD, sample[codec.DELAY])
    state.seen_speed = (position - r.tick.last_position) / period
    fill_row(r, conn, sample, row, position, period)
    frames = period / frame_seconds(conn.law[link.PERIOD])
    if sample[codec.LOST] > 0.0 and conn.law[link.PERIOD] > 0:  # some ticks have no row
        conn.reader[codec.LOST_FRAMES] += max(int(frames + 0.5) - 1, 0)
    r.tick.row_flags = flags_of(r, conn, sample, now, frames >= 1.5)
    row[rows.FLAGS] = r.tick.row_flags
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT | rows.STALE):
        r.tick.applied = row[rows.APPLIED_FORCE]


@internal
def note_who_renders(r: LoopArrays, conn: Link, sample: np.ndarray) -> None:
    """Record that the board renders, or that the board has stopped rendering."""
    state = conn.state
    at, generation = state.handover, int(sample[codec.GENERATION])
    if at == link.SENDING_LAW and generation == state.law_generation:
        state.handover, state.motor_seen_on = link.ON_BOARD, 1
        state.faded_at = sample[codec.BOARD_TIME] + _FADE
        state.overruns = int(sample[codec.OVERRUNS])
    elif at <= link.SENDING_SETTINGS:
        return_to_computer(conn)
    r.tick.gain = 0.0


@internal
def finite(value: float) -> float:
    """Return a number, or 0 for NaN and infinity."""
    return value if math.isfinite(value) else 0.0


@internal
def fill_row(
    r: LoopArrays, conn: Link, sample: np.ndarray, row: np.ndarray, position: float, period: float
) -> None:
    """Fill in the board's motion, force and state.

    The state is stored only if the board renders the law of the current settings.
    """
    t, sign = r.tick, conn.state.sign
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
    r.watch.renew = 1  # the passivity observer is inactive while the board renders
    row[rows.ENERGY_GIVEN] = row[rows.ENERGY_LIMIT] = math.nan
    states, at = r.states[t.slot], int(sample[codec.STATE_AT])
    same = conn.state.handover == link.ON_BOARD and r.settings.board_law == r.settings.law
    if at < r.settings.n_state and same and r.settings.code_id == conn.state.code_id:
        states[at] = sample[codec.STATE]
    for i in range(rows.STATES):
        row[rows.STATE + i] = states[i]


@internal
def flags_of(r: LoopArrays, conn: Link, sample: np.ndarray, now: float, gap: bool) -> int:
    """Return the row's flags, and latch the faults that the board reports.

    ``gap`` is true if frames before this one are missing or have no row. Skipped sensor readings also count
    as a gap.
    """
    state, board_flags = conn.state, int(sample[codec.FLAGS])
    missed = (int(sample[codec.OVERRUNS]) - conn.state.overruns) & 0xFF
    if missed and conn.state.handover >= link.ON_BOARD:
        store_release(r.control.missed, 0, r.control.missed[0] + missed)
        conn.state.skipped += missed
    conn.state.overruns = int(sample[codec.OVERRUNS])
    latch_reported_faults(r, state, board_flags, now)
    off = board_flags & codec.FLAG_WATCHDOG != 0 and board_flags & codec.FLAG_STOPPED == 0
    if off and conn.state.motor_seen_on and not r.tick.stale:
        # the board switched its motor off although it had received keep-alive messages
        causes = r.control.stale_causes
        store_release(causes, arrays.CUT, causes[arrays.CUT] + 1)
    conn.state.motor_seen_on = not off
    flags = rows.GAP if gap or board_flags & codec.FLAG_SENSOR else 0
    if board_flags & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    if board_flags & codec.FLAG_STOPPED:
        flags |= rows.STOPPED
    if board_flags & codec.FLAG_WATCHDOG or r.tick.stale:
        flags |= rows.STALE
    if r.control.fault[0] != arrays.NO_FAULT:
        flags |= rows.FAULT
    if board_flags & _OFF:
        state.faded_at = sample[codec.BOARD_TIME] + _FADE
    elif sample[codec.BOARD_TIME] < state.faded_at:
        flags |= rows.FADING
    return flags


@internal
def latch_reported_faults(r: LoopArrays, state: Record, board_flags: int, now: float) -> None:
    """Latch over-speed and non-finite forces, unless a command to clear them was just sent to the board.

    After a jump of the sensor the board resets its velocity estimate; the speed is then computed from the
    positions.
    """
    speed, position = r.tick.velocity, r.tick.last_position
    if now < state.excused:
        return
    if board_flags & codec.FLAG_OVER_SPEED or abs(speed) > r.settings.max_speed:
        seen = state.seen_speed
        latch(r, arrays.OVER_SPEED, speed if abs(speed) > r.settings.max_speed else seen, position)
    if board_flags & codec.FLAG_REFUSED:
        latch(r, arrays.NOT_A_NUMBER, math.nan, position)


# s: interval between keep-alive messages. A board switches off 25 ms after the last message, so five messages
# may be lost. Each message costs the board 300 cycles.
ALIVE_APART = 4e-3
_HALF_FRAME = 0.5e-3
# Largest number of pieces of a law that are sent together, for each received frame. The board processes a
# piece in a millisecond and has an input buffer of 128 bytes.
AT_ONCE = 3
WINDOW = 16 * PIECE  # largest number of bytes of a law that are sent but not yet acknowledged
REPEAT = 0.02  # s: time-out, in addition to a round trip, after which missing pieces are sent again
# the same time-out for constants; by then earlier changes are complete and their buffers are free
TUNE_AGAIN = 0.05
STUCK = 0.5  # s: time-out for the start of a law that was received completely
_GENERATIONS = 255
FIRST_SLOT = 2  # the two slots before it contain position and velocity


@internal
def answer(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Encode the answer to frame k according to the state of the handover; return its length."""
    at, code_id = conn.state.handover, link.wanted_code(r, conn)
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
    return codec.encode_force(frame, int(conn.samples[k, codec.SEQ]), 0, 0.0)


@internal
def begin_handover(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Start the handover at zero force; send zero and direction first if the user has changed them.

    In the board's settings, the zero is a raw sensor count, which does not depend on the direction. The sign
    of the force does depend on the direction.
    """
    state, body = conn.state, conn.settings
    state.law_due = 1
    if not state.configurable or (state.zero == 0.0 and state.sign > 0.0):
        state.handover = link.SENDING_LAW
        return send_law(r, conn, k, now, frame, link.wanted_code(r, conn))
    sense = law_frames.signed(body, law_frames.AT_SENSE, 1)
    zero = law_frames.signed(body, law_frames.AT_ZERO, 4) + sense * int(state.zero)
    law_frames.put_integer(body, law_frames.AT_ZERO, 4, zero)
    if state.sign < 0.0:
        direction = law_frames.signed(body, law_frames.AT_DIRECTION, 1)
        law_frames.put_integer(body, law_frames.AT_SENSE, 1, -sense)
        law_frames.put_integer(body, law_frames.AT_DIRECTION, 1, -direction)
    state.handover, state.requested_at = link.SENDING_SETTINGS, -link.REPEAT_AFTER
    state.settings_seen = conn.reader[codec.SETTINGS_FRAMES]
    return send_settings(conn, k, now, frame)


@internal
def send_settings(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Send the settings until the board confirms them; the board then uses the computer's zero."""
    state = conn.state
    if conn.reader[codec.SETTINGS_FRAMES] != state.settings_seen:
        state.zero, state.sign = 0.0, 1.0
        state.handover = link.SENDING_LAW
        return encode_zero(conn, k, frame)
    if now - state.requested_at < link.REPEAT_AFTER:
        return encode_zero(conn, k, frame)
    state.requested_at = now
    return law_frames.encode_body(frame, conn.settings)


@internal
def send_law(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray, code_id: int) -> int:
    """Announce the law until the board acknowledges it, then send its code; record a refusal."""
    state, sample = conn.state, conn.samples[k]
    if state.law_due or state.code_id != code_id:
        take_law(r, conn, k, code_id)
    heard = sample[codec.KIND] == codec.SAMPLE and int(sample[codec.GENERATION]) == state.law_generation
    if not heard:
        if now - state.requested_at < link.REPEAT_AFTER:
            return send_now_and_then(conn, k, frame, law_frames.ALIVE)
        state.requested_at = state.moved_at = now
        return encode_law(conn, frame)
    if sample[codec.REFUSAL] != 0.0:
        state.refused, state.refusal = code_id, int(sample[codec.REFUSAL])
        return_to_computer(conn)
        return send_leave(conn, k, now, frame)
    return send_pieces(conn, k, now, frame)


@internal
def take_law(r: LoopArrays, conn: Link, k: int, code_id: int) -> None:
    """Copy the current law for sending, and give it a new generation number."""
    state = conn.state
    state.law_generation = next_generation(conn, k)
    state.code_id, state.program_id = code_id, r.settings.program_id
    for i in range(block.PROGRAM_WORDS):
        conn.program[i] = r.program[i]
    for i in range(conn.law.size):
        conn.law[i] = r.settings.board_form[i]
    conn.unsure[:] = 0
    state.law_due = state.received = state.sent = state.tuning = 0
    state.first, state.second = r.settings.board_first, r.settings.board_second
    state.requested_at = -link.REPEAT_AFTER


@internal
def next_generation(conn: Link, k: int) -> int:
    """Return a generation number from 1 to 255 that neither the last law nor the board's law has."""
    state, accepted = conn.state, int(conn.samples[k, codec.GENERATION])
    generation = state.generation
    for _ in range(3):
        generation = generation % _GENERATIONS + 1
        if generation != state.law_generation and generation != accepted:
            break
    state.generation = generation
    return generation


@internal
def encode_law(conn: Link, frame: np.ndarray) -> int:
    state, law = conn.state, conn.law
    return law_frames.encode_law(
        frame,
        conn.state.law_generation,
        law[link.PERIOD],
        law[link.ESTIMATOR],
        state.first,
        state.second,
        law[link.STATES],
        law[link.CONSTANTS],
        law[link.SLOTS],
        law[link.CODE],
        law[link.CHECK],
    )


@internal
def send_pieces(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Send the next bytes of the law; after a time-out, continue at the first missing byte."""
    state = conn.state
    whole = 4 * conn.law[link.CONSTANTS] + conn.law[link.CODE]
    received = min(int(conn.samples[k, codec.RECEIVED]), whole)
    if received != state.received:
        grown = received > state.received
        state.sent = max(state.sent, received) if grown else received
        state.received, state.moved_at = received, now
    elif received == whole:
        state.law_due = now - state.moved_at > STUCK
    elif now - state.moved_at > REPEAT + state.round_trip:
        state.sent, state.moved_at = received, now
    length = 0
    for _ in range(min(k + 1, AT_ONCE)):
        sent = state.sent
        if sent < min(whole, received + WINDOW):
            generation = state.law_generation
            length += law_frames.encode_piece(frame[length:], generation, sent, conn.program)
            state.sent = min(sent + PIECE, whole)
    return length if length else send_now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def return_to_computer(conn: Link) -> None:
    """Start the handover from the board to the computer."""
    conn.state.handover = link.RETURNING
    conn.state.requested_at = -link.REPEAT_AFTER


@internal
def send_leave(conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Encode the message Leave, and repeat it until the board sends no more telemetry."""
    state = conn.state
    if now - state.requested_at < link.REPEAT_AFTER:
        return send_now_and_then(conn, k, frame, law_frames.ALIVE)
    state.requested_at = now
    return codec.encode_simple(frame, law_frames.LEAVE)


@internal
def update(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray, code_id: int) -> int:
    """Send a new law or changed constants; without changes, send a keep-alive message."""
    state = conn.state
    if r.tick.stale:
        return send_now_and_then(conn, k, frame, law_frames.HELLO_REQUEST)
    if state.tuning != 0:
        if int(conn.samples[k, codec.GENERATION]) == state.tuning:
            state.tuning = 0
            conn.unsure[:] = 0
        elif now - state.tuned_at > TUNE_AGAIN + state.round_trip:
            state.tuning = state.program_id = 0
    changed = 0
    if state.tuning == 0 and state.program_id != r.settings.program_id:
        for i in range(conn.law[link.STATES], conn.law[link.CONSTANTS]):
            changed += constant_differs(r, conn, i)
    if state.law_due or state.code_id != code_id or changed > r.settings.board_moving:
        state.handover, state.law_due = link.SENDING_LAW, 1
        return send_law(r, conn, k, now, frame, code_id)
    if changed > 0:
        return send_constants(r, conn, k, now, frame)
    if state.tuning == 0:
        state.program_id = r.settings.program_id
    return send_now_and_then(conn, k, frame, law_frames.ALIVE)


@internal
def constant_differs(r: LoopArrays, conn: Link, i: int) -> bool:
    """Return True if the board's i-th constant may differ from the requested one."""
    return conn.unsure[i] or law_frames.constant_of(conn.program, i) != law_frames.constant_of(r.program, i)


@internal
def send_constants(r: LoopArrays, conn: Link, k: int, now: float, frame: np.ndarray) -> int:
    """Send the first changed constants, and mark them as unsure until the board acknowledges them."""
    state = conn.state
    state.tuning, state.tuned_at = next_generation(conn, k), now
    law_frames.begin_tune(frame, state.law_generation, state.tuning)
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
    """Encode a message without fields every few milliseconds of the board's clock."""
    time = conn.samples[k, codec.BOARD_TIME]
    if 0.0 <= time - conn.state.alive_at < ALIVE_APART - _HALF_FRAME:
        return 0
    conn.state.alive_at = time
    return codec.encode_simple(frame, word)

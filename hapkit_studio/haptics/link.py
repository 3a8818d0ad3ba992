"""One serial connection of a loop: it makes rows and answers from received frames, for both serial drivers.

A board sends telemetry while it renders, and samples while the computer renders. The first frame of the other
kind therefore shows that the handover is complete. The handover happens at zero force. In a handover to the
board, the computer's force fades out. Then the computer sends zero and direction as set by the user, and then
the law. Finally the board fades its force in.
"""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.devices.delays import FAR_BEHIND, Delays, new_delays, note_force_age
from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import arrays, block, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.haptics.record import Record, record, zeros
from hapkit_studio.haptics.rows import Ring
from hapkit_studio.haptics.tick import STALE_AFTER, latch, live_tick, mark_stale
from hapkit_studio.protocol import codec, law_frames

# state of a connection, in SI units
STATE = record(
    ("quantum", "f8"),  # travel per sensor count, m
    ("sign", "f8"),  # 1.0, or -1.0 for a reversed direction
    ("zero", "f8"),  # sensor count at 0 m
    ("effect", "f8"),
    # weight of the computer's force during the handover to the board; it falls from 1 to 0
    ("fade_left", "f8"),
    ("last_arrival", "f8"),  # arrival of the last frame, by the clocks of computer and board
    ("last_board_time", "f8"),
    ("quiet", "f8"),  # time since the last received byte
    ("read_at", "f8"),  # time at which the line was last read
    ("last_answer", "f8"),
    ("requested_at", "f8"),  # time of the last request
    ("moved_at", "f8"),  # time at which the board's counter of received bytes changed last
    ("tuned_at", "f8"),  # time at which constants were last sent
    ("alive_at", "f8"),  # time of the last keep-alive message
    ("faded_at", "f8"),  # time at which the board's fade ends
    ("excused", "f8"),  # faults that the board reports before this time are old and are ignored
    ("first", "f8"),  # coefficients of the board's velocity estimator
    ("second", "f8"),
    ("seen_speed", "f8"),  # speed from consecutive positions in telemetry
    ("round_trip", "f8"),  # last measured time from a sample to its force, without added delay
    ("too_long_since", "f8"),
    ("watchdog", "f8"),  # time without a force after which the board switches its motor off
    ("motor_off_time", "f8"),  # time for which the motor has been off although the board was answered
    ("clock_shift", "f8"),  # correction of the board's clock for its jumps
    ("clock_last", "f8"),  # last corrected board time, and its arrival by the computer's clock
    ("clock_at", "f8"),
    ("clock_ahead", "f8"),  # smallest recent difference of computer time and board time
    ("started", "i8"),
    ("sent_stop", "i8"),
    ("zeroed", "i8"),  # number of the last processed request to set the zero
    ("flipped", "i8"),  # number of the last processed request to reverse the direction
    ("handover", "i8"),  # state of the handover, one of the six below
    # whether the board's settings are known, whether they can be changed, and whether a zero was stored
    ("settings_seen", "i8"),
    ("configurable", "i8"),
    ("calibrated", "i8"),
    ("generation", "i8"),  # the last generation sent, for a law or for a change of its constants
    ("law_generation", "i8"),  # generation of the law; 0 before the first law
    ("tuning", "i8"),  # generation of the change of constants in progress, or 0
    ("code_id", "i8"),  # code_id of the law last sent
    ("program_id", "i8"),  # program_id of this law; 0 if the constants on the board may differ
    ("law_due", "i8"),  # nonzero if the law must be sent again
    ("received", "i8"),  # number of the law's bytes that the board has received, and number of bytes sent
    ("sent", "i8"),
    ("refused", "i8"),  # code_id of the law that the board refused, or 0; and the reason
    ("refusal", "i8"),
    ("overruns", "i8"),  # the board's counters: missed ticks, forces that were too old, unreadable frames
    ("stale_reported", "i8"),
    ("errors_reported", "i8"),
    ("skipped", "i8"),  # number of ticks that the board has skipped since it was opened
    ("motor_seen_on", "i8"),  # nonzero after a force of the computer has switched the motor on
    ("left_out", "i8"),  # nonzero if samples that came after the last row were not written to rows
    ("last_was_sample", "i8"),  # nonzero if the last frame was a sample, which the computer's tick renders
    ("answered", "i8"),  # number of the sample to which the last force belongs
    ("too_long", "i8"),  # number of consecutive answers that took longer than the board's watchdog time
)

ON_COMPUTER, FADING_OUT, SENDING_SETTINGS, SENDING_LAW, ON_BOARD, RETURNING = range(6)
"""States of the handover: the computer renders; its force fades out; the board receives zero and direction.

Then: the board receives its law; the board renders; the board was told to stop rendering.
"""

CHUNK, HISTORY = 4096, 2048
# largest number of periods of added delay: the message of a force has one byte for the age of its sample
MOST_ADDED = 255
# s: time without a frame after which the board counts as disconnected. It has restarted and no longer
# streams, or it hangs.
GONE_AFTER = 1.0
MOTOR_ON_WITHIN = 0.3  # s: time after which a board that receives answers has certainly switched its motor on
# The computer is too slow to render after this number of consecutive late answers, if they span this time in
# s.
_SLOW_ANSWERS, SLOW_AFTER = 4, 0.15
REPEAT_AFTER = 0.1  # s: time after which a message that had no effect is repeated
# s: the board's clock may run ahead of the computer's clock by this time between two frames
CLOCK_SLACK = 0.1
# fraction by which the board's clock may be slower permanently, like that of a virtual board on a busy
# computer
_CLOCK_SLOW = 0.1
_ROUNDING = 1e-9

_MOTOR_OFF = codec.FLAG_WATCHDOG | codec.FLAG_STOPPED | codec.FLAG_REFUSED

# --- the header of the board's law, in the order of the block's board_form
PERIOD, ESTIMATOR, STATES, CONSTANTS, SLOTS, CODE, CHECK = range(7)


class Link(NamedTuple):
    reader: np.ndarray
    buffer: np.ndarray
    data: np.ndarray
    frame: np.ndarray
    samples: np.ndarray
    forces: np.ndarray  # answers to the last samples, with the sign that the board uses
    state: Record  # a STATE record
    delays: Delays
    law: np.ndarray  # (7,): header of the law that was sent last to the board
    program: np.ndarray  # packed bytes of this law, with the constants that were sent last
    unsure: np.ndarray  # 1 for each constant whose current value on the board is unknown
    settings: np.ndarray  # body of the board's Board message, uint8
    motor: np.ndarray  # force in N at each duty from 0 to full duty
    poll: np.ndarray


def new_link(quantum: float, watchdog: float = 0.025) -> Link:
    """Return a new connection for a sensor with a travel of ``quantum`` in m per count.

    ``watchdog`` is the time in s without a force after which the board switches off.
    """
    reader, buffer = codec.new_reader()
    state = zeros(STATE)
    state.quantum, state.sign, state.watchdog = quantum, 1.0, watchdog
    state.last_arrival = math.inf  # infinite, so that the first frame does not count as late
    return Link(
        reader=reader,
        buffer=buffer,
        data=np.zeros(CHUNK, dtype=np.uint8),
        frame=np.zeros(law_frames.ROOM, dtype=np.uint8),
        samples=np.zeros((codec.rows_for(CHUNK), codec.SAMPLE_WIDTH)),
        forces=np.zeros(HISTORY),
        state=state,
        delays=new_delays(),
        law=np.zeros(CHECK + 1, dtype=np.int64),
        program=np.zeros(block.PROGRAM_WORDS, dtype=np.int64),
        unsure=np.zeros(2 * block.PROGRAM_WORDS, dtype=np.int64),
        settings=np.zeros(law_frames.BOARD_BODY, dtype=np.uint8),
        motor=np.zeros(256),
        poll=np.zeros(1, dtype=np.int64),
    )


@internal
def wanted_code(r: LoopArrays, link: Link) -> int:
    """Return the CODE_ID of the law that the board shall render now; 0 if the computer renders.

    The computer renders until it has applied a new zero or direction set by the user. It also renders laws
    that the board refused.
    """
    zeroed, flipped = load_acquire(r.control.zero, 0), load_acquire(r.control.flip, 0)
    if zeroed != link.state.zeroed or flipped != link.state.flipped:
        return 0
    code_id = r.settings.code_id
    return 0 if code_id == link.state.refused else code_id


@internal
def fade_out(r: LoopArrays, link: Link, period: float) -> float:
    """Return the factor of the force in an answer; it falls from 1 to 0 during a handover to the board."""
    state = link.state
    blocked = r.tick.zero_force_left > 0.0 or r.tick.stale or load_acquire(r.control.fault, 0)
    if state.handover == ON_COMPUTER:
        if blocked or wanted_code(r, link) == 0:
            return 1.0
        state.handover = FADING_OUT
        state.fade_left = 1.0
    if state.handover != FADING_OUT:
        return 0.0
    if blocked or wanted_code(r, link) == 0:
        state.handover = ON_COMPUTER
        r.tick.gain *= state.fade_left
        return state.fade_left
    left = state.fade_left - period / r.settings.fade
    state.fade_left = left if left > _ROUNDING else 0.0
    return state.fade_left


@internal
def computer_answers(link: Link) -> bool:
    """Return True if the computer answers samples with forces."""
    renderer = link.state.handover
    return renderer == ON_COMPUTER or (renderer == FADING_OUT and link.state.fade_left > 0.0)


@internal
def position_of(link: Link, count: float) -> float:
    """Return the handle's position in m at a sensor count."""
    state = link.state
    return state.sign * (count - state.zero) * state.quantum


@internal
def resume(r: LoopArrays, link: Link, count: float, velocity: float) -> None:
    """Continue the tick from a different position and velocity; the force fades in."""
    position = position_of(link, count)
    estimators.resume(r.memory, position, velocity)
    r.tick.last_position = position
    r.tick.gain = 0.0


@internal
def apply_zero_and_direction(r: LoopArrays, link: Link, count: float) -> None:
    """Set zero and direction if the window requests it; without a stored zero, use the first sample."""
    state = link.state
    zeroed = load_acquire(r.control.zero, 0)
    flipped = load_acquire(r.control.flip, 0)
    if state.started and zeroed == state.zeroed and flipped == state.flipped:
        return
    if zeroed != state.zeroed if state.started else not state.calibrated:
        state.zero = count
    if flipped != state.flipped and state.started:
        state.sign = -state.sign
    state.started = 1
    state.zeroed, state.flipped = zeroed, flipped
    resume(r, link, count, 0.0)


@internal
def effect(link: Link, sample: np.ndarray, period: float) -> float:
    """Return the mean force in N over the last period, in which an arriving answer changed the force."""
    old = link.state.effect
    new = link.forces[int(sample[codec.ANSWERED]) % HISTORY]
    if int(sample[codec.FLAGS]) & _MOTOR_OFF:
        new = 0.0
    link.state.effect = new
    behind = (int(sample[codec.SEQ]) - 1 - int(sample[codec.ANSWERED])) & 0xFFFF
    share = min(max(sample[codec.DELAY] / period - behind, 0.0), 1.0)
    return new + (old - new) * share


@internal
def note_link(r: LoopArrays, link: Link, sample: np.ndarray, now: float) -> None:
    """Measure the round trip of samples and forces; latch a fault if no force can arrive in time.

    Delays are measured from consecutive samples while the motor is on. The board ignores a nonzero force
    whose newest sample is older than the board's watchdog time.
    """
    state, delay = link.state, sample[codec.DELAY]
    seq, answered, period = int(sample[codec.SEQ]), int(sample[codec.ANSWERED]), r.settings.period
    on = int(sample[codec.FLAGS]) & _MOTOR_OFF == 0 and sample[codec.LOST] == 0.0
    note_force_age(link.delays, seq, answered, delay, period, on)
    new, state.answered = answered != state.answered, answered
    if not new or delay <= 0.0 or (seq - 1 - answered) & 0xFFFF >= FAR_BEHIND:
        return
    trip = delay - added_periods(r) * period
    state.round_trip = max(trip, 0.0)
    if trip <= state.watchdog:
        state.too_long = 0
        return
    if state.too_long == 0:
        state.too_long_since = now
    state.too_long += 1
    late = state.too_long >= _SLOW_ANSWERS and now - state.too_long_since >= SLOW_AFTER
    if late and wanted_code(r, link) == 0:
        latch(r, arrays.SLOW_LINK, trip, state.watchdog)


@internal
def added_periods(r: LoopArrays) -> int:
    return min(int(r.settings.delay / r.settings.period + 0.5), MOST_ADDED)


@compiled
def note_gap(r: LoopArrays, link: Link, now: float) -> bool:
    """Return True if no frame was answered for STALE_AFTER.

    In this case mark the sensor stale, unless no sample has been rendered yet.

    The board's motor is off after this time. A wait never takes much longer than STALE_AFTER.
    """
    state = link.state
    if now - state.last_answer < STALE_AFTER:
        return False
    # the last answer belongs to this iteration of the loop, so the iteration itself was too slow
    if state.last_answer > state.read_at:
        slow = load_acquire(r.control.fault, 0) == arrays.SLOW_LAW
        cause = arrays.LAW_BLOCKED if slow else arrays.AWAY
    else:
        cause = arrays.AWAY if now - state.read_at > 1.5 * STALE_AFTER else arrays.NO_SAMPLE
    if link.state.started:
        mark_stale(r, now, cause)
    return True


@compiled
def board_gone(r: LoopArrays, link: Link, now: float) -> bool:
    """Return True if a board that has sent frames is silent for GONE_AFTER, and latch this as a fault.

    An iteration may take longer than its wait, for example because the computer was suspended. It then counts
    as at most twice the wait.
    """
    state = link.state
    if not math.isfinite(state.last_arrival):
        return False
    state.quiet += min(now - state.read_at, 2.0 * STALE_AFTER)
    state.read_at = now
    if state.quiet < GONE_AFTER:
        return False
    latch(r, arrays.DEVICE_GONE, GONE_AFTER, r.tick.last_position)
    return True


@internal
def watch_motor(r: LoopArrays, link: Link, flags: int, now: float) -> None:
    """Treat the sensor as stale if the board switched its motor off although the computer had answered.

    The motor may be off for up to MOTOR_ON_WITHIN: before the first answer arrives, and after the release of
    an E-stop.
    """
    state = link.state
    if flags & codec.FLAG_STOPPED or state.handover != ON_COMPUTER:
        state.motor_seen_on = 0
        state.motor_off_time = 0.0
    elif not flags & codec.FLAG_WATCHDOG:
        state.motor_seen_on = 1
        state.motor_off_time = 0.0
    else:
        state.motor_off_time += r.settings.period
        if state.motor_seen_on or r.tick.stale or state.motor_off_time > MOTOR_ON_WITHIN:
            state.motor_seen_on = 0
            mark_stale(r, now, arrays.CUT)


@compiled
def check_clock(r: LoopArrays, link: Link, sample: np.ndarray, now: float) -> None:
    """Correct a sample's board time after the board's clock jumped back, stopped or jumped ahead.

    The clock jumped ahead if it advanced by more than the total period of the samples that the board sent,
    and also by more than the computer's clock. The corrected time advances by the periods of the samples. The
    force is zero as after a gap, because the board may have restarted.
    """
    state = link.state
    time, elapsed = sample[codec.BOARD_TIME] + state.clock_shift, now - state.clock_at
    passed, sent = time - state.clock_last, r.settings.period * (1.0 + sample[codec.LOST])
    gained = now - time < state.clock_ahead - CLOCK_SLACK
    if state.clock_at == 0.0:
        state.clock_ahead = now - time
    elif passed <= 0.0 or (passed > 1.5 * sent and gained):
        wrong, time = time, state.clock_last + sent
        state.clock_shift += time - wrong
        link.state.left_out = 1
        if r.tick.stale:
            r.tick.good = 0.0
            causes = r.control.stale_causes
            store_release(causes, arrays.CLOCK_JUMP, causes[arrays.CLOCK_JUMP] + 1)
        else:
            mark_stale(r, now, arrays.CLOCK_JUMP)
    state.clock_ahead = min(now - time, state.clock_ahead + _CLOCK_SLOW * elapsed)
    state.clock_last, state.clock_at = time, now
    sample[codec.BOARD_TIME] = time


@internal
def time_since_last(link: Link, sample: np.ndarray) -> float:
    """Return the time in s since the last row by the board's clock; 0 if it is unknown."""
    before = link.state.last_board_time
    passed = sample[codec.BOARD_TIME] - before
    return passed if before > 0.0 and 0.0 < passed < 1.0 else 0.0


@compiled
def write_times(link: Link, board_time: float, row: np.ndarray, now: float) -> None:
    """Fill in the row's times, and NaN for simulated quantities.

    The lateness of a frame is its delay beyond one board period after the previous frame. Only the previous
    frame is used, because the two clocks drift, and a virtual board does not make up for a delay.
    """
    state = link.state
    row[rows.LATENESS] = max(0.0, (now - state.last_arrival) - (board_time - state.last_board_time))
    state.last_arrival, state.last_board_time = now, board_time
    row[rows.HOST_TIME], row[rows.BOARD_TIME] = now, board_time
    row[rows.TRUE_POSITION] = row[rows.TRUE_VELOCITY] = math.nan
    row[rows.HAND_FORCE] = row[rows.HAND_TARGET] = math.nan


@internal
def render(r: LoopArrays, link: Link, out: Ring, k: int, now: float) -> None:
    """Render the k-th decoded sample into the ring's next row; store the answer.

    The row is flagged as a gap if more than one period has passed by the board's clock. The force of this
    answer also counts as the answer to lost samples.
    """
    sample = link.samples[k]
    lost, period = sample[codec.LOST], r.settings.period * (1.0 + sample[codec.LOST])
    apply_zero_and_direction(r, link, sample[codec.COUNT])
    board_flags = int(sample[codec.FLAGS])
    watch_motor(r, link, board_flags, now)
    if link.state.handover == ON_COMPUTER:
        note_link(r, link, sample, now)
    in_effect = link.state.sign * effect(link, sample, period)
    row = out.rows[rows.next_index(out)]
    force = live_tick(r, position_of(link, sample[codec.COUNT]), period, in_effect, row)
    share, flags = fade_out(r, link, period), int(row[rows.FLAGS])
    if share < 1.0:
        force *= share
        row[rows.APPLIED_FORCE] = r.tick.applied = force
        flags |= rows.FADING
    gap = lost > 0.0 or link.state.left_out or time_since_last(link, sample) > 1.5 * period
    write_times(link, sample[codec.BOARD_TIME], row, now)
    if gap or board_flags & codec.FLAG_SENSOR:
        flags |= rows.GAP
        link.state.left_out = 0
    if board_flags & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    row[rows.FLAGS] = flags
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT | rows.STALE):
        link.forces[:] = 0.0
    for back in range(min(int(lost), HISTORY - 1) + 1):
        link.forces[(int(sample[codec.SEQ]) - back) % HISTORY] = link.state.sign * force

"""One serial connection inside a loop: frames in, rows and answers out. Both serial drivers use it.

A board renders from its law's first telemetry on, the computer from the first sample on. One hands over to
the other at zero force: on the way to the board the computer's force fades out, the board learns zero and
direction as the person set them, then the law; it fades its force in by itself.
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

# What a connection knows, in SI units.
STATE = record(
    ("quantum", "f8"),  # m, a count of the sensor
    ("sign", "f8"),  # 1.0, or -1.0 where the direction is flipped
    ("zero", "f8"),  # the count at 0 m
    ("effect", "f8"),  # the force in effect
    ("fade_left", "f8"),  # share of the computer's force on the way to the board
    ("last_arrival", "f8"),  # when the last frame came, by our clock and by the board's
    ("last_board_time", "f8"),
    ("quiet", "f8"),  # how long the line has been quiet
    ("looked_at", "f8"),  # when the line was read last
    ("last_answer", "f8"),
    ("asked_at", "f8"),  # when something was asked for
    ("moved_at", "f8"),  # when the board's count of received bytes changed
    ("tuned_at", "f8"),  # when constants were sent
    ("alive_at", "f8"),  # when a keep-alive was sent
    ("faded_at", "f8"),  # when the board's fade is over
    ("excused", "f8"),  # until when faults that the board latched are old ones
    ("first", "f8"),  # coefficients of the law's estimator
    ("second", "f8"),
    ("seen_speed", "f8"),  # from one position that the board tells to the next
    ("round_trip", "f8"),  # from a sample to its force, as measured last, without added delay
    ("too_long_since", "f8"),
    ("watchdog", "f8"),  # the board refuses forces after it
    ("motor_off_time", "f8"),  # for which the board has kept its motor off although it was answered
    ("clock_shift", "f8"),  # correction of the board's clock for its jumps
    ("clock_last", "f8"),  # the last corrected time, and when it came by our clock
    ("clock_at", "f8"),
    ("clock_ahead", "f8"),  # the least that our clock was ahead of it lately
    ("started", "i8"),
    ("sent_stop", "i8"),
    ("zeroed", "i8"),  # counts of zero and direction set, as obeyed last
    ("flipped", "i8"),
    ("handover", "i8"),  # who renders, one of the six below
    ("settings_seen", "i8"),  # the board's settings are known; they can be changed; its zero was stored
    ("configurable", "i8"),
    ("calibrated", "i8"),
    ("generation", "i8"),  # sent last, of a law or of a change of its constants
    ("law_generation", "i8"),  # the law's, 0 before the first
    ("tuning", "i8"),  # of the change under way, 0: none
    ("code_id", "i8"),  # the law sent last, as the block has it
    ("program_id", "i8"),  # the same with its constants, 0 where the board may have others
    ("law_due", "i8"),  # the law is to be sent again
    ("received", "i8"),  # bytes of the law that the board has, and that were sent
    ("sent", "i8"),
    ("refused", "i8"),  # the code_id that the board has refused, 0: none, and why
    ("refusal", "i8"),
    ("overruns", "i8"),  # as the board counts them: ticks missed, forces too old, unreadable frames
    ("stale_told", "i8"),
    ("errors_told", "i8"),
    ("skipped", "i8"),  # ticks that the board skipped since it was opened
    ("motor_seen_on", "i8"),  # the computer's forces have reached the board
    ("left_out", "i8"),  # samples were left out of the record since the last row
    ("last_was_sample", "i8"),  # the last frame was one of the computer's ticks
    ("answered", "i8"),  # the sample that the last force answered
    ("too_long", "i8"),  # answers in a row that took longer than the board's watchdog waits
)

ON_COMPUTER, FADING_OUT, SENDING_SETTINGS, SENDING_LAW, ON_BOARD, RETURNING = range(6)
"""The handover: the computer renders; its force fades out; the board takes over zero and direction; it is
sent its law; it renders; it was told to stop rendering."""

CHUNK, HISTORY = 4096, 2048
MOST_ADDED = 255  # periods of added delay: what a force can say of the sample that it answers
# s without a frame after which a board counts as gone: it began anew, and no longer streams, or hangs
GONE_AFTER = 1.0
MOTOR_ON_WITHIN = 0.3  # s after which a board that is answered has its motor on
# so many answers in a row, over so many s, each too late: the computer cannot render
_SLOW_ANSWERS, SLOW_AFTER = 4, 0.15
REPEAT_AFTER = 0.1  # s after which what has no effect is sent once more
CLOCK_SLACK = 0.1  # s by which the board's clock may gain on ours between two frames
_CLOCK_SLOW = 0.1  # and fall behind for good, as a share: a virtual board that is held up does
_ROUNDING = 1e-9

_MOTOR_OFF = codec.FLAG_WATCHDOG | codec.FLAG_STOPPED | codec.FLAG_REFUSED

# --- what the law is like that the board gets, in the order of the block's board_form
PERIOD, ESTIMATOR, STATES, CONSTANTS, SLOTS, CODE, CHECK = range(7)


class Link(NamedTuple):
    """The connection's arrays, allocated once."""

    reader: np.ndarray
    buffer: np.ndarray
    data: np.ndarray
    frame: np.ndarray
    samples: np.ndarray
    forces: np.ndarray  # the answer to each of the last samples, as the board counts direction
    state: Record  # of STATE
    delays: Delays
    law: np.ndarray  # what the law is like that the board got last, (7,)
    program: np.ndarray  # its bytes, packed, the constants as they were sent last
    unsure: np.ndarray  # 1 for each number at their beginning that the board may not have
    settings: np.ndarray  # the body of Board that it has, uint8
    motor: np.ndarray  # force in N at each duty from 0 to its top
    poll: np.ndarray  # one pollfd structure


def new_link(quantum: float, watchdog: float = 0.025) -> Link:
    """Return a connection that has received nothing, for a sensor of quantum m a count.

    watchdog: s after which the board obeys no force.
    """
    reader, buffer = codec.new_reader()
    state = zeros(STATE)
    state.quantum, state.sign, state.watchdog = quantum, 1.0, watchdog
    state.last_arrival = math.inf  # the first frame is not late
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
    """Return the CODE_ID of the law that the board is to render now, 0 where the computer renders.

    Zero and direction that a person sets are taken over by the computer; what the board refused stays here.
    """
    zeroed, flipped = load_acquire(r.control.zero, 0), load_acquire(r.control.flip, 0)
    if zeroed != link.state.zeroed or flipped != link.state.flipped:
        return 0
    code_id = r.settings.code_id
    return 0 if code_id == link.state.refused else code_id


@internal
def fade_out(r: LoopArrays, link: Link, period: float) -> float:
    """Return the share of the force that a sample's answer may have: it fades out on the way to the board."""
    state = link.state
    held = r.tick.hold > 0.0 or r.tick.stale or load_acquire(r.control.fault, 0)
    if state.handover == ON_COMPUTER:
        if held or wanted_code(r, link) == 0:
            return 1.0
        state.handover = FADING_OUT
        state.fade_left = 1.0
    if state.handover != FADING_OUT:
        return 0.0
    if held or wanted_code(r, link) == 0:
        state.handover = ON_COMPUTER
        r.tick.gain *= state.fade_left
        return state.fade_left
    left = state.fade_left - period / r.settings.fade
    state.fade_left = left if left > _ROUNDING else 0.0
    return state.fade_left


@internal
def computer_answers(link: Link) -> bool:
    """Return whether samples are answered by forces."""
    renderer = link.state.handover
    return renderer == ON_COMPUTER or (renderer == FADING_OUT and link.state.fade_left > 0.0)


@internal
def position_of(link: Link, count: float) -> float:
    """Return the handle's position in m for a sensor count."""
    state = link.state
    return state.sign * (count - state.zero) * state.quantum


@internal
def resume(r: LoopArrays, link: Link, count: float, velocity: float) -> None:
    """Let the tick go on from another motion, or another meaning of position; the force fades in."""
    position = position_of(link, count)
    estimators.resume(r.memory, position, velocity)
    r.tick.last_position = position
    r.tick.gain = 0.0


@internal
def apply_zero_and_direction(r: LoopArrays, link: Link, count: float) -> None:
    """Set zero and direction when the window asked for it; on a board without a zero the first sample."""
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
    """Return the mean force in N over the last period: the old one until the answer came, then that."""
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
    """Measure how long samples and forces are on their way; where no force can be in time, latch that.

    Delays are measured from samples that follow one another while the motor is on. The board obeys no force
    whose newest sample is older than its watchdog's time, but for zero.
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
    """Return the added delay in whole periods."""
    return min(int(r.settings.delay / r.settings.period + 0.5), MOST_ADDED)


@compiled
def note_gap(r: LoopArrays, link: Link, now: float) -> bool:
    """Return whether nothing was answered for STALE_AFTER; once there was a sample the sensor then is stale.

    The board has its motor off then. A wait never takes much longer than STALE_AFTER.
    """
    state = link.state
    if now - state.last_answer < STALE_AFTER:
        return False
    if state.last_answer > state.looked_at:  # in this very pass: it took so long itself
        slow = load_acquire(r.control.fault, 0) == arrays.SLOW_LAW
        cause = arrays.HELD_UP if slow else arrays.AWAY
    else:
        cause = arrays.AWAY if now - state.looked_at > 1.5 * STALE_AFTER else arrays.NO_SAMPLE
    if link.state.started:
        mark_stale(r, now, cause)
    return True


@compiled
def board_gone(r: LoopArrays, link: Link, now: float) -> bool:
    """Return whether a board that has been heard is silent for GONE_AFTER; latch that it is gone.

    A pass that took longer than its wait counts no more than twice that: then the computer was away.
    """
    state = link.state
    if not math.isfinite(state.last_arrival):
        return False
    state.quiet += min(now - state.looked_at, 2.0 * STALE_AFTER)
    state.looked_at = now
    if state.quiet < GONE_AFTER:
        return False
    latch(r, arrays.DEVICE_GONE, GONE_AFTER, r.tick.last_position)
    return True


@internal
def watch_motor(r: LoopArrays, link: Link, said: int, now: float) -> None:
    """Where the board cut its motor off although it was answered, come back as from a stale sensor.

    Not where that is as it should be: until the first answer is heard, after stop and release; but that does
    not take for ever.
    """
    state = link.state
    if said & codec.FLAG_STOPPED or state.handover != ON_COMPUTER:
        state.motor_seen_on = 0
        state.motor_off_time = 0.0
    elif not said & codec.FLAG_WATCHDOG:
        state.motor_seen_on = 1
        state.motor_off_time = 0.0
    else:
        state.motor_off_time += r.settings.period
        if state.motor_seen_on or r.tick.stale or state.motor_off_time > MOTOR_ON_WITHIN:
            state.motor_seen_on = 0
            mark_stale(r, now, arrays.CUT)


@compiled
def check_clock(r: LoopArrays, link: Link, sample: np.ndarray, now: float) -> None:
    """Correct a sample's board time where the board's clock went back, stood still or jumped ahead.

    It jumped where it went on by more than the samples that were sent, and by more than our clock. Time goes
    on by their periods then, and the force is zero as after a gap: such a board may have started anew.
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
    """Return the time in s since the last row by the board's clock, 0 where that means nothing."""
    before = link.state.last_board_time
    passed = sample[codec.BOARD_TIME] - before
    return passed if before > 0.0 and 0.0 < passed < 1.0 else 0.0


@compiled
def write_times(link: Link, board_time: float, row: np.ndarray, now: float) -> None:
    """Fill the row's times, and nan where only a simulation knows.

    It is late by what came later than one period after the last frame by the board's clock. Against the last
    frame alone: the two clocks drift, and a virtual board that was held up stays behind.
    """
    state = link.state
    row[rows.LATENESS] = max(0.0, (now - state.last_arrival) - (board_time - state.last_board_time))
    state.last_arrival, state.last_board_time = now, board_time
    row[rows.HOST_TIME], row[rows.BOARD_TIME] = now, board_time
    row[rows.TRUE_POSITION] = row[rows.TRUE_VELOCITY] = math.nan
    row[rows.HAND_FORCE] = row[rows.HAND_TARGET] = math.nan


@internal
def render(r: LoopArrays, link: Link, out: Ring, k: int, now: float) -> None:
    """Render the k-th decoded sample into the ring's next row; keep its answer.

    There is a gap where more than a period has passed by the board's clock. Lost samples count as answered by
    the same force.
    """
    sample = link.samples[k]
    lost, period = sample[codec.LOST], r.settings.period * (1.0 + sample[codec.LOST])
    apply_zero_and_direction(r, link, sample[codec.COUNT])
    said = int(sample[codec.FLAGS])
    watch_motor(r, link, said, now)
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
    if gap or said & codec.FLAG_SENSOR:
        flags |= rows.GAP
        link.state.left_out = 0
    if said & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    row[rows.FLAGS] = flags
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT | rows.STALE):
        link.forces[:] = 0.0
    for back in range(min(int(lost), HISTORY - 1) + 1):
        link.forces[(int(sample[codec.SEQ]) - back) % HISTORY] = link.state.sign * force

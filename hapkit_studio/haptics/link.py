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
from hapkit_studio.haptics.rows import Ring
from hapkit_studio.haptics.tick import STALE_AFTER, latch, live_tick, mark_stale
from hapkit_studio.protocol import codec, law_frames

# --- Link.numbers, in SI units
QUANTUM, SIGN, ZERO = range(3)
EFFECT, FADE_LEFT = range(3, 5)  # the force in effect; the share of the computer's on the way to the board
# when the last frame came, by our clock and the board's; how long it is quiet; the last look, the last answer
LAST_ARRIVAL, LAST_BOARD_TIME, QUIET, LOOKED_AT, LAST_ANSWER = range(5, 10)
# when something was asked for, the board's count of bytes moved, constants and a sign of life were sent
ASKED_AT, MOVED_AT, TUNED_AT, ALIVE_AT = range(10, 14)
FADED_AT, EXCUSED = range(14, 16)  # when the board's fade is over; until when what it latched is old
FIRST, SECOND = range(16, 18)  # the coefficients of the law's estimator
SEEN_SPEED = 18  # from one position that the board tells to the next
# from a sample to its force, as measured last, without added delay; the board refuses forces after WATCHDOG
ROUND_TRIP, TOO_LONG_SINCE, WATCHDOG = range(19, 22)
MOTOR_OFF_TIME = 22  # in which the board has kept its motor off although it was answered
# the board's clock: what its jumps are corrected by, the last corrected time, when that came by our clock,
# how far ours was ahead at least, of late
CLOCK_SHIFT, CLOCK_LAST, CLOCK_AT, CLOCK_AHEAD = range(23, 27)
NUMBERS = 27

# --- Link.words
STARTED, SENT_STOP, ZEROED, FLIPPED = range(4)
HANDOVER = 4  # who renders, one of the six below
SETTINGS_SEEN, CONFIGURABLE, CALIBRATED = range(5, 8)  # known and can be changed; the zero was stored
# the generation sent last, of a law or of a change of its constants; the law's, 0 before the first; the
# change's under way, 0 none
GENERATION, LAW_GENERATION, TUNING = range(8, 11)
# the law sent last, as the block has it; the same with its constants, 0 where the board may have others
CODE_ID, PROGRAM_ID = range(11, 13)
LAW_DUE, RECEIVED, SENT = range(13, 16)  # to be sent anew; bytes of it that the board has, that have gone out
REFUSED, REFUSAL = range(16, 18)  # the CODE_ID that the board has refused, 0 none, and why
# as the board counts them: ticks missed, forces refused as too old, frames that it could not read
OVERRUNS, STALE_TOLD, ERRORS_TOLD = range(18, 21)
SKIPPED = 21  # ticks that the board skipped since it was opened
MOTOR_SEEN_ON = 22  # the computer's forces have reached the board
# samples were left out of the record since the last row; the last frame was one of the computer's tick
LEFT_OUT, LAST_WAS_SAMPLE = range(23, 25)
# the sample that its last force answered; answers in a row that took longer than its watchdog waits
ANSWERED, TOO_LONG = range(25, 27)
WORDS = 27

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
    numbers: np.ndarray
    words: np.ndarray
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
    numbers = np.zeros(NUMBERS)
    numbers[QUANTUM], numbers[SIGN], numbers[WATCHDOG] = quantum, 1.0, watchdog
    numbers[LAST_ARRIVAL] = math.inf  # the first frame is not late
    return Link(
        reader=reader,
        buffer=buffer,
        data=np.zeros(CHUNK, dtype=np.uint8),
        frame=np.zeros(law_frames.ROOM, dtype=np.uint8),
        samples=np.zeros((codec.rows_for(CHUNK), codec.SAMPLE_WIDTH)),
        forces=np.zeros(HISTORY),
        numbers=numbers,
        words=np.zeros(WORDS, dtype=np.int64),
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
    if zeroed != link.words[ZEROED] or flipped != link.words[FLIPPED]:
        return 0
    code_id = r.settings.code_id
    return 0 if code_id == link.words[REFUSED] else code_id


@internal
def fade_out(r: LoopArrays, link: Link, period: float) -> float:
    """Return the share of the force that a sample's answer may have: it fades out on the way to the board."""
    n, words = link.numbers, link.words
    held = r.tick.hold > 0.0 or r.tick.stale or load_acquire(r.control.fault, 0)
    if words[HANDOVER] == ON_COMPUTER:
        if held or wanted_code(r, link) == 0:
            return 1.0
        words[HANDOVER] = FADING_OUT
        n[FADE_LEFT] = 1.0
    if words[HANDOVER] != FADING_OUT:
        return 0.0
    if held or wanted_code(r, link) == 0:
        words[HANDOVER] = ON_COMPUTER
        r.tick.gain *= n[FADE_LEFT]
        return n[FADE_LEFT]
    left = n[FADE_LEFT] - period / r.settings.fade
    n[FADE_LEFT] = left if left > _ROUNDING else 0.0
    return n[FADE_LEFT]


@internal
def computer_answers(link: Link) -> bool:
    """Return whether samples are answered by forces."""
    renderer = link.words[HANDOVER]
    return renderer == ON_COMPUTER or (renderer == FADING_OUT and link.numbers[FADE_LEFT] > 0.0)


@internal
def position_of(link: Link, count: float) -> float:
    """Return the handle's position in m for a sensor count."""
    n = link.numbers
    return n[SIGN] * (count - n[ZERO]) * n[QUANTUM]


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
    n, words = link.numbers, link.words
    zeroed = load_acquire(r.control.zero, 0)
    flipped = load_acquire(r.control.flip, 0)
    if words[STARTED] and zeroed == words[ZEROED] and flipped == words[FLIPPED]:
        return
    if zeroed != words[ZEROED] if words[STARTED] else not words[CALIBRATED]:
        n[ZERO] = count
    if flipped != words[FLIPPED] and words[STARTED]:
        n[SIGN] = -n[SIGN]
    words[STARTED] = 1
    words[ZEROED], words[FLIPPED] = zeroed, flipped
    resume(r, link, count, 0.0)


@internal
def effect(link: Link, sample: np.ndarray, period: float) -> float:
    """Return the mean force in N over the last period: the old one until the answer came, then that."""
    old = link.numbers[EFFECT]
    new = link.forces[int(sample[codec.ANSWERED]) % HISTORY]
    if int(sample[codec.FLAGS]) & _MOTOR_OFF:
        new = 0.0
    link.numbers[EFFECT] = new
    behind = (int(sample[codec.SEQ]) - 1 - int(sample[codec.ANSWERED])) & 0xFFFF
    share = min(max(sample[codec.DELAY] / period - behind, 0.0), 1.0)
    return new + (old - new) * share


@internal
def note_link(r: LoopArrays, link: Link, sample: np.ndarray, now: float) -> None:
    """Measure how long samples and forces are on their way; where no force can be in time, latch that.

    Delays are measured from samples that follow one another while the motor is on. The board obeys no force
    whose newest sample is older than its watchdog's time, but for zero.
    """
    n, words, delay = link.numbers, link.words, sample[codec.DELAY]
    seq, answered, period = int(sample[codec.SEQ]), int(sample[codec.ANSWERED]), r.settings.period
    on = int(sample[codec.FLAGS]) & _MOTOR_OFF == 0 and sample[codec.LOST] == 0.0
    note_force_age(link.delays, seq, answered, delay, period, on)
    new, words[ANSWERED] = answered != words[ANSWERED], answered
    if not new or delay <= 0.0 or (seq - 1 - answered) & 0xFFFF >= FAR_BEHIND:
        return
    trip = delay - added_periods(r) * period
    n[ROUND_TRIP] = max(trip, 0.0)
    if trip <= n[WATCHDOG]:
        words[TOO_LONG] = 0
        return
    if words[TOO_LONG] == 0:
        n[TOO_LONG_SINCE] = now
    words[TOO_LONG] += 1
    late = words[TOO_LONG] >= _SLOW_ANSWERS and now - n[TOO_LONG_SINCE] >= SLOW_AFTER
    if late and wanted_code(r, link) == 0:
        latch(r, arrays.SLOW_LINK, trip, n[WATCHDOG])


@internal
def added_periods(r: LoopArrays) -> int:
    """Return the added delay in whole periods."""
    return min(int(r.settings.delay / r.settings.period + 0.5), MOST_ADDED)


@compiled
def note_gap(r: LoopArrays, link: Link, now: float) -> bool:
    """Return whether nothing was answered for STALE_AFTER; once there was a sample the sensor then is stale.

    The board has its motor off then. A wait never takes much longer than STALE_AFTER.
    """
    n = link.numbers
    if now - n[LAST_ANSWER] < STALE_AFTER:
        return False
    if n[LAST_ANSWER] > n[LOOKED_AT]:  # in this very pass: it took so long itself
        slow = load_acquire(r.control.fault, 0) == arrays.SLOW_LAW
        cause = arrays.HELD_UP if slow else arrays.AWAY
    else:
        cause = arrays.AWAY if now - n[LOOKED_AT] > 1.5 * STALE_AFTER else arrays.NO_SAMPLE
    if link.words[STARTED]:
        mark_stale(r, now, cause)
    return True


@compiled
def board_gone(r: LoopArrays, link: Link, now: float) -> bool:
    """Return whether a board that has been heard is silent for GONE_AFTER; latch that it is gone.

    A pass that took longer than its wait counts no more than twice that: then the computer was away.
    """
    n = link.numbers
    if not math.isfinite(n[LAST_ARRIVAL]):
        return False
    n[QUIET] += min(now - n[LOOKED_AT], 2.0 * STALE_AFTER)
    n[LOOKED_AT] = now
    if n[QUIET] < GONE_AFTER:
        return False
    latch(r, arrays.DEVICE_GONE, GONE_AFTER, r.tick.last_position)
    return True


@internal
def watch_motor(r: LoopArrays, link: Link, said: int, now: float) -> None:
    """Where the board cut its motor off although it was answered, come back as from a stale sensor.

    Not where that is as it should be: until the first answer is heard, after stop and release; but that does
    not take for ever.
    """
    n, words = link.numbers, link.words
    if said & codec.FLAG_STOPPED or words[HANDOVER] != ON_COMPUTER:
        words[MOTOR_SEEN_ON] = 0
        n[MOTOR_OFF_TIME] = 0.0
    elif not said & codec.FLAG_WATCHDOG:
        words[MOTOR_SEEN_ON] = 1
        n[MOTOR_OFF_TIME] = 0.0
    else:
        n[MOTOR_OFF_TIME] += r.settings.period
        if words[MOTOR_SEEN_ON] or r.tick.stale or n[MOTOR_OFF_TIME] > MOTOR_ON_WITHIN:
            words[MOTOR_SEEN_ON] = 0
            mark_stale(r, now, arrays.CUT)


@compiled
def check_clock(r: LoopArrays, link: Link, sample: np.ndarray, now: float) -> None:
    """Correct a sample's board time where the board's clock went back, stood still or jumped ahead.

    It jumped where it went on by more than the samples that were sent, and by more than our clock. Time goes
    on by their periods then, and the force is zero as after a gap: such a board may have started anew.
    """
    n = link.numbers
    time, elapsed = sample[codec.BOARD_TIME] + n[CLOCK_SHIFT], now - n[CLOCK_AT]
    passed, sent = time - n[CLOCK_LAST], r.settings.period * (1.0 + sample[codec.LOST])
    gained = now - time < n[CLOCK_AHEAD] - CLOCK_SLACK
    if n[CLOCK_AT] == 0.0:
        n[CLOCK_AHEAD] = now - time
    elif passed <= 0.0 or (passed > 1.5 * sent and gained):
        wrong, time = time, n[CLOCK_LAST] + sent
        n[CLOCK_SHIFT] += time - wrong
        link.words[LEFT_OUT] = 1
        if r.tick.stale:
            r.tick.good = 0.0
            causes = r.control.stale_causes
            store_release(causes, arrays.CLOCK_JUMP, causes[arrays.CLOCK_JUMP] + 1)
        else:
            mark_stale(r, now, arrays.CLOCK_JUMP)
    n[CLOCK_AHEAD] = min(now - time, n[CLOCK_AHEAD] + _CLOCK_SLOW * elapsed)
    n[CLOCK_LAST], n[CLOCK_AT] = time, now
    sample[codec.BOARD_TIME] = time


@internal
def time_since_last(link: Link, sample: np.ndarray) -> float:
    """Return the time in s since the last row by the board's clock, 0 where that means nothing."""
    before = link.numbers[LAST_BOARD_TIME]
    passed = sample[codec.BOARD_TIME] - before
    return passed if before > 0.0 and 0.0 < passed < 1.0 else 0.0


@compiled
def write_times(link: Link, board_time: float, row: np.ndarray, now: float) -> None:
    """Fill the row's times, and nan where only a simulation knows.

    It is late by what came later than one period after the last frame by the board's clock. Against the last
    frame alone: the two clocks drift, and a virtual board that was held up stays behind.
    """
    n = link.numbers
    row[rows.LATENESS] = max(0.0, (now - n[LAST_ARRIVAL]) - (board_time - n[LAST_BOARD_TIME]))
    n[LAST_ARRIVAL], n[LAST_BOARD_TIME] = now, board_time
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
    if link.words[HANDOVER] == ON_COMPUTER:
        note_link(r, link, sample, now)
    in_effect = link.numbers[SIGN] * effect(link, sample, period)
    row = out.rows[rows.next_index(out)]
    force = live_tick(r, position_of(link, sample[codec.COUNT]), period, in_effect, row)
    share, flags = fade_out(r, link, period), int(row[rows.FLAGS])
    if share < 1.0:
        force *= share
        row[rows.APPLIED_FORCE] = r.tick.applied = force
        flags |= rows.FADING
    gap = lost > 0.0 or link.words[LEFT_OUT] or time_since_last(link, sample) > 1.5 * period
    write_times(link, sample[codec.BOARD_TIME], row, now)
    if gap or said & codec.FLAG_SENSOR:
        flags |= rows.GAP
        link.words[LEFT_OUT] = 0
    if said & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    row[rows.FLAGS] = flags
    if r.tick.row_flags & (rows.STOPPED | rows.FAULT | rows.STALE):
        link.forces[:] = 0.0
    for back in range(min(int(lost), HISTORY - 1) + 1):
        link.forces[(int(sample[codec.SEQ]) - back) % HISTORY] = link.numbers[SIGN] * force

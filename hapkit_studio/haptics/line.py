"""One serial connection inside a loop: frames in, rows and answers out. Both serial drivers use it."""

import math
from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, delays, rig, ring, rows, way
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.haptics.tick import STALE_AFTER, latch, mark_stale, tick
from hapkit_studio.protocol import codec, law_frames

CHUNK = 4096
HISTORY = 2048
MOST_ADDED = 255
"""Periods of added delay: what a force can say of the sample that it answers."""
GONE_AFTER = 1.0
"""s without a frame after which a board counts as gone: it began anew, and no longer streams, or hangs."""

DEAF_AFTER = 0.3
"""s after which a board that is answered has its motor on."""
SLOW_AFTER = 0.15
"""s in which every answer is too late, after which the computer cannot render."""
_SLOW_ANSWERS = 4
_SEVERAL = 3

_MOTOR_OFF = codec.FLAG_WATCHDOG | codec.FLAG_STOPPED | codec.FLAG_REFUSED

# --- numbers
QUANTUM = 0
SIGN = 1
ZERO = 2
LAST_ARRIVAL = 3
LAST_BOARD_TIME = 4
QUIET = 5
LOOKED_AT = 6
EFFECT = 7
LAST_ANSWER = 8

# --- what the law is like that the board gets, in the order of the block's words from BOARD_RATE on
RATE, ESTIMATOR, STATES, GIVEN, SLOTS, CODE, CHECK = range(7)

# --- words
STARTED = 0
SENT_STOP = 1
ZEROED, FLIPPED = way.ZEROED, way.FLIPPED


class Line(NamedTuple):
    """The connection's arrays, allocated once."""

    reader: np.ndarray
    buffer: np.ndarray
    data: np.ndarray
    frame: np.ndarray
    samples: np.ndarray
    forces: np.ndarray  # the answer to each of the last samples, as the board counts direction
    numbers: np.ndarray
    words: np.ndarray
    delays: delays.Delays
    law: np.ndarray  # what the law is like that the board got last, (7,)
    program: np.ndarray  # its bytes, packed, the constants as they were sent last
    unsure: np.ndarray  # 1 for each number at their beginning that the board may not have
    settings: np.ndarray  # the body of Board that it has, uint8
    motor: np.ndarray  # force in N at each duty from 0 to its top


def new_line(quantum: float, watchdog: float = 0.025) -> Line:
    """Return a connection that has received nothing, for a sensor of quantum m a count.

    watchdog: s after which the board obeys no force.
    """
    reader, buffer = codec.new_reader()
    numbers = np.zeros(way.NUMBERS)
    numbers[QUANTUM], numbers[SIGN], numbers[way.WATCHDOG] = quantum, 1.0, watchdog
    numbers[LAST_ARRIVAL] = math.inf  # the first frame is not late
    return Line(
        reader=reader,
        buffer=buffer,
        data=np.zeros(CHUNK, dtype=np.uint8),
        frame=np.zeros(law_frames.ROOM, dtype=np.uint8),
        samples=np.zeros((codec.rows_for(CHUNK), codec.SAMPLE_WIDTH)),
        forces=np.zeros(HISTORY),
        numbers=numbers,
        words=np.zeros(way.WORDS, dtype=np.int64),
        delays=delays.new_delays(),
        law=np.zeros(CHECK + 1, dtype=np.int64),
        program=np.zeros(block.PROGRAM_WORDS, dtype=np.int64),
        unsure=np.zeros(2 * block.PROGRAM_WORDS, dtype=np.int64),
        settings=np.zeros(law_frames.BOARD_BODY, dtype=np.uint8),
        motor=np.zeros(256),
    )


@internal
def position_of(line, count):
    """Return the handle's position in m for a sensor count."""
    n = line.numbers
    return n[SIGN] * (count - n[ZERO]) * n[QUANTUM]


@internal
def start_over(r, line, count):
    """Forget motion and fade the force in from zero: position has another meaning from here."""
    position = position_of(line, count)
    estimators.reset(r.memory, position)
    r.real[rig.LAST_POSITION] = position
    r.real[rig.GAIN] = 0.0


@internal
def obey(r, line, count):
    """Set zero and direction when the window asked for it; on a board without a zero the first sample."""
    n, words = line.numbers, line.words
    zeroed = load_acquire(r.control, rig.ZERO)
    flipped = load_acquire(r.control, rig.FLIP)
    if words[STARTED] and zeroed == words[ZEROED] and flipped == words[FLIPPED]:
        return
    if zeroed != words[ZEROED] if words[STARTED] else not words[way.CALIBRATED]:
        n[ZERO] = count
    if flipped != words[FLIPPED] and words[STARTED]:
        n[SIGN] = -n[SIGN]
    words[STARTED] = 1
    words[ZEROED], words[FLIPPED] = zeroed, flipped
    start_over(r, line, count)


@internal
def effect(line, sample, period):
    """Return the mean force in N over the last period: the old one until the answer came, then that."""
    old = line.numbers[EFFECT]
    new = line.forces[int(sample[codec.ANSWERED]) % HISTORY]
    if int(sample[codec.FLAGS]) & _MOTOR_OFF:
        new = 0.0
    line.numbers[EFFECT] = new
    behind = (int(sample[codec.SEQ]) - 1 - int(sample[codec.ANSWERED])) & 0xFFFF
    share = min(max(sample[codec.DELAY] / period - behind, 0.0), 1.0)
    return new + (old - new) * share


@internal
def note_age(line, sample, period):
    """Measure the delay, from samples that follow one another while the motor is on."""
    on = int(sample[codec.FLAGS]) & _MOTOR_OFF == 0 and sample[codec.LOST] == 0.0
    seq, answered = int(sample[codec.SEQ]), int(sample[codec.ANSWERED])
    delays.note_age(line.delays, seq, answered, sample[codec.DELAY], period, on)


@internal
def note_link(r, line, sample, now):
    """Measure how long samples and forces are on their way; where no force can be in time, latch that.

    The board obeys no force whose newest sample is older than its watchdog's time, but for zero.
    """
    n, words = line.numbers, line.words
    answered = int(sample[codec.ANSWERED])
    new, words[way.ANSWERED] = answered != words[way.ANSWERED], answered
    behind = (int(sample[codec.SEQ]) - 1 - answered) & 0xFFFF
    if not new or sample[codec.DELAY] <= 0.0 or behind >= delays.FAR:
        return
    trip = sample[codec.DELAY] - added(r) * r.values[block.PERIOD]
    n[way.ROUND_TRIP] = max(trip, 0.0)
    if trip <= n[way.WATCHDOG]:
        words[way.TOO_LONG] = 0
        return
    if words[way.TOO_LONG] == 0:
        n[way.TOO_LONG_SINCE] = now
    words[way.TOO_LONG] += 1
    late = words[way.TOO_LONG] >= _SLOW_ANSWERS and now - n[way.TOO_LONG_SINCE] >= SLOW_AFTER
    if late and way.wanted(r, line) == 0:
        latch(r, rig.SLOW_LINK, trip, n[way.WATCHDOG])


@internal
def added(r):
    """Return the added delay in whole periods."""
    return min(int(r.values[block.DELAY] / r.values[block.PERIOD] + 0.5), MOST_ADDED)


@internal
def keep(line, seq, lost, force):
    """Keep the answer to sample seq; lost samples before it count as answered by the same."""
    for back in range(min(int(lost), HISTORY - 1) + 1):
        line.forces[(seq - back) % HISTORY] = force


@compiled
def overslept(r, line, now):
    """Come back from a gap in the answers, when the board had its motor off, as from a stale sensor."""
    if line.words[STARTED] and now - line.numbers[LAST_ANSWER] >= STALE_AFTER:
        mark_stale(r, now, cause(r, line, now))


@internal
def cause(r, line, now):
    """Return why nothing was answered for STALE_AFTER: a wait never takes much longer than that."""
    n = line.numbers
    if n[LAST_ANSWER] > n[LOOKED_AT]:  # in this very pass: it took so long itself
        return rig.HELD_UP if r.word[rig.LONG] >= _SEVERAL else rig.AWAY
    return rig.AWAY if now - n[LOOKED_AT] > 1.5 * STALE_AFTER else rig.NO_SAMPLE


@compiled
def quiet(line, now):
    """Return whether a board that has been heard sends nothing any more for GONE_AFTER.

    A pass that took longer than its wait counts no more than twice that: then the computer was away.
    """
    n = line.numbers
    if not math.isfinite(n[LAST_ARRIVAL]):
        return False
    n[QUIET] += min(now - n[LOOKED_AT], 2.0 * STALE_AFTER)
    n[LOOKED_AT] = now
    return n[QUIET] >= GONE_AFTER


@compiled
def lateness(line, now, board_time):
    """Return how much later than one period after the last frame this one came, by the board's clock, in s.

    Against the last frame alone: the two clocks drift, and a virtual board that was held up stays behind.
    """
    n = line.numbers
    late = (now - n[LAST_ARRIVAL]) - (board_time - n[LAST_BOARD_TIME])
    n[LAST_ARRIVAL], n[LAST_BOARD_TIME] = now, board_time
    return max(0.0, late)


@internal
def heed(r, line, said, now):
    """Where the board cut its motor off although it was answered, come back as from a stale sensor.

    Not where that is as it should be: until the first answer is heard, after stop and release; but that does
    not take for ever.
    """
    n, words = line.numbers, line.words
    if said & codec.FLAG_STOPPED or words[way.WAY] != way.HERE:
        words[way.OBEYED] = 0
        n[way.DEAF] = 0.0
    elif not said & codec.FLAG_WATCHDOG:
        words[way.OBEYED] = 1
        n[way.DEAF] = 0.0
    else:
        n[way.DEAF] += r.values[block.PERIOD]
        if words[way.OBEYED] or r.word[rig.STALE] or n[way.DEAF] > DEAF_AFTER:
            words[way.OBEYED] = 0
            mark_stale(r, now, rig.CUT)


@internal
def leapt(line, sample, period):
    """Return whether more than a period in s has passed by the board's clock: its pace was another one."""
    before = line.numbers[LAST_BOARD_TIME]
    passed = sample[codec.BOARD_TIME] - before
    return before > 0.0 and 1.5 * period < passed < 1.0


@internal
def stamp(line, sample, row, now):
    """Fill the row's times, and nan where only a simulation knows."""
    row[rows.LATENESS] = lateness(line, now, sample[codec.BOARD_TIME])
    row[rows.HOST_TIME] = now
    row[rows.BOARD_TIME] = sample[codec.BOARD_TIME]
    row[rows.TRUE_POSITION] = row[rows.TRUE_VELOCITY] = math.nan
    row[rows.HAND_FORCE] = row[rows.HAND_TARGET] = math.nan


@compiled
def render(r, line, out, k, now):
    """Render the k-th decoded sample into the ring's next row; keep its answer."""
    sample = line.samples[k]
    nominal = r.values[block.PERIOD]
    period = nominal * (1.0 + sample[codec.LOST])
    obey(r, line, sample[codec.COUNT])
    said = int(sample[codec.FLAGS])
    heed(r, line, said, now)
    if line.words[way.WAY] == way.HERE:
        note_age(line, sample, nominal)
        note_link(r, line, sample, now)
    in_effect = line.numbers[SIGN] * effect(line, sample, period)
    row = out.rows[ring.next_index(out)]
    force = tick(r, position_of(line, sample[codec.COUNT]), period, in_effect, row)
    share = way.leave(r, line, period)
    if share < 1.0:
        force *= share
        row[rows.APPLIED] = r.real[rig.APPLIED] = force
        row[rows.FLAGS] = int(row[rows.FLAGS]) | rows.FADING
    gap = sample[codec.LOST] > 0.0 or line.words[way.UNSHOWN] or leapt(line, sample, period)
    stamp(line, sample, row, now)
    if gap or said & codec.FLAG_SENSOR:
        row[rows.FLAGS] = int(row[rows.FLAGS]) | rows.GAP
        line.words[way.UNSHOWN] = 0
    if said & codec.FLAG_CLAMPED:
        row[rows.FLAGS] = int(row[rows.FLAGS]) | rows.CLAMPED
    store_release(r.control, rig.LOST_FRAMES, line.reader[codec.LOST_FRAMES])
    store_release(r.control, rig.CRC_ERRORS, line.reader[codec.BAD_FRAMES])
    if r.word[rig.FLAGS] & (rows.STOPPED | rows.FAULT | rows.STALE):
        line.forces[:] = 0.0
    keep(line, int(sample[codec.SEQ]), sample[codec.LOST], line.numbers[SIGN] * force)


@compiled
def answer(r, line, k, now, frame):
    """Encode into frame what answers sample k, an added delay of whole periods ago; return its length."""
    line.numbers[LAST_ANSWER] = now
    newest, behind = int(line.samples[k, codec.SEQ]), added(r)
    return codec.encode_force(frame, newest, behind, line.forces[(newest - behind) % HISTORY])


@compiled
def stop_word(r, line):
    """Return the message that tells the board of a changed E-stop, 0 when nothing changed.

    While the board renders, a latched fault stops it as well.
    """
    stopped = load_acquire(r.control, rig.STOP)
    if line.words[way.WAY] != way.HERE and load_acquire(r.control, rig.FAULT) != rig.NO_FAULT:
        stopped = 1
    if stopped == line.words[SENT_STOP]:
        return 0
    line.words[SENT_STOP] = stopped
    if not stopped:
        line.words[way.LAW_DUE] = 1  # its state has gone on meanwhile
    return codec.STOP if stopped else codec.RELEASE

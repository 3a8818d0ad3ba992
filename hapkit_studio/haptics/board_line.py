"""Telemetry of a board that renders by itself, turned into rows: what was asked, what the motor did."""

import math

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import block, delays, line, rig, ring, rows, settings, way
from hapkit_studio.haptics.fences import store_release
from hapkit_studio.haptics.tick import latch, recover
from hapkit_studio.protocol import codec

FRAME = 1e-3
"""s between two frames of telemetry, where the board does not render more slowly."""

_FADE = 0.030
_OFF = codec.FLAG_WATCHDOG | codec.FLAG_REFUSED | codec.FLAG_OVER_SPEED | codec.FLAG_STOPPED


@compiled
def render(r, conn, out, k, now):
    """Show the k-th decoded frame, telemetry, in the ring's next row."""
    sample = conn.samples[k]
    row = out.rows[ring.next_index(out)]
    arrive(r, conn, sample)
    period = since_last(conn, sample)
    position = line.position_of(conn, sample[codec.COUNT])
    if settings.due(r):
        fault = r.control[rig.FAULT]
        settings.refresh(r, position, period)
        if fault != rig.NO_FAULT and r.control[rig.FAULT] == rig.NO_FAULT:
            conn.numbers[way.EXCUSED] = now + way.PATIENCE + conn.numbers[way.ROUND_TRIP]
    if r.word[rig.STALE]:
        recover(r, period)
    line.stamp(conn, sample, row, now)
    delays.note(conn.delays, delays.BOARD, sample[codec.DELAY])
    conn.numbers[way.SEEN_SPEED] = (position - r.real[rig.LAST_POSITION]) / period
    fill(r, conn, sample, row, position, period)
    lost = lost_frames(conn, sample, period)
    row[rows.FLAGS] = flags_of(r, conn, sample, now, lost > 0 or period > 1.5 * frame_of(conn))
    r.word[rig.FLAGS] = int(row[rows.FLAGS])
    if r.word[rig.FLAGS] & (rows.STOPPED | rows.FAULT | rows.STALE):
        r.real[rig.APPLIED] = row[rows.APPLIED]
    store_release(r.control, rig.LOST_FRAMES, conn.reader[codec.LOST_FRAMES])
    store_release(r.control, rig.CRC_ERRORS, conn.reader[codec.BAD_FRAMES])


@internal
def arrive(r, conn, sample):
    """Notice that the board renders what it was told to, or that it was not told to."""
    n, words = conn.numbers, conn.words
    if words[way.WAY] == way.ASKING and int(sample[codec.GENERATION]) == words[way.LAW_GENERATION]:
        words[way.WAY], words[way.OBEYED] = way.THERE, 1
        n[way.FADED_AT] = sample[codec.BOARD_TIME] + _FADE
        words[way.OVERRUNS] = int(sample[codec.OVERRUNS])
    elif words[way.WAY] <= way.SETTING:
        words[way.WAY] = way.RETURNING
        n[way.ASKED_AT] = -way.PATIENCE
    r.real[rig.GAIN] = 0.0


@internal
def since_last(conn, sample):
    """Return the time in s since the last row by the board's clock, a frame's where that means nothing."""
    before = conn.numbers[line.LAST_BOARD_TIME]
    passed = sample[codec.BOARD_TIME] - before
    return passed if before > 0.0 and 0.0 < passed < 1.0 else FRAME


@internal
def frame_of(conn):
    """Return the time in s from one frame of telemetry to the next."""
    rate = conn.law[line.RATE]
    return max(FRAME, 1.0 / rate) if rate > 0 else FRAME


@internal
def lost_frames(conn, sample, period):
    """Return how many frames are missing before this one, and count them; ticks are not all shown."""
    if sample[codec.LOST] <= 0.0 or conn.law[line.RATE] <= 0:
        return 0
    lost = max(int(period / frame_of(conn) + 0.5) - 1, 0)
    conn.reader[codec.LOST_FRAMES] += lost
    return lost


@internal
def finite(value):
    """Return a number, 0 in place of what is none."""
    return value if math.isfinite(value) else 0.0


@internal
def fill(r, conn, sample, row, position, period):
    """Fill what the board says of motion, force and state."""
    real, word, sign = r.real, r.word, conn.numbers[line.SIGN]
    duty = int(sample[codec.PWM])
    applied = sign * math.copysign(conn.motor[min(abs(duty), conn.motor.size - 1)], duty)
    row[rows.TICK] = word[rig.TICK]
    word[rig.TICK] += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = sign * finite(sample[codec.VELOCITY])
    row[rows.ASKED] = sign * finite(sample[codec.ASKED])
    row[rows.APPLIED] = applied
    row[rows.PERIOD] = period
    real[rig.ENERGY] += 0.5 * (real[rig.APPLIED] + applied) * (position - real[rig.LAST_POSITION])
    row[rows.ENERGY] = real[rig.ENERGY]
    real[rig.APPLIED] = applied
    real[rig.LAST_POSITION] = position
    real[rig.VELOCITY] = row[rows.VELOCITY]
    word[rig.RENEW] = 1  # the passivity observer does not watch here
    place = int(row[rows.TICK]) & (r.energies.shape[0] - 1)
    r.energies[place, 0] = r.energies[place, 1] = math.nan
    take_state(r, conn, sample, row)


@internal
def take_state(r, conn, sample, row):
    """Keep the value of state that this frame shows, if it is the law's in force; fill the row's."""
    states = r.states[r.word[rig.SLOT]]
    at = int(sample[codec.STATE_AT])
    same = conn.words[way.WAY] == way.THERE and r.words[block.BOARD_LAW] == r.words[block.LAW]
    if at < r.words[block.N_STATE] and same and r.words[block.FORM] == conn.words[way.FORM]:
        states[at] = sample[codec.STATE]
    for i in range(rows.STATES):
        row[rows.STATE + i] = states[i]


@internal
def flags_of(r, conn, sample, now, gap):
    """Return the row's flags; what the board latched is latched here, with words.

    gap: frames are missing before this one, or were not shown. What the sensor left out is one as well.
    """
    n, said = conn.numbers, int(sample[codec.FLAGS])
    missed = (int(sample[codec.OVERRUNS]) - conn.words[way.OVERRUNS]) & 0xFF
    if missed and conn.words[way.WAY] >= way.THERE:
        store_release(r.control, rig.MISSED, r.control[rig.MISSED] + missed)
        conn.words[way.SKIPPED] += missed
    conn.words[way.OVERRUNS] = int(sample[codec.OVERRUNS])
    latch_what_is_said(r, n, said, now)
    count_cuts(r, conn, said)
    flags = rows.GAP if gap or said & codec.FLAG_SENSOR else 0
    if said & codec.FLAG_CLAMPED:
        flags |= rows.CLAMPED
    if said & codec.FLAG_STOPPED:
        flags |= rows.STOPPED
    if said & codec.FLAG_WATCHDOG or r.word[rig.STALE]:
        flags |= rows.STALE
    if r.control[rig.FAULT] != rig.NO_FAULT:
        flags |= rows.FAULT
    if said & _OFF:
        n[way.FADED_AT] = sample[codec.BOARD_TIME] + _FADE
    elif sample[codec.BOARD_TIME] < n[way.FADED_AT]:
        flags |= rows.FADING
    return flags


@internal
def count_cuts(r, conn, said):
    """Count how often the board switched its motor off although it was told that someone is there."""
    words = conn.words
    off = said & codec.FLAG_WATCHDOG != 0 and said & codec.FLAG_STOPPED == 0
    if off and words[way.OBEYED] and not r.word[rig.STALE]:
        count = r.control[rig.STALE_CAUSES + rig.CUT] + 1
        store_release(r.control, rig.STALE_CAUSES + rig.CUT, count)
    words[way.OBEYED] = not off


@internal
def latch_what_is_said(r, n, said, now):
    """Latch over-speed and a force that is no number, unless the board was told just now to forget them.

    A board that saw a leap gives up its estimate: then the speed is what its positions come to.
    """
    speed, position = r.real[rig.VELOCITY], r.real[rig.LAST_POSITION]
    if now < n[way.EXCUSED]:
        return
    if said & codec.FLAG_OVER_SPEED or abs(speed) > r.values[block.MAX_SPEED]:
        seen = n[way.SEEN_SPEED]
        latch(r, rig.OVER_SPEED, speed if abs(speed) > r.values[block.MAX_SPEED] else seen, position)
    if said & codec.FLAG_REFUSED:
        latch(r, rig.NOT_A_NUMBER, math.nan, position)


@internal
def come_back(r, conn, count):
    """Let the computer's tick go on from the motion as the board saw it; the force fades in."""
    position = line.position_of(conn, count)
    estimators.resume(r.memory, position, r.real[rig.VELOCITY])
    r.real[rig.LAST_POSITION] = position
    r.real[rig.GAIN] = 0.0
    conn.forces[:] = 0.0
    conn.numbers[line.EFFECT] = 0.0

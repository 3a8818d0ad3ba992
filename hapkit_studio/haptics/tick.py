"""The one tick: position in, force out. Every driver renders through it, live, headless and in sweeps.

position -> velocity estimate -> law -> passivity -> fade -> safety -> motor command -> telemetry row
"""

import math

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, inlined, internal
from hapkit_studio.haptics import block, observer, rig, rows, settings
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.laws.native import call

STALE_AFTER = 0.020
RECOVER_AFTER = 0.100
STALE_WINDOW = 10.0
MOST_LONG = 50
"""Samples in a row whose law may take longer than a period."""


@internal
def render(r, position, velocity, period):
    """Return the force in N the law asks for, both laws weighted while a switch fades over."""
    real = r.real
    slot = r.word[rig.SLOT]
    asked = call(r.laws[slot], r.params[slot], r.states[slot], position, velocity, period, r.fault)
    blend = real[rig.BLEND]
    if blend < 1.0 and math.isfinite(asked):
        old = 1 - slot
        before = call(r.laws[old], r.params[old], r.states[old], position, velocity, period, r.fault)
        asked = blend * asked + (1.0 - blend) * before
    return asked


@compiled
def latch(r, code, value, position):
    """Latch a fault: the first one stays until it is cleared."""
    if load_acquire(r.control, rig.FAULT) == rig.NO_FAULT:
        r.real[rig.FAULT_VALUE] = value
        r.real[rig.FAULT_POSITION] = position
        store_release(r.control, rig.FAULT, code)


@compiled
def mark_stale(r, now, cause):
    """Nothing came, or was answered, in time: zero force from here; three times in ten seconds latch."""
    real = r.real
    real[rig.GOOD] = 0.0
    if r.word[rig.STALE]:
        return
    r.word[rig.STALE] = 1
    real[rig.GAIN] = 0.0
    real[rig.APPLIED] = 0.0
    count = load_acquire(r.control, rig.STALE_COUNT)
    oldest = rig.STALE_TIMES + (count + 1) % 3
    real[rig.STALE_TIMES + count % 3] = now
    if count >= 2 and now - real[oldest] <= STALE_WINDOW:
        latch(r, rig.STALE_SENSOR, cause, real[rig.LAST_POSITION])
    store_release(r.control, rig.STALE_CAUSES + cause, r.control[rig.STALE_CAUSES + cause] + 1)
    store_release(r.control, rig.STALE_COUNT, count + 1)


@compiled
def note_time(r, spent):
    """Latch a law that takes longer than a period, sample after sample; once or twice anything does."""
    if spent <= r.values[block.PERIOD]:
        r.word[rig.LONG] = 0
        return
    r.word[rig.LONG] += 1
    if r.word[rig.LONG] >= MOST_LONG:
        latch(r, rig.SLOW_LAW, spent, r.values[block.PERIOD])


@internal
def recover(r, period):
    """Count good frames after a gap, lost ones not; after RECOVER_AFTER the force fades in again."""
    real = r.real
    real[rig.GOOD] += min(period, r.values[block.PERIOD])
    if real[rig.GOOD] >= RECOVER_AFTER:
        r.word[rig.STALE] = 0


@internal
def blocked(r, period):
    """Return the flags that hold the force at zero now: stop, fault, stale sensor, hold after connecting."""
    flags = 0
    if load_acquire(r.control, rig.STOP):
        flags |= rows.STOPPED
    if load_acquire(r.control, rig.FAULT):
        flags |= rows.FAULT
    if r.word[rig.STALE]:
        recover(r, period)
        flags |= rows.STALE
    return flags


@internal
def guard(r, asked, velocity, position, period):
    """Return the force in N that may reach the motor: the last line before it. Sets the row's flags."""
    real = r.real
    if not math.isfinite(asked) or r.fault[0]:
        latch(r, max(r.fault[0], rig.NOT_A_NUMBER), asked, position)
    if abs(velocity) > r.values[block.MAX_SPEED]:
        latch(r, rig.OVER_SPEED, velocity, position)
    flags = blocked(r, period)
    if real[rig.HOLD] > 0.0:
        real[rig.HOLD] -= period
        flags |= rows.FADING
    if flags:
        real[rig.GAIN] = 0.0
        r.word[rig.FLAGS] = flags
        return 0.0
    force = asked
    gain = real[rig.GAIN]
    if gain < 1.0:
        gain = settings.advanced(gain, min(period, r.values[block.PERIOD]) / r.values[block.FADE])
        real[rig.GAIN] = gain
        force = gain * asked
    if gain < 1.0 or real[rig.BLEND] < 1.0:
        flags |= rows.FADING
    limit = r.values[block.MAX_FORCE]
    if abs(force) > limit:
        flags |= rows.CLAMPED
        force = math.copysign(limit, force)
    r.word[rig.FLAGS] = flags
    return force


@inlined
def tick(r, position, period, effect, row):
    """Render one sample; fill the row's columns that the tick knows; return the force for the motor in N.

    effect is the mean force in N in effect since the last sample; the driver fills times and truth, truth
    before the tick where the block asks for the true velocity.
    """
    real, word = r.real, r.word
    if settings.due(r):
        settings.refresh(r, position, period)
    code = r.words[block.ESTIMATOR]
    if code == block.TRUTH:
        velocity = row[rows.TRUE_VELOCITY]
    else:
        velocity = estimators.step(code, r.values[block.COEFS :], r.memory, position, period)
    observer.watch(r, position, effect, period)
    asked = 0.0
    if load_acquire(r.control, rig.FAULT) == rig.NO_FAULT:
        asked = render(r, position, velocity, period)
    taken = observer.control(r, period)
    force = guard(r, asked - taken, velocity, position, period)
    observer.judge(r, taken, position, period)
    real[rig.ENERGY] += effect * (position - real[rig.LAST_POSITION])
    real[rig.LAST_POSITION] = position
    real[rig.APPLIED] = force
    real[rig.VELOCITY] = velocity
    row[rows.TICK] = word[rig.TICK]
    word[rig.TICK] += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = velocity
    row[rows.ASKED] = asked
    row[rows.APPLIED] = force
    row[rows.ENERGY] = real[rig.ENERGY]
    row[rows.FLAGS] = word[rig.FLAGS]
    row[rows.PERIOD] = period
    slot = word[rig.SLOT]
    for i in range(rows.STATES):
        row[rows.STATE + i] = r.states[slot, i]
    return force

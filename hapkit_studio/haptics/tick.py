"""The one tick: position in, force out. Every driver renders through it, live, headless and in sweeps.

position -> velocity estimate -> law -> passivity -> fade -> safety -> motor command -> telemetry row
"""

import math

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, inlined, internal
from hapkit_studio.haptics import arrays, block, passivity, rows, transitions
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.fences import load_acquire, store_release
from hapkit_studio.laws.native import call

STALE_AFTER = 0.020
RECOVER_AFTER = 0.100
STALE_WINDOW = 10.0
MOST_LONG = 50
"""Samples in a row whose law may take longer than a period."""


@internal
def render(r: LoopArrays, position: float, velocity: float, period: float) -> float:
    """Return the force in N the law asks for, both laws weighted while a switch fades over."""
    real = r.real
    slot = r.word[arrays.SLOT]
    asked = call(r.laws[slot], r.params[slot], r.states[slot], position, velocity, period, r.fault)
    blend = real[arrays.BLEND]
    if blend < 1.0 and math.isfinite(asked):
        old = 1 - slot
        before = call(r.laws[old], r.params[old], r.states[old], position, velocity, period, r.fault)
        asked = blend * asked + (1.0 - blend) * before
    return asked


@compiled
def latch(r: LoopArrays, code: int, value: float, position: float) -> None:
    """Latch a fault: the first one stays until it is cleared."""
    if load_acquire(r.control, arrays.FAULT) == arrays.NO_FAULT:
        r.real[arrays.FAULT_VALUE] = value
        r.real[arrays.FAULT_POSITION] = position
        store_release(r.control, arrays.FAULT, code)


@compiled
def mark_stale(r: LoopArrays, now: float, cause: int) -> None:
    """Nothing came, or was answered, in time: zero force from here; three times in ten seconds latch."""
    real = r.real
    real[arrays.GOOD] = 0.0
    if r.word[arrays.STALE]:
        return
    r.word[arrays.STALE] = 1
    real[arrays.GAIN] = 0.0
    real[arrays.APPLIED] = 0.0
    count = load_acquire(r.control, arrays.STALE_COUNT)
    oldest = arrays.STALE_TIMES + (count + 1) % 3
    real[arrays.STALE_TIMES + count % 3] = now
    if count >= 2 and now - real[oldest] <= STALE_WINDOW:
        latch(r, arrays.STALE_SENSOR, cause, real[arrays.LAST_POSITION])
    store_release(r.control, arrays.STALE_CAUSES + cause, r.control[arrays.STALE_CAUSES + cause] + 1)
    store_release(r.control, arrays.STALE_COUNT, count + 1)


@compiled
def note_time(r: LoopArrays, spent: float) -> None:
    """Latch a law that takes longer than a period, sample after sample; once or twice anything does."""
    if spent <= r.values[block.PERIOD]:
        r.word[arrays.LONG] = 0
        return
    r.word[arrays.LONG] += 1
    if r.word[arrays.LONG] >= MOST_LONG:
        latch(r, arrays.SLOW_LAW, spent, r.values[block.PERIOD])


@internal
def recover(r: LoopArrays, period: float) -> None:
    """Count good frames after a gap, lost ones not; after RECOVER_AFTER the force fades in again."""
    real = r.real
    real[arrays.GOOD] += min(period, r.values[block.PERIOD])
    if real[arrays.GOOD] >= RECOVER_AFTER:
        r.word[arrays.STALE] = 0


@internal
def blocked(r: LoopArrays, period: float) -> int:
    """Return the flags that hold the force at zero now: stop, fault, stale sensor, hold after connecting."""
    flags = 0
    if load_acquire(r.control, arrays.STOP):
        flags |= rows.STOPPED
    if load_acquire(r.control, arrays.FAULT):
        flags |= rows.FAULT
    if r.word[arrays.STALE]:
        recover(r, period)
        flags |= rows.STALE
    return flags


@internal
def guard(r: LoopArrays, asked: float, velocity: float, position: float, period: float) -> float:
    """Return the force in N that may reach the motor: the last line before it. Sets the row's flags."""
    real = r.real
    if not math.isfinite(asked) or r.fault[0]:
        latch(r, max(r.fault[0], arrays.NOT_A_NUMBER), asked, position)
    if abs(velocity) > r.values[block.MAX_SPEED]:
        latch(r, arrays.OVER_SPEED, velocity, position)
    flags = blocked(r, period)
    if real[arrays.HOLD] > 0.0:
        real[arrays.HOLD] -= period
        flags |= rows.FADING
    if flags:
        real[arrays.GAIN] = 0.0
        r.word[arrays.FLAGS] = flags
        return 0.0
    force = asked
    gain = real[arrays.GAIN]
    if gain < 1.0:
        gain = transitions.advanced(gain, min(period, r.values[block.PERIOD]) / r.values[block.FADE])
        real[arrays.GAIN] = gain
        force = gain * asked
    if gain < 1.0 or real[arrays.BLEND] < 1.0:
        flags |= rows.FADING
    limit = r.values[block.MAX_FORCE]
    if abs(force) > limit:
        flags |= rows.CLAMPED
        force = math.copysign(limit, force)
    r.word[arrays.FLAGS] = flags
    return force


@inlined
def tick(r: LoopArrays, position: float, period: float, effect: float, row: np.ndarray) -> float:
    """Render one sample; fill the row's columns that the tick knows; return the force for the motor in N.

    effect is the mean force in N in effect since the last sample; the driver fills times and truth, truth
    before the tick where the block asks for the true velocity.
    """
    real, word = r.real, r.word
    if transitions.due(r):
        transitions.refresh(r, position, period)
    code = r.words[block.ESTIMATOR]
    if code == block.TRUTH:
        velocity = row[rows.TRUE_VELOCITY]
    else:
        velocity = estimators.step(code, r.values[block.COEFS :], r.memory, position, period)
    passivity.watch(r, position, effect, period)
    asked = 0.0
    if load_acquire(r.control, arrays.FAULT) == arrays.NO_FAULT:
        asked = render(r, position, velocity, period)
    taken = passivity.control(r, period)
    force = guard(r, asked - taken, velocity, position, period)
    passivity.judge(r, taken, position, period)
    real[arrays.ENERGY] += effect * (position - real[arrays.LAST_POSITION])
    real[arrays.LAST_POSITION] = position
    real[arrays.APPLIED] = force
    real[arrays.VELOCITY] = velocity
    row[rows.TICK] = word[arrays.TICK]
    word[arrays.TICK] += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = velocity
    row[rows.ASKED] = asked
    row[rows.APPLIED] = force
    row[rows.ENERGY] = real[arrays.ENERGY]
    row[rows.FLAGS] = word[arrays.FLAGS]
    row[rows.PERIOD] = period
    slot = word[arrays.SLOT]
    for i in range(rows.STATES):
        row[rows.STATE + i] = r.states[slot, i]
    return force

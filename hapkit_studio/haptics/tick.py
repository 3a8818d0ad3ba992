"""The one tick: position in, force out. Every driver renders through it, live, headless and in sweeps.

position -> velocity estimate -> law -> passivity -> fade -> safety -> motor command -> telemetry row

What the passivity controller takes comes off the clamped force, and the sum is clamped once more.

New settings come into force inside it: numbers ramp, choices and laws cross-fade.
"""

import math

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, inlined, inlined_and_called, internal
from hapkit_studio.haptics import arrays, block, clock, passivity, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.clib import load_acquire, store_release
from hapkit_studio.laws.native import call
from hapkit_studio.laws.translate import FUEL

STALE_AFTER = 0.020
RECOVER_AFTER = 0.100
STALE_WINDOW = 10.0
OVERRUN_WINDOW, MOST_OVERRUN, MOST_ONCE = 0.1, 0.005, 0.050
"""s of processor time: a law latches a fault where two or more calls longer than a period use the second
within the first, or one call uses the third. A page that the kernel has to clear takes some ms, once."""
LONGEST_TURN = 20e-6
"""s of processor time that one turn of a law's loops explains, and the rest of a call: some 1,000 sines. A
computer that lends its processor to others counts their time as the thread's, 4 ms at once."""
_SUSPECT = 0.1  # of a period: shorter ticks by the wall clock need no look at the processor time
_ROUNDING = 1e-9


@internal
def due(r: LoopArrays) -> bool:
    """Return whether ``refresh`` has anything to do; at nearly every tick it has not."""
    if load_acquire(r.block.words, block.SEQUENCE) != r.words[block.SEQUENCE]:
        return True
    if load_acquire(r.control, arrays.CLEAR) != r.word[arrays.CLEARED]:
        return True
    moving = r.real[arrays.RAMP] < 1.0 or r.real[arrays.BLEND] < 1.0
    return moving or r.word[arrays.GENERATION] != r.words[block.GENERATION]


@internal
def refresh(r: LoopArrays, position: float, period: float) -> None:
    """Take a newer block, move ramp and cross-fade on by a period, obey a cleared fault."""
    if load_acquire(r.block.words, block.SEQUENCE) != r.words[block.SEQUENCE]:
        adopt(r, position)
    real = r.real
    if real[arrays.RAMP] < 1.0 or real[arrays.BLEND] < 1.0:
        move(r, period / r.values[block.FADE])
    elif r.word[arrays.GENERATION] != r.words[block.GENERATION]:
        r.word[arrays.GENERATION] = r.words[block.GENERATION]
        store_release(r.control, arrays.ACCEPTED, r.words[block.GENERATION])
    cleared = load_acquire(r.control, arrays.CLEAR)
    if cleared != r.word[arrays.CLEARED]:
        r.word[arrays.CLEARED] = cleared
        clear_fault(r)


@compiled
def adopt(r: LoopArrays, position: float) -> None:
    """Bring a new block into force; while a cross-fade runs it waits, and the newest one is taken after."""
    real, word = r.real, r.word
    if real[arrays.BLEND] < 1.0 and word[arrays.STARTED]:
        return
    if not block.take(r.block, r.draft):
        return
    estimator = r.words[block.ESTIMATOR]
    if word[arrays.STARTED] and other_loop(r):
        word[arrays.RENEW] = 1
    block.copy(r.draft, Block(r.values, r.words, r.program))
    r.words[block.SEQUENCE] = r.draft.words[block.SEQUENCE]
    if not word[arrays.STARTED]:
        begin(r, position)
        return
    if r.words[block.ESTIMATOR] != estimator:
        estimators.resume(r.memory, real[arrays.LAST_POSITION], real[arrays.VELOCITY])
    if other_form(r):
        switch(r)
    elif other_numbers(r):
        slot = word[arrays.SLOT]
        for i in range(r.words[block.N_PARAMS]):
            r.start[i] = r.params[slot, i]
            r.goal[i] = r.values[block.PARAMS + i]
        real[arrays.RAMP] = 0.0


@internal
def other_loop(r: LoopArrays) -> bool:
    """Return whether the block just read has another loop or device than the one in force."""
    if r.draft.words[block.ESTIMATOR] != r.words[block.ESTIMATOR]:
        return True
    for i in range(block.COEFS, block.VALUES):
        hand = block.HAND_MASS <= i <= block.HAND_TARGET
        if not hand and r.draft.values[i] != r.values[i]:
            return True
    return False


@internal
def begin(r: LoopArrays, position: float) -> None:
    """Start at full parameters: the first block is not a change."""
    r.word[arrays.STARTED] = 1
    estimators.reset(r.memory, position)
    r.real[arrays.LAST_POSITION] = position
    enter(r, r.word[arrays.SLOT], True)
    r.real[arrays.BLEND] = 1.0


@internal
def other_form(r: LoopArrays) -> bool:
    """Return whether the new block has another law or another choice than the one in force."""
    slot = r.word[arrays.SLOT]
    if r.words[block.LAW] != r.laws[slot]:
        return True
    mask = r.words[block.DISCRETE]
    for i in range(r.words[block.N_PARAMS]):
        if (mask >> i) & 1 and r.values[block.PARAMS + i] != r.params[slot, i]:
            return True
    return False


@internal
def other_numbers(r: LoopArrays) -> bool:
    """Return whether a number has another goal than the one it ramps to."""
    for i in range(r.words[block.N_PARAMS]):
        if r.values[block.PARAMS + i] != r.goal[i]:
            return True
    return False


@internal
def switch(r: LoopArrays) -> None:
    """Put the new form into the other slot and begin to fade over to it; a kept law keeps its state."""
    old = r.word[arrays.SLOT]
    new = 1 - old
    fresh = r.words[block.LAW] != r.laws[old]
    if not fresh:
        for i in range(rows.STATES):
            r.states[new, i] = r.states[old, i]
    r.word[arrays.SLOT] = new
    enter(r, new, fresh)
    r.real[arrays.BLEND] = 0.0


@internal
def enter(r: LoopArrays, slot: int, fresh: bool) -> None:
    """Load law, parameters and, for a fresh law, its first state into a slot."""
    r.laws[slot] = r.words[block.LAW]
    for i in range(r.words[block.N_PARAMS]):
        r.params[slot, i] = r.values[block.PARAMS + i]
        r.goal[i] = r.values[block.PARAMS + i]
    if fresh:
        restore(r, slot)
    r.real[arrays.RAMP] = 1.0


@internal
def restore(r: LoopArrays, slot: int) -> None:
    """Give a slot its law's first state."""
    for i in range(rows.STATES):
        r.states[slot, i] = r.values[block.INITIAL_STATE + i]


@internal
def advanced(share: float, step: float) -> float:
    """Return a share moved on towards 1; what rounding leaves to do is done."""
    share += step
    return share if share < 1.0 - _ROUNDING else 1.0


@internal
def move(r: LoopArrays, step: float) -> None:
    """Move the ramp of the numbers and the cross-fade by a step, a share of the whole."""
    real = r.real
    if real[arrays.RAMP] < 1.0:
        ramp = advanced(real[arrays.RAMP], step)
        real[arrays.RAMP] = ramp
        slot = r.word[arrays.SLOT]
        for i in range(r.words[block.N_PARAMS]):
            goal, start = r.goal[i], r.start[i]
            r.params[slot, i] = goal if ramp >= 1.0 else start + (goal - start) * ramp
    if real[arrays.BLEND] < 1.0:
        real[arrays.BLEND] = advanced(real[arrays.BLEND], step)


@internal
def clear_fault(r: LoopArrays) -> None:
    """Forget a latched fault; the law starts from its first state, the force fades in from zero."""
    if load_acquire(r.control, arrays.FAULT) == arrays.NO_FAULT:
        return
    r.fault[0] = 0
    r.fault[1] = 0
    restore(r, r.word[arrays.SLOT])
    r.real[arrays.BLEND] = 1.0
    r.real[arrays.GAIN] = 0.0
    store_release(r.control, arrays.FAULT, arrays.NO_FAULT)


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
    r.word[arrays.STALE] = 1 + cause
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
def note_law_time(r: LoopArrays, now: float, spent: float, limit: float, ticks: int) -> bool:
    """Take the processor time in s that some ticks took; latch a law that takes longer than a limit each.

    now: s by any clock that goes on meanwhile. Return whether the law is latched by this call.
    """
    real, each = r.real, spent / ticks
    if each <= limit:
        return False
    if now - spent - real[arrays.OVERRUN_SINCE] > OVERRUN_WINDOW:
        real[arrays.OVERRUN_SINCE], real[arrays.OVERRUN] = now, 0.0
    before = real[arrays.OVERRUN]
    real[arrays.OVERRUN] = before + spent
    often = before > 0.0 and before + spent >= MOST_OVERRUN
    if not (often or spent >= MOST_ONCE) or load_acquire(r.control, arrays.FAULT) != arrays.NO_FAULT:
        return False
    r.word[arrays.SLOW] = r.laws[r.word[arrays.SLOT]]
    latch(r, arrays.SLOW_LAW, each, limit)
    return True


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
def guard(
    r: LoopArrays, asked: float, taken: float, velocity: float, position: float, period: float
) -> float:
    """Return the force in N that may reach the motor: the last line before it. Sets the row's flags.

    taken, the passivity controller's, comes off what the motor can give: off a force beyond that it would do
    nothing.
    """
    real = r.real
    if not math.isfinite(asked - taken) or r.fault[0]:
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
    gain = real[arrays.GAIN]
    if gain < 1.0:
        gain = advanced(gain, min(period, r.values[block.PERIOD]) / r.values[block.FADE])
        real[arrays.GAIN] = gain
        asked, taken = gain * asked, gain * taken
    if gain < 1.0 or real[arrays.BLEND] < 1.0:
        flags |= rows.FADING
    limit = r.values[block.MAX_FORCE]
    if abs(asked) > limit:
        flags |= rows.CLAMPED
        asked = math.copysign(limit, asked)
    r.word[arrays.FLAGS] = flags
    return min(max(asked - taken, -limit), limit)


@inlined_and_called
def tick(r: LoopArrays, position: float, period: float, effect: float, row: np.ndarray) -> float:
    """Render one sample; fill the row's columns that the tick knows; return the force for the motor in N.

    effect is the mean force in N in effect since the last sample; the driver fills times and truth, truth
    before the tick where the block asks for the true velocity.
    """
    real, word = r.real, r.word
    if due(r):
        refresh(r, position, period)
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
    force = guard(r, asked, taken, velocity, position, period)
    passivity.judge(r, taken, position, period, row)
    real[arrays.ENERGY] += effect * (position - real[arrays.LAST_POSITION])
    real[arrays.LAST_POSITION] = position
    real[arrays.APPLIED] = force
    real[arrays.VELOCITY] = velocity
    row[rows.TICK] = word[arrays.TICK]
    word[arrays.TICK] += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = velocity
    row[rows.FORCE] = asked
    row[rows.APPLIED_FORCE] = force
    row[rows.ENERGY] = real[arrays.ENERGY]
    row[rows.FLAGS] = word[arrays.FLAGS]
    row[rows.PERIOD] = period
    slot = word[arrays.SLOT]
    for i in range(rows.STATES):
        row[rows.STATE + i] = r.states[slot, i]
    return force


@inlined
def live_tick(r: LoopArrays, position: float, period: float, effect: float, row: np.ndarray) -> float:
    """Render one sample as ``tick`` does, and measure its law: one that is too slow gives no force.

    While two laws cross-fade they have a period each. What counts is processor time that the law's turns
    explain: a thread that had to wait for a processor has a slow machine, not a slow law.
    """
    r.word[arrays.CALLS] = 0
    used, begun = clock.thread_time(), clock.now()
    limit = r.values[block.PERIOD] * (1.0 if r.real[arrays.BLEND] >= 1.0 else 2.0)
    force = tick(r, position, period, effect, row)
    done = clock.now()
    spent = done - begun
    if spent > _SUSPECT * limit:
        turns = FUEL - r.fault[1] if r.fault[0] == 0 else FUEL
        explained = LONGEST_TURN * (1 + turns) * (1 + r.word[arrays.CALLS])
        spent = min(spent, clock.thread_time() - used, explained)
    r.real[arrays.LAW_TIME] = spent / (1 + r.word[arrays.CALLS])
    if note_law_time(r, done, spent, limit, 1):
        r.word[arrays.FLAGS] |= rows.FAULT
        row[rows.FLAGS] = r.word[arrays.FLAGS]
        row[rows.APPLIED_FORCE] = r.real[arrays.APPLIED] = r.real[arrays.GAIN] = force = 0.0
    return force

"""The tick computes a force from a position; live loops, headless runs and sweeps call it.

    position -> velocity estimate -> law -> passivity -> fade -> safety -> motor command -> telemetry row

The passivity controller's force is subtracted from the clamped force, and the result is clamped again.

New settings are adopted inside the tick: numbers ramp, choices and laws cross-fade.
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
"""s: limits of processor time.

A law latches a fault if two or more calls longer than a period take MOST_OVERRUN in total within
OVERRUN_WINDOW, or if one call takes MOST_ONCE. A single call may take some ms if the kernel must clear a
page.
"""
LONGEST_TURN = 20e-6
"""Largest processor time in s of a loop iteration of a law, and of the rest of a call: about 1,000 sines.

A longer time is not attributed to the law: on a shared processor, the measured time may include that of other
threads, 4 ms at once.
"""
# fraction of a period: the processor time is read only after a tick that took longer than this by the wall
# clock
_SUSPECT = 0.1
_ROUNDING = 1e-9


@internal
def due(r: LoopArrays) -> bool:
    """Return True if ``refresh`` has work to do, which is rarely the case."""
    if load_acquire(r.block.sequence, 0) != r.sequence[0]:
        return True
    if load_acquire(r.control.clear, 0) != r.tick.cleared:
        return True
    moving = r.tick.ramp < 1.0 or r.tick.blend < 1.0
    return moving or r.tick.generation != r.settings.generation


@internal
def refresh(r: LoopArrays, position: float, period: float) -> None:
    """Read a newer block, advance ramp and cross-fade by a period, and clear a fault on request."""
    if load_acquire(r.block.sequence, 0) != r.sequence[0]:
        adopt(r, position)
    t = r.tick
    if t.ramp < 1.0 or t.blend < 1.0:
        move(r, period / r.settings.fade)
    elif r.tick.generation != r.settings.generation:
        r.tick.generation = r.settings.generation
        store_release(r.control.accepted, 0, r.settings.generation)
    cleared = load_acquire(r.control.clear, 0)
    if cleared != r.tick.cleared:
        r.tick.cleared = cleared
        clear_fault(r)


@compiled
def adopt(r: LoopArrays, position: float) -> None:
    """Adopt a new block; during a cross-fade the block waits, and the newest one is adopted afterwards."""
    t = r.tick
    if t.blend < 1.0 and t.started:
        return
    if not block.take(r.block, r.draft):
        return
    estimator = r.settings.estimator
    if t.started and other_loop(r):
        r.watch.renew = 1
    block.copy(r.draft, Block(r.sequence, r.settings, r.program))
    r.sequence[0] = r.draft.sequence[0]
    if not t.started:
        begin(r, position)
        return
    if r.settings.estimator != estimator:
        estimators.resume(r.memory, t.last_position, t.velocity)
    if other_form(r):
        switch(r)
    elif other_numbers(r):
        slot = t.slot
        for i in range(r.settings.n_params):
            r.start[i] = r.params[slot, i]
            r.goal[i] = r.settings.params[i]
        t.ramp = 0.0


@internal
def other_loop(r: LoopArrays) -> bool:
    """Return True if the new block changes the loop or the device."""
    new, old = r.draft.settings, r.settings
    for i in range(estimators.COEFFICIENTS):
        if new.coefs[i] != old.coefs[i]:
            return True
    loop = new.estimator != old.estimator or new.period != old.period or new.delay != old.delay
    limits = new.max_force != old.max_force or new.max_speed != old.max_speed or new.fade != old.fade
    device = new.viscous != old.viscous or new.coulomb != old.coulomb or new.quantum != old.quantum
    board = new.board_first != old.board_first or new.board_second != old.board_second
    return loop or limits or device or board or new.damper != old.damper


@internal
def begin(r: LoopArrays, position: float) -> None:
    """Start with the first block's parameters at once, without a ramp."""
    r.tick.started = 1
    estimators.reset(r.memory, position)
    r.tick.last_position = position
    enter(r, r.tick.slot, True)
    r.tick.blend = 1.0


@internal
def other_form(r: LoopArrays) -> bool:
    """Return True if the new block changes the law or a choice."""
    slot = r.tick.slot
    if r.settings.law != r.laws[slot]:
        return True
    mask = r.settings.discrete
    for i in range(r.settings.n_params):
        if (mask >> i) & 1 and r.settings.params[i] != r.params[slot, i]:
            return True
    return False


@internal
def other_numbers(r: LoopArrays) -> bool:
    """Return True if a parameter's target differs from the target of its current ramp."""
    for i in range(r.settings.n_params):
        if r.settings.params[i] != r.goal[i]:
            return True
    return False


@internal
def switch(r: LoopArrays) -> None:
    """Put the new law and choices into the other slot and start a cross-fade.

    An unchanged law keeps its state.
    """
    old = r.tick.slot
    new = 1 - old
    fresh = r.settings.law != r.laws[old]
    if not fresh:
        for i in range(rows.STATES):
            r.states[new, i] = r.states[old, i]
    r.tick.slot = new
    enter(r, new, fresh)
    r.tick.blend = 0.0


@internal
def enter(r: LoopArrays, slot: int, fresh: bool) -> None:
    """Load law and parameters into a slot, and also the initial state if ``fresh`` is true."""
    r.laws[slot] = r.settings.law
    for i in range(r.settings.n_params):
        r.params[slot, i] = r.settings.params[i]
        r.goal[i] = r.settings.params[i]
    if fresh:
        restore(r, slot)
    r.tick.ramp = 1.0


@internal
def restore(r: LoopArrays, slot: int) -> None:
    """Set a slot's state to the initial state of its law."""
    for i in range(rows.STATES):
        r.states[slot, i] = r.settings.initial_state[i]


@internal
def advanced(share: float, step: float) -> float:
    """Return a progress increased by a step; if it reaches 1 apart from rounding, return exactly 1."""
    share += step
    return share if share < 1.0 - _ROUNDING else 1.0


@internal
def move(r: LoopArrays, step: float) -> None:
    """Advance the parameters' ramp and the cross-fade by ``step``, as a fraction of their duration."""
    t = r.tick
    if t.ramp < 1.0:
        ramp = advanced(t.ramp, step)
        t.ramp = ramp
        slot = r.tick.slot
        for i in range(r.settings.n_params):
            goal, start = r.goal[i], r.start[i]
            r.params[slot, i] = goal if ramp >= 1.0 else start + (goal - start) * ramp
    if t.blend < 1.0:
        t.blend = advanced(t.blend, step)


@internal
def clear_fault(r: LoopArrays) -> None:
    """Clear a latched fault; the law restarts from its initial state, and the force fades in from zero."""
    if load_acquire(r.control.fault, 0) == arrays.NO_FAULT:
        return
    r.fault[0] = 0
    r.fault[1] = 0
    restore(r, r.tick.slot)
    r.tick.blend = 1.0
    r.tick.gain = 0.0
    store_release(r.control.fault, 0, arrays.NO_FAULT)


@internal
def render(r: LoopArrays, position: float, velocity: float, period: float) -> float:
    """Return the law's force in N; during a cross-fade, the weighted mean of both laws."""
    t = r.tick
    slot = r.tick.slot
    asked = call(r.laws[slot], r.params[slot], r.states[slot], position, velocity, period, r.fault)
    blend = t.blend
    if blend < 1.0 and math.isfinite(asked):
        old = 1 - slot
        before = call(r.laws[old], r.params[old], r.states[old], position, velocity, period, r.fault)
        asked = blend * asked + (1.0 - blend) * before
    return asked


@compiled
def latch(r: LoopArrays, code: int, value: float, position: float) -> None:
    """Latch a fault; only the first fault is stored until it is cleared."""
    if load_acquire(r.control.fault, 0) == arrays.NO_FAULT:
        r.tick.fault_value = value
        r.tick.fault_position = position
        store_release(r.control.fault, 0, code)


@compiled
def mark_stale(r: LoopArrays, now: float, cause: int) -> None:
    """Mark the sensor stale: the force is zero from now on. The third time in ten seconds latches a fault."""
    t = r.tick
    t.good = 0.0
    if r.tick.stale:
        return
    r.tick.stale = 1 + cause
    t.gain = 0.0
    t.applied = 0.0
    count = load_acquire(r.control.stale_count, 0)
    t.stale_times[count % 3] = now
    if count >= 2 and now - t.stale_times[(count + 1) % 3] <= STALE_WINDOW:
        latch(r, arrays.STALE_SENSOR, cause, t.last_position)
    store_release(r.control.stale_causes, cause, r.control.stale_causes[cause] + 1)
    store_release(r.control.stale_count, 0, count + 1)


@compiled
def note_law_time(r: LoopArrays, now: float, spent: float, limit: float, ticks: int) -> bool:
    """Record the processor time in s of some ticks; latch a fault if a law's calls are too long.

    ``limit`` is the permitted processor time of a tick in s. ``now`` is the current time in s; any clock that
    runs all the time is suitable. Return True if this call latches the fault.
    """
    t, each = r.tick, spent / ticks
    if each <= limit:
        return False
    if now - spent - t.overrun_since > OVERRUN_WINDOW:
        t.overrun_since, t.overrun = now, 0.0
    before = t.overrun
    t.overrun = before + spent
    often = before > 0.0 and before + spent >= MOST_OVERRUN
    if not (often or spent >= MOST_ONCE) or load_acquire(r.control.fault, 0) != arrays.NO_FAULT:
        return False
    r.tick.slow_law = r.laws[r.tick.slot]
    latch(r, arrays.SLOW_LAW, each, limit)
    return True


@internal
def recover(r: LoopArrays, period: float) -> None:
    """Add up the time with good frames after a gap; after RECOVER_AFTER the force fades in again."""
    t = r.tick
    t.good += min(period, r.settings.period)
    if t.good >= RECOVER_AFTER:
        r.tick.stale = 0


@internal
def blocked(r: LoopArrays, period: float) -> int:
    """Return the row flags of the reasons for zero force: E-stop, fault, stale sensor, start-up phase."""
    flags = 0
    if load_acquire(r.control.stop, 0):
        flags |= rows.STOPPED
    if load_acquire(r.control.fault, 0):
        flags |= rows.FAULT
    if r.tick.stale:
        recover(r, period)
        flags |= rows.STALE
    return flags


@internal
def guard(
    r: LoopArrays, asked: float, taken: float, velocity: float, position: float, period: float
) -> float:
    """Return the force in N that may reach the motor, and set the row's flags; this is the last check.

    ``taken`` is the force of the passivity controller. It is subtracted after clamping, because otherwise it
    would have no effect on a force beyond the motor's limit.
    """
    t = r.tick
    if not math.isfinite(asked - taken) or r.fault[0]:
        latch(r, max(r.fault[0], arrays.NOT_A_NUMBER), asked, position)
    if abs(velocity) > r.settings.max_speed:
        latch(r, arrays.OVER_SPEED, velocity, position)
    flags = blocked(r, period)
    if t.zero_force_left > 0.0:
        t.zero_force_left -= period
        flags |= rows.FADING
    if flags:
        t.gain = 0.0
        r.tick.row_flags = flags
        return 0.0
    gain = t.gain
    if gain < 1.0:
        gain = advanced(gain, min(period, r.settings.period) / r.settings.fade)
        t.gain = gain
        asked, taken = gain * asked, gain * taken
    if gain < 1.0 or t.blend < 1.0:
        flags |= rows.FADING
    limit = r.settings.max_force
    if abs(asked) > limit:
        flags |= rows.CLAMPED
        asked = math.copysign(limit, asked)
    r.tick.row_flags = flags
    return min(max(asked - taken, -limit), limit)


@inlined_and_called
def tick(r: LoopArrays, position: float, period: float, effect: float, row: np.ndarray) -> float:
    """Render one sample, fill in the columns that the tick computes, and return the motor force in N.

    ``effect`` is the mean motor force in N since the last sample. The driver fills in the times and the
    true motion. If the block requests the true velocity, the driver must fill in the true motion before it
    calls the tick.
    """
    t = r.tick
    if due(r):
        refresh(r, position, period)
    code = r.settings.estimator
    if code == block.TRUTH:
        velocity = row[rows.TRUE_VELOCITY]
    else:
        velocity = estimators.step(code, r.settings.coefs, r.memory, position, period)
    passivity.watch(r, position, effect, period)
    asked = 0.0
    if load_acquire(r.control.fault, 0) == arrays.NO_FAULT:
        asked = render(r, position, velocity, period)
    taken = passivity.control(r, period)
    force = guard(r, asked, taken, velocity, position, period)
    passivity.judge(r, taken, position, period, row)
    t.energy += effect * (position - t.last_position)
    t.last_position = position
    t.applied = force
    t.velocity = velocity
    row[rows.TICK] = t.number
    t.number += 1
    row[rows.POSITION] = position
    row[rows.VELOCITY] = velocity
    row[rows.FORCE] = asked
    row[rows.APPLIED_FORCE] = force
    row[rows.ENERGY] = t.energy
    row[rows.FLAGS] = t.row_flags
    row[rows.PERIOD] = period
    slot = t.slot
    for i in range(rows.STATES):
        row[rows.STATE + i] = r.states[slot, i]
    return force


@inlined
def live_tick(r: LoopArrays, position: float, period: float, effect: float, row: np.ndarray) -> float:
    """Render one sample like ``tick``, and measure the law's duration; a law that is too slow is a fault.

    During a cross-fade, each of the two laws may take a period. The measured time is reduced to the longest
    time that the law's number of loop iterations can take. A longer time means that the machine is slow: for
    example, the thread waited for a processor.
    """
    r.watch.calls = 0
    used, begun = clock.thread_time(), clock.now()
    limit = r.settings.period * (1.0 if r.tick.blend >= 1.0 else 2.0)
    force = tick(r, position, period, effect, row)
    done = clock.now()
    spent = done - begun
    if spent > _SUSPECT * limit:
        turns = FUEL - r.fault[1] if r.fault[0] == 0 else FUEL
        explained = LONGEST_TURN * (1 + turns) * (1 + r.watch.calls)
        spent = min(spent, clock.thread_time() - used, explained)
    r.tick.law_time = spent / (1 + r.watch.calls)
    if note_law_time(r, done, spent, limit, 1):
        r.tick.row_flags |= rows.FAULT
        row[rows.FLAGS] = r.tick.row_flags
        row[rows.APPLIED_FORCE] = r.tick.applied = r.tick.gain = force = 0.0
    return force

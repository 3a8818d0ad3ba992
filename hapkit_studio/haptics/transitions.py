"""How new settings come into force inside the tick: numbers ramp, choices and laws cross-fade."""

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics import arrays, block, rows
from hapkit_studio.haptics.arrays import LoopArrays
from hapkit_studio.haptics.fences import load_acquire, store_release

_ROUNDING = 1e-9


@internal
def due(r: LoopArrays) -> bool:
    """Return whether ``refresh`` has anything to do; at nearly every tick it has not."""
    if load_acquire(r.block_words, block.SEQUENCE) != r.words[block.SEQUENCE]:
        return True
    if load_acquire(r.control, arrays.CLEAR) != r.word[arrays.CLEARED]:
        return True
    moving = r.real[arrays.RAMP] < 1.0 or r.real[arrays.BLEND] < 1.0
    return moving or r.word[arrays.GENERATION] != r.words[block.GENERATION]


@internal
def refresh(r: LoopArrays, position: float, period: float) -> None:
    """Take a newer block, move ramp and cross-fade on by a period, obey a cleared fault."""
    if load_acquire(r.block_words, block.SEQUENCE) != r.words[block.SEQUENCE]:
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
    if not block.take(
        r.block_values, r.block_words, r.block_program, r.draft_values, r.draft_words, r.draft_program
    ):
        return
    estimator = r.words[block.ESTIMATOR]
    if word[arrays.STARTED] and other_loop(r):
        word[arrays.RENEW] = 1
    block.copy(r.draft_values, r.draft_words, r.draft_program, r.values, r.words, r.program)
    r.words[block.SEQUENCE] = r.draft_words[block.SEQUENCE]
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
    if r.draft_words[block.ESTIMATOR] != r.words[block.ESTIMATOR]:
        return True
    for i in range(block.COEFS, block.VALUES):
        hand = block.HAND_MASS <= i <= block.HAND_TARGET
        if not hand and r.draft_values[i] != r.values[i]:
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


@compiled
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

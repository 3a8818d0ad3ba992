"""The arrays one running loop works on, and the words it shares with the window."""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics import block
from hapkit_studio.laws import native

# --- real: the tick's own numbers
GAIN = 0
RAMP = 1
BLEND = 2
LAST_POSITION = 3
ENERGY = 4
APPLIED = 5
HOLD = 6
GOOD = 7
STALE_TIMES = 8
FAULT_VALUE = 11
FAULT_POSITION = 12
CLOCK = 13
VELOCITY = 14
REAL = 16
WATCH = 1344

# --- word: the tick's own whole numbers
SLOT = 0
STARTED = 1
TICK = 2
STALE = 3
CLEARED = 4
FLAGS = 5
GENERATION = 6
ASKED = 7
RENEW = 8
LONG = 9  # samples in a row whose law took longer than a period
SPARE = 10  # a fault's words, where the observer asks a law
WORD = SPARE + native.FAULT_WORDS

# --- control: shared with the window, one cache line each
STRIDE = 8
QUIT = 0 * STRIDE
STOP = 1 * STRIDE
CLEAR = 2 * STRIDE
HEAD = 3 * STRIDE
FAULT = 4 * STRIDE
ACCEPTED = 5 * STRIDE
MISSED = 6 * STRIDE
STALE_COUNT = 7 * STRIDE
LOST_FRAMES = 8 * STRIDE
CRC_ERRORS = 9 * STRIDE
DONE = 10 * STRIDE
ZERO = 11 * STRIDE
FLIP = 12 * STRIDE
STALE_CAUSES = 13 * STRIDE  # how often each of CAUSES stopped the force
STALE_FORCES = 14 * STRIDE  # those that the board refused as too old
BOARD_ERRORS = 15 * STRIDE  # frames that the board could not read
CONTROL = 16 * STRIDE

# a law's own codes, and the loop's between them
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL = native.NOT_A_NUMBER, native.LAW_INDEX, native.LAW_FUEL
LAW_DIVISION = native.LAW_DIVISION
NO_FAULT, OVER_SPEED, STALE_SENSOR, DEVICE_GONE, RUNAWAY = 0, 4, 5, 6, 7
SLOW_LAW, SLOW_LINK = 9, 10

# why the force went to zero for a while: the line brought no sample, the computer was away or the law held it
# up, the board switched its motor off although it was answered
CAUSES = NO_SAMPLE, AWAY, HELD_UP, CUT = range(4)


class LoopArrays(NamedTuple):
    """Everything the tick reads and writes; plain arrays, allocated once."""

    real: np.ndarray
    word: np.ndarray
    params: np.ndarray  # (2, 32): one row a slot, what each law reads now
    start: np.ndarray  # (32,): where the ramp of the numbers began
    goal: np.ndarray  # (32,): where it ends
    states: np.ndarray  # (2, 16): one row a slot
    laws: np.ndarray  # (2,): addresses
    memory: np.ndarray  # the velocity estimator's
    fault: np.ndarray  # (native.FAULT_WORDS,), set by laws
    watch: np.ndarray  # the passivity observer's
    energies: np.ndarray  # (n, 2), n a power of two: given and limit in J of the last n ticks, nan where none
    values: np.ndarray  # the block in force
    words: np.ndarray
    program: np.ndarray  # the law for the board, packed
    draft_values: np.ndarray  # the block being read, perhaps torn
    draft_words: np.ndarray
    draft_program: np.ndarray
    block_values: np.ndarray  # the block as the window writes it
    block_words: np.ndarray
    block_program: np.ndarray
    control: np.ndarray


def new_arrays(
    block_values: np.ndarray, block_words: np.ndarray, block_program: np.ndarray, energies: int = 1
) -> LoopArrays:
    """Return arrays at rest that read their settings from the given block and keep so many energies."""
    values, words, program = block.new_block()
    draft_values, draft_words, draft_program = block.new_block()
    return LoopArrays(
        real=np.zeros(REAL),
        word=np.zeros(WORD, dtype=np.int64),
        params=np.zeros((2, block.INITIAL_STATE)),
        start=np.zeros(block.INITIAL_STATE),
        goal=np.zeros(block.INITIAL_STATE),
        states=np.zeros((2, block.STATES)),
        laws=np.zeros(2, dtype=np.int64),
        memory=np.zeros(estimators.MEMORY),
        fault=np.zeros(native.FAULT_WORDS, dtype=np.int64),
        watch=np.zeros(WATCH),
        energies=np.full((energies, 2), np.nan),
        values=values,
        words=words,
        program=program,
        draft_values=draft_values,
        draft_words=draft_words,
        draft_program=draft_program,
        block_values=block_values,
        block_words=block_words,
        block_program=block_program,
        control=np.zeros(CONTROL, dtype=np.int64),
    )


def restart(r: LoopArrays, hold_seconds: float) -> None:
    """Bring the tick back to its start before a loop runs: settings afresh, the force fades in from zero.

    hold_seconds of zero force come first. E-stop and latched faults stay, but for the device's own going
    away; counts go on.
    """
    if r.control[FAULT] == DEVICE_GONE:
        r.control[FAULT] = NO_FAULT
    reason = r.real[FAULT_VALUE : FAULT_POSITION + 1].copy()
    r.real[:] = 0.0
    r.real[FAULT_VALUE : FAULT_POSITION + 1] = reason
    r.real[BLEND] = r.real[RAMP] = 1.0
    r.real[HOLD] = hold_seconds
    ticks = r.word[TICK]
    r.word[:] = 0
    r.word[TICK] = ticks
    r.word[CLEARED] = r.control[CLEAR]
    r.words[:] = 0
    if r.control[FAULT] == NO_FAULT:
        r.fault[:] = 0
    r.control[QUIT] = r.control[DONE] = 0

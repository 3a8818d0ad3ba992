"""The arrays one running loop works on, and the words it shares with the window."""

from typing import NamedTuple

import numpy as np

from hapkit_studio import interrupts
from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.laws import native

# --- real: the tick's own numbers; of STALE_TIMES there are three
GAIN, RAMP, BLEND, LAST_POSITION, ENERGY, APPLIED, HOLD, GOOD, STALE_TIMES = range(9)
FAULT_VALUE, FAULT_POSITION, CLOCK, VELOCITY = range(11, 15)
# s: a call of the law took lately, in live loops; laws longer than a period have taken since OVERRUN_SINCE
LAW_TIME, OVERRUN, OVERRUN_SINCE = range(15, 18)
LOOKED_AT = 18  # s of processor time: when a headless run looked at the clock last, 0 before the first time
REAL = 19
WATCH = 1344

# --- word: the tick's own whole numbers; STALE: 1 + the cause, 0 while samples come
SLOT, STARTED, TICK, STALE, CLEARED, FLAGS, GENERATION, ASKED, RENEW = range(9)
SLOW = 9  # the address of the law that was too slow
CALLS, OPAQUE = 10, 11  # the observer's calls of the law in this tick; the law takes too long to be asked
# of a headless run: ticks, and work in passes of loops, since it looked last; the socket that signals come to
TICKS_DONE, WORK_DONE, SIGNALS = range(12, 15)
SPARE = 15  # a fault's words, where the observer asks a law
WORD = SPARE + native.FAULT_WORDS

# --- control: shared with the window, one cache line each
CONTROL, STRIDE = 128, 8
QUIT, STOP, CLEAR, HEAD, FAULT, ACCEPTED, MISSED, STALE_COUNT = range(0, 64, STRIDE)
LOST_FRAMES, CRC_ERRORS, DONE, ZERO, FLIP = range(64, 104, STRIDE)
STALE_CAUSES = 104  # how often each of CAUSES stopped the force; of CLOCK_JUMP how often it happened
STALE_FORCES = 112  # those that the board refused as too old
BOARD_ERRORS = 120  # frames that the board could not read

# a law's own codes, and the loop's between them
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL = native.NOT_A_NUMBER, native.LAW_INDEX, native.LAW_FUEL
LAW_DIVISION = native.LAW_DIVISION
NO_FAULT, OVER_SPEED, STALE_SENSOR, DEVICE_GONE, RUNAWAY = 0, 4, 5, 6, 7
SLOW_LAW, SLOW_LINK = 9, 10

# why the force went to zero for a while: the line brought no sample, the computer was away or the law held it
# up, the board switched its motor off although it was answered, its clock jumped
CAUSES = NO_SAMPLE, AWAY, HELD_UP, CUT, CLOCK_JUMP = range(5)


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
    values: np.ndarray  # the block in force
    words: np.ndarray
    program: np.ndarray  # the law for the board, packed
    draft: Block  # the block being read, perhaps torn
    block: Block  # the block as the window writes it
    control: np.ndarray


def new_arrays(shared: Block) -> LoopArrays:
    """Return arrays at rest that read their settings from the given block."""
    word = np.zeros(WORD, dtype=np.int64)
    word[SIGNALS] = interrupts.fileno()
    return LoopArrays(
        real=np.zeros(REAL),
        word=word,
        params=np.zeros((2, block.INITIAL_STATE)),
        start=np.zeros(block.INITIAL_STATE),
        goal=np.zeros(block.INITIAL_STATE),
        states=np.zeros((2, block.STATES)),
        laws=np.zeros(2, dtype=np.int64),
        memory=np.zeros(estimators.MEMORY),
        fault=np.zeros(native.FAULT_WORDS, dtype=np.int64),
        watch=np.zeros(WATCH),
        **block.new_block()._asdict(),
        draft=block.new_block(),
        block=shared,
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
    ticks, slow = r.word[TICK], r.word[SLOW]
    r.word[:] = 0
    r.word[TICK], r.word[SLOW] = ticks, slow
    r.word[CLEARED] = r.control[CLEAR]
    r.words[:] = 0
    if r.control[FAULT] == NO_FAULT:
        r.fault[:] = 0
    r.control[QUIT] = r.control[DONE] = 0

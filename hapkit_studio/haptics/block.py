"""The parameter block: how settings reach the loop. One writer, one reader, neither ever waits.

A seqlock: the sequence word is odd while the writer is at work; the reader copies, looks again, and where
the word has moved simply tries at its next tick. The newest block wins.
"""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics.clib import fence, load_acquire, store_release

# --- values
PARAMS = 0
INITIAL_STATE = 32
STATES = 16  # numbers that a law may keep
COEFS = INITIAL_STATE + STATES
PERIOD, DELAY, MAX_FORCE, MAX_SPEED, FADE = range(56, 61)
HAND_MASS, HAND_DAMPING, HAND_STIFFNESS, HAND_TARGET = range(61, 65)
VISCOUS, COULOMB, QUANTUM, DAMPER = range(65, 69)
BOARD_FIRST, BOARD_SECOND = 69, 70  # the board's estimator: its coefficients
VALUES = 71

# --- words; STORED: the law that says what objects hold, 0 where there is none
SEQUENCE, LAW, N_PARAMS, N_STATE, DISCRETE, ESTIMATOR, GENERATION, HAND_ON, STORED = range(9)
# what the board is to render
CODE_ID = 9  # all of its law, rate and estimator but constants, 0: the computer renders
PROGRAM_ID = 10  # the law's bytes, constants included; equal where they are equal
BOARD_LAW = 11  # the law that it is, by its address here
BOARD_PERIOD, BOARD_ESTIMATOR, BOARD_STATES, BOARD_GIVEN = range(12, 16)
BOARD_SLOTS, BOARD_CODE, BOARD_CHECK = range(16, 19)
BOARD_MOVING = 19  # constants that the board has room to move at a time
RELEASES = 20  # how often the handle was let go at rest
WORDS = 21

PROGRAM_WORDS = 256
"""int64 words of the law for the board: 2,048 bytes, all the memory that an ATmega328P has."""

# In place of an estimator's code: the velocity is the one the driver put into the row, without an estimate.
TRUTH = -1
# In place of a program's number: half of it is another one's.
TORN = -1


class Block(NamedTuple):
    """float64 values, int64 words, and the law for the board packed into int64 words."""

    values: np.ndarray
    words: np.ndarray
    program: np.ndarray


def new_block() -> Block:
    """Return an empty block."""
    return Block(np.zeros(VALUES), np.zeros(WORDS, np.int64), np.zeros(PROGRAM_WORDS, np.int64))


@internal
def copy(source: Block, to: Block) -> None:
    """Copy a block's content, all but its sequence; the law for the board where it is another one."""
    if to.words[PROGRAM_ID] != source.words[PROGRAM_ID]:
        for i in range(PROGRAM_WORDS):
            to.program[i] = source.program[i]
    for i in range(VALUES):
        to.values[i] = source.values[i]
    for i in range(LAW, WORDS):
        to.words[i] = source.words[i]


@compiled
def publish(block: Block, new: Block) -> None:
    """Replace the block's content."""
    sequence = block.words[SEQUENCE]
    store_release(block.words, SEQUENCE, sequence + 1)
    fence()
    copy(new, block)
    fence()
    store_release(block.words, SEQUENCE, sequence + 2)


@compiled
def take(block: Block, to: Block) -> bool:
    """Copy the block; return whether it was whole. What a torn copy holds may not be used."""
    sequence = load_acquire(block.words, SEQUENCE)
    if sequence & 1:
        return False
    copy(block, to)
    to.words[SEQUENCE] = sequence
    fence()
    if load_acquire(block.words, SEQUENCE) == sequence:
        return True
    to.words[PROGRAM_ID] = TORN
    return False

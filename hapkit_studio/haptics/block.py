"""The parameter block: how settings reach the loop. One writer, one reader, neither ever waits.

A seqlock: the sequence word is odd while the writer is at work; the reader copies, looks again, and where
the word has moved simply tries at its next tick. The newest block wins.
"""

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.haptics.fences import fence, load_acquire, store_release

PARAMS = 0
INITIAL_STATE = 32
STATES = 16  # numbers that a law may keep
COEFS = INITIAL_STATE + STATES
PERIOD = 56
DELAY = 57
MAX_FORCE = 58
MAX_SPEED = 59
FADE = 60
HAND_MASS = 61
HAND_DAMPING = 62
HAND_STIFFNESS = 63
HAND_TARGET = 64
VISCOUS = 65
COULOMB = 66
QUANTUM = 67
DAMPER = 68
BOARD_FIRST = 69  # the board's estimator: its coefficients
BOARD_SECOND = 70
VALUES = 71

SEQUENCE = 0
LAW = 1
N_PARAMS = 2
N_STATE = 3
DISCRETE = 4
ESTIMATOR = 5
GENERATION = 6
HAND_ON = 7
STORED = 8  # the law that says what objects hold, 0 where there is none
# what the board is to render
CODE_ID = 9  # all of its law, rate and estimator but constants, 0: the computer renders
PROGRAM_ID = 10  # the law's bytes, constants included; equal where they are equal
BOARD_LAW = 11  # the law that it is, by its address here
BOARD_RATE = 12
BOARD_ESTIMATOR = 13
BOARD_STATES = 14
BOARD_GIVEN = 15
BOARD_SLOTS = 16
BOARD_CODE = 17
BOARD_CHECK = 18
BOARD_MOVING = 19  # constants that the board has room to move at a time
WORDS = 20

PROGRAM_WORDS = 256
"""int64 words of the law for the board: 2,048 bytes, all the memory that an ATmega328P has."""

# In place of an estimator's code: the velocity is the one the driver put into the row, without an estimate.
TRUTH = -1
# In place of a program's number: half of it is another one's.
TORN = -1


def new_block() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return an empty block: float64 values, int64 words, the law for the board packed into int64 words."""
    return np.zeros(VALUES), np.zeros(WORDS, dtype=np.int64), np.zeros(PROGRAM_WORDS, dtype=np.int64)


@compiled
def copy(
    values: np.ndarray,
    words: np.ndarray,
    program: np.ndarray,
    to_values: np.ndarray,
    to_words: np.ndarray,
    to_program: np.ndarray,
) -> None:
    """Copy a block's content, all but its sequence; the law for the board where it is another one."""
    if to_words[PROGRAM_ID] != words[PROGRAM_ID]:
        for i in range(PROGRAM_WORDS):
            to_program[i] = program[i]
    for i in range(VALUES):
        to_values[i] = values[i]
    for i in range(LAW, WORDS):
        to_words[i] = words[i]


@compiled
def publish(
    values: np.ndarray,
    words: np.ndarray,
    program: np.ndarray,
    new_values: np.ndarray,
    new_words: np.ndarray,
    new_program: np.ndarray,
) -> None:
    """Replace the block's content."""
    sequence = words[SEQUENCE]
    store_release(words, SEQUENCE, sequence + 1)
    fence()
    copy(new_values, new_words, new_program, values, words, program)
    fence()
    store_release(words, SEQUENCE, sequence + 2)


@compiled
def take(
    values: np.ndarray,
    words: np.ndarray,
    program: np.ndarray,
    copy_values: np.ndarray,
    copy_words: np.ndarray,
    copy_program: np.ndarray,
) -> bool:
    """Copy the block; return whether it was whole. What a torn copy holds may not be used."""
    sequence = load_acquire(words, SEQUENCE)
    if sequence & 1:
        return False
    copy(values, words, program, copy_values, copy_words, copy_program)
    copy_words[SEQUENCE] = sequence
    fence()
    if load_acquire(words, SEQUENCE) == sequence:
        return True
    copy_words[PROGRAM_ID] = TORN
    return False

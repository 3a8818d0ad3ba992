"""The parameter block: how settings reach the loop. One writer, one reader, neither ever waits.

A seqlock: the sequence word is odd while the writer is at work; the reader copies, looks again, and where
the word has moved simply tries at its next tick. The newest block wins.
"""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics.clib import assign, fence, load_acquire, store_release
from hapkit_studio.haptics.record import Record, record, zeros

PARAMS, STATES = 32, 16  # numbers that a law may have, and keep

SETTINGS = record(
    ("params", "f8", PARAMS),  # the law's parameters
    ("initial_state", "f8", STATES),  # the law's
    ("coefs", "f8", estimators.COEFFICIENTS),  # of the velocity estimator
    ("period", "f8"),  # s
    ("delay", "f8"),  # s
    ("max_force", "f8"),  # N
    ("max_speed", "f8"),  # m/s
    ("fade", "f8"),  # s that a change takes
    ("viscous", "f8"),  # N·s/m, the device's own damping
    ("coulomb", "f8"),  # N, a simulated device's dry friction
    ("quantum", "f8"),  # m, a count of the sensor
    ("damper", "f8"),  # N·s/m that the passivity controller may add, 0: there is none
    ("board_first", "f8"),  # coefficients of the board's estimator
    ("board_second", "f8"),
    ("hand", "f8", 3),  # kg, N·s/m, N/m: mass, damping and stiffness of the simulated hand
    ("hand_target", "f8"),  # m
    ("law", "i8"),  # its address
    ("n_params", "i8"),
    ("n_state", "i8"),
    ("discrete", "i8"),  # bit i: parameter i is a choice, which cross-fades
    ("estimator", "i8"),  # a code of dynamics.estimators, or TRUTH
    ("generation", "i8"),  # counts the changes
    ("hand_on", "i8"),
    ("stored", "i8"),  # address of the law for the energy that objects hold, 0: there is none
    ("releases", "i8"),  # how often the simulated handle was let go at rest
    ("code_id", "i8"),  # the board's law, rate and estimator without constants, 0: the computer renders
    ("program_id", "i8"),  # the law's bytes, constants included; equal for equal bytes
    ("board_law", "i8"),  # address here of the law that the board renders
    ("board_form", "i8", 7),  # what the board is told of the law, in the order of link.PERIOD to link.CHECK
    ("board_moving", "i8"),  # constants that the board has room to change at a time
)

PROGRAM_WORDS = 256
"""int64 words of the law for the board: 2,048 bytes, all the memory that an ATmega328P has."""

# In place of an estimator's code: the velocity is the one the driver put into the row, without an estimate.
TRUTH = -1
# In place of a program's number: half of it is another one's.
TORN = -1


class Block(NamedTuple):
    """Settings, the law for the board packed into int64 words, and the seqlock's sequence number."""

    sequence: np.ndarray  # (1,) int64, shared between threads
    settings: Record  # of SETTINGS
    program: np.ndarray


def new_block() -> Block:
    """Return an empty block."""
    return Block(np.zeros(1, np.int64), zeros(SETTINGS), np.zeros(PROGRAM_WORDS, np.int64))


@internal
def copy(source: Block, to: Block) -> None:
    """Copy a block's content, all but its sequence; the law for the board where it is another one."""
    if to.settings.program_id != source.settings.program_id:
        for i in range(PROGRAM_WORDS):
            to.program[i] = source.program[i]
    assign(to.settings, source.settings)


@compiled
def publish(block: Block, new: Block) -> None:
    """Replace the block's content."""
    sequence = block.sequence[0]
    store_release(block.sequence, 0, sequence + 1)
    fence()
    copy(new, block)
    fence()
    store_release(block.sequence, 0, sequence + 2)


@compiled
def take(block: Block, to: Block) -> bool:
    """Copy the block; return whether it was whole. What a torn copy holds may not be used."""
    sequence = load_acquire(block.sequence, 0)
    if sequence & 1:
        return False
    copy(block, to)
    to.sequence[0] = sequence
    fence()
    if load_acquire(block.sequence, 0) == sequence:
        return True
    to.settings.program_id = TORN
    return False

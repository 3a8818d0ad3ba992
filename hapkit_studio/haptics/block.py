"""The parameter block passes settings to the loop; one writer and one reader use it, and neither ever waits.

It is a seqlock: the sequence number is odd while the writer writes. The reader copies the block and reads the
number again. If the number has changed, the reader tries again in its next tick. The loop uses only the
newest block.
"""

from typing import NamedTuple

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.jit import compiled, internal
from hapkit_studio.haptics.clib import assign, fence, load_acquire, store_release
from hapkit_studio.haptics.record import Record, record, zeros

PARAMS, STATES = 32, 16  # largest numbers of parameters and of state variables of a law

SETTINGS = record(
    ("params", "f8", PARAMS),  # parameters of the law
    ("initial_state", "f8", STATES),  # initial state of the law
    ("coefs", "f8", estimators.COEFFICIENTS),  # coefficients of the velocity estimator
    ("period", "f8"),
    ("delay", "f8"),
    ("max_force", "f8"),
    ("max_speed", "f8"),
    ("fade", "f8"),  # duration in s of a parameter ramp or cross-fade
    ("viscous", "f8"),  # damping of the device in N·s/m
    ("coulomb", "f8"),  # dry friction of a simulated device, N
    ("quantum", "f8"),  # travel per sensor count, m
    ("damper", "f8"),  # largest damping of the passivity controller in N·s/m; 0 switches the controller off
    ("board_first", "f8"),  # coefficients of the estimator on the board
    ("board_second", "f8"),
    ("hand", "f8", 3),  # mass in kg, damping in N·s/m and stiffness in N/m of the simulated hand
    ("hand_target", "f8"),
    ("law", "i8"),  # address of the compiled law
    ("n_params", "i8"),
    ("n_state", "i8"),
    ("discrete", "i8"),  # bit i is set if parameter i is a choice; choices cross-fade
    ("estimator", "i8"),  # a code of dynamics.estimators, or TRUTH
    ("generation", "i8"),  # every change increments this number
    ("hand_on", "i8"),
    # address of the function that returns the energy stored in virtual objects; 0 without such objects
    ("stored", "i8"),
    ("releases", "i8"),  # how often the simulated handle was released with its speed set to zero
    # digest of the board's law, rate and estimator, without constants; 0 if the computer renders
    ("code_id", "i8"),
    ("program_id", "i8"),  # digest of the law's bytes, including the constants
    ("board_law", "i8"),  # address, on this computer, of the law that the board renders
    ("board_form", "i8", 7),  # header of the law for the board, in the order of link.PERIOD to link.CHECK
    ("board_moving", "i8"),  # largest number of constants that the board can ramp at the same time
)

PROGRAM_WORDS = 256
"""int64 words for the board's law: 2,048 bytes, the whole memory of an ATmega328P."""

# value in place of an estimator's code: the law reads the true velocity, which the driver writes to the row
TRUTH = -1
# value in place of program_id: the packed law is a torn copy
TORN = -1


class Block(NamedTuple):
    """The settings, the law for the board packed into int64 words, and the seqlock's sequence number."""

    sequence: np.ndarray  # (1,) int64, shared between threads
    settings: Record  # a SETTINGS record
    program: np.ndarray


def new_block() -> Block:
    return Block(np.zeros(1, np.int64), zeros(SETTINGS), np.zeros(PROGRAM_WORDS, np.int64))


@internal
def copy(source: Block, to: Block) -> None:
    """Copy everything except the sequence number; an unchanged law for the board is not copied again."""
    if to.settings.program_id != source.settings.program_id:
        for i in range(PROGRAM_WORDS):
            to.program[i] = source.program[i]
    assign(to.settings, source.settings)


@compiled
def publish(block: Block, new: Block) -> None:
    sequence = block.sequence[0]
    store_release(block.sequence, 0, sequence + 1)
    fence()
    copy(new, block)
    fence()
    store_release(block.sequence, 0, sequence + 2)


@compiled
def take(block: Block, to: Block) -> bool:
    """Copy the block; return False if the copy is torn and must not be used."""
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

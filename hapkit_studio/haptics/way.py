"""Who renders, the computer or the board, and how one hands over to the other: at zero force.

The words and numbers here are a line's, beside its own. A board renders from its law's first telemetry on,
the computer from the first sample on. On the way to the board the computer's force fades out, the board
learns zero and direction as the person set them, then the law; it fades its force in by itself.
"""

from hapkit_studio.dynamics.jit import internal
from hapkit_studio.haptics import block, rig
from hapkit_studio.haptics.fences import load_acquire

# --- words: before and between them are the line's own
ZEROED = 2
FLIPPED = 3
WAY = 4
SETTINGS_SEEN = 5
GENERATION = 6  # the last one said, of a law or of a change of its constants
LAW_GENERATION = 7  # of the law that was said last, 0 before the first
FORM = 8  # what that law is, as the block has it
PROGRAM = 9  # the same with its constants, 0 where they may be others than the board has
LAW_DUE = 10  # the law is to be said anew
RECEIVED = 11  # bytes of it that the board has
SENT = 12  # bytes of it that have gone out
TUNING = 13  # generation of the change of constants under way, 0 none
OVERRUNS = 14
CONFIGURABLE = 15  # the board's settings are known and can be changed
CALIBRATED = 16  # its zero is one that was stored
SKIPPED = 17  # ticks that the board skipped since it was opened
OBEYED = 18  # the computer's forces have reached the board
UNSHOWN = 19  # samples were left out of the record since the last row
REFUSED = 20  # the form that the board has refused, 0 none
REFUSAL = 21  # and why
STALE_TOLD = 22  # forces refused as too old, as the board counts them
ERRORS_TOLD = 23  # frames that the board could not read, as it counts them
ANSWERED = 24  # the sample that its last force answered
TOO_LONG = 25  # answers in a row that took longer than its watchdog waits
TICKED = 26  # the last frame was one of the computer's tick
WORDS = 27

# --- numbers: from 9 on
LEFT = 9
ASKED_AT = 10
MOVED_AT = 11  # when the board's count of bytes moved last
TUNED_AT = 12
ALIVE_AT = 13
FADED_AT = 14
EXCUSED = 15
FIRST = 16  # the coefficients of the law's estimator
SECOND = 17
SEEN_SPEED = 18  # m/s from one position that the board tells to the next
ROUND_TRIP = 19  # s from a sample to its force, as measured last, without an added delay
TOO_LONG_SINCE = 20
WATCHDOG = 21  # s after which the board refuses a force
DEAF = 22  # s in which the board has kept its motor off although it was answered
NUMBERS = 23

# What WAY says. LEAVING: the computer's force fades out. SETTING: the board takes over the zero. ASKING: it
# is told what to render. THERE: it renders. RETURNING: it was told to give over.
HERE, LEAVING, SETTING, ASKING, THERE, RETURNING = range(6)

_ROUNDING = 1e-9

PATIENCE = 0.1
"""s after which what has no effect is said once more."""


@internal
def wanted(r, line):
    """Return the form of the law that the board is to render now, 0 where the computer renders.

    A zero or direction that a person sets is taken on the computer's way; what the board refused stays here.
    """
    zeroed, flipped = load_acquire(r.control, rig.ZERO), load_acquire(r.control, rig.FLIP)
    if zeroed != line.words[ZEROED] or flipped != line.words[FLIPPED]:
        return 0
    form = r.words[block.FORM]
    return 0 if form == line.words[REFUSED] else form


@internal
def leave(r, line, period):
    """Return the share of the force that a sample's answer may have: it fades out on the way to the board."""
    n, words = line.numbers, line.words
    held = r.real[rig.HOLD] > 0.0 or r.word[rig.STALE] or load_acquire(r.control, rig.FAULT)
    if words[WAY] == HERE:
        if held or wanted(r, line) == 0:
            return 1.0
        words[WAY] = LEAVING
        n[LEFT] = 1.0
    if words[WAY] != LEAVING:
        return 0.0
    if held or wanted(r, line) == 0:
        words[WAY] = HERE
        r.real[rig.GAIN] *= n[LEFT]
        return n[LEFT]
    left = n[LEFT] - period / r.values[block.FADE]
    n[LEFT] = left if left > _ROUNDING else 0.0
    return n[LEFT]


@internal
def computer_speaks(line):
    """Return whether samples are answered by forces."""
    way = line.words[WAY]
    return way == HERE or (way == LEAVING and line.numbers[LEFT] > 0.0)

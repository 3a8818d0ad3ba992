"""Who renders, the computer or the board, and how one hands over to the other: at zero force.

The words and numbers here are a line's, beside its own. A board renders from the first telemetry on, the
computer from the first sample on. On the way to the board the computer's force fades out, the board learns
zero and direction as the person set them, then law and loop; it fades its force in by itself.
"""

from hapkit_studio.dynamics.jit import internal
from hapkit_studio.haptics import block, rig
from hapkit_studio.haptics.fences import load_acquire
from hapkit_studio.protocol.scene_frames import NO_LAW

# --- words: before and between them are the line's own
ZEROED = 2
FLIPPED = 3
WAY = 4
SETTINGS_SEEN = 5
LAW_SENT = 6
GENERATION = 7
FIRST_OF_LAW = 8
SENT_RATE = 9
SENT_ESTIMATOR = 10
OVERRUNS = 11
SCENE_DUE = 12
CONFIGURABLE = 13  # the board's settings are known and can be changed
CALIBRATED = 14  # its zero is one that was stored
SKIPPED = 15  # ticks that the board skipped since it was opened
OBEYED = 16  # the computer's forces have reached the board
UNSHOWN = 17  # samples were left out of the record since the last row
WORDS = 18

# --- numbers: from 9 on
LEFT = 9
ASKED_AT = 10
SAID_AT = 11
ALIVE_AT = 12
FADED_AT = 13
EXCUSED = 14
SENT_FIRST = 15
SENT_SECOND = 16
SEEN_SPEED = 17  # m/s from one position that the board tells to the next
NUMBERS = 20

# What WAY says. LEAVING: the computer's force fades out. SETTING: the board takes over the zero. ASKING: it
# was told what to render. THERE: it renders. RETURNING: it was told to give over.
HERE, LEAVING, SETTING, ASKING, THERE, RETURNING = range(6)

_ROUNDING = 1e-9

PATIENCE = 0.1
"""s after which what has no effect is said once more."""


@internal
def wanted(r, line):
    """Return the number of the law that the board is to render now, NO_LAW where the computer renders.

    A zero or direction that a person sets is taken on the computer's way.
    """
    zeroed, flipped = load_acquire(r.control, rig.ZERO), load_acquire(r.control, rig.FLIP)
    if zeroed != line.words[ZEROED] or flipped != line.words[FLIPPED]:
        return NO_LAW
    law = r.words[block.BOARD_LAW]
    return law - 1 if law > 0 else NO_LAW


@internal
def leave(r, line, period):
    """Return the share of the force that a sample's answer may have: it fades out on the way to the board."""
    n, words = line.numbers, line.words
    held = r.real[rig.HOLD] > 0.0 or r.word[rig.STALE] or load_acquire(r.control, rig.FAULT)
    if words[WAY] == HERE:
        if held or wanted(r, line) == NO_LAW:
            return 1.0
        words[WAY] = LEAVING
        n[LEFT] = 1.0
    if words[WAY] != LEAVING:
        return 0.0
    if held or wanted(r, line) == NO_LAW:
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

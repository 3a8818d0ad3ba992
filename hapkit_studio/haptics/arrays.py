"""The arrays one running loop works on, and the words it shares with the window."""

from typing import NamedTuple

import numpy as np

from hapkit_studio import interrupts
from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.record import Record, record, zeros
from hapkit_studio.laws import native

# Places on each side of its start where the passivity observer can know the law's force.
CELLS = 640

# The tick's own state: forces in N, positions in m, times in s.
TICK = record(
    ("gain", "f8"),  # share of the force: fades in from 0 to 1 after whatever made the force zero
    ("ramp", "f8"),  # share of the way from the old parameters to the new ones
    ("blend", "f8"),  # share of the new law in a cross-fade
    ("last_position", "f8"),
    ("energy", "f8"),  # J given to the handle since the start
    ("applied", "f8"),  # the force sent last
    ("hold", "f8"),  # s of zero force still to come after connecting
    ("good", "f8"),  # s with samples since the sensor was stale
    ("stale_times", "f8", 3),  # when the sensor was last stale, a ring
    ("fault_value", "f8"),  # what made the latched fault, in its unit
    ("fault_position", "f8"),  # where, m; the limit in s for a slow law or link
    ("clock", "f8"),  # the simulated board's clock
    ("velocity", "f8"),  # the estimate in m/s
    ("law_time", "f8"),  # s that a call of the law took lately, in live loops
    ("overrun", "f8"),  # s that laws longer than a period have taken since overrun_since
    ("overrun_since", "f8"),
    ("clock_read_at", "f8"),  # processor time when a headless run read the clock last, 0 before
    ("slot", "i8"),  # the row of params, states and laws in force
    ("started", "i8"),
    ("number", "i8"),  # ticks since the start
    ("stale", "i8"),  # 1 + the cause, 0 while samples come
    ("cleared", "i8"),  # the last value seen of control.clear
    ("row_flags", "i8"),  # of the last row
    ("generation", "i8"),  # the last accepted one
    ("slow_law", "i8"),  # the address of the law that was too slow
    ("signals", "i8"),  # of headless runs: the socket that signals come to
    ("ticks_done", "i8"),  # of headless runs, since the clock was read: ticks, and work in passes of loops
    ("work_done", "i8"),
)
_KEPT = "fault_value", "fault_position", "number", "slow_law"  # by a restart

# The energy in J that may be given, and the excess over it.
LIMIT = record(("limit", "f8"), ("excess", "f8"))

# The passivity observer's state: energies in J, lengths in m, times in s.
WATCH = record(
    ("given", "f8"),  # the energy given since the observer began
    ("alarm", LIMIT),  # the generous limit
    ("strict", LIMIT),  # the controller's
    ("most", "f8"),  # the highest work of the law's force from the start to a known place
    ("edge", "f8"),  # of the present count, from its lower edge
    ("since", "f8"),  # how long the count has not changed
    ("impulse", "f8"),  # N·s in that time
    ("peak", "f8"),  # N, the largest force
    ("speed", "f8"),  # m/s over the last count
    ("start", "f8"),  # where the observer began
    ("ends", "f8", 2),  # N: the force at the last known place on the left, on the right
    # The straightest motion: where it turned last, the time since then, the integral of v² in m²/s until then
    # and until now; the least and the greatest velocity since then that pass all counts, with their times.
    ("turn", "f8"),
    ("lasted", "f8"),
    ("before", "f8"),
    ("squares", "f8"),
    ("least", "f8"),
    ("least_time", "f8"),
    ("greatest", "f8"),
    ("greatest_time", "f8"),
    ("effect", "f8"),  # N, the mean force over the last period
    ("cells_known", "i8"),  # on each side, 1 + those where the force is known; 0 before the observer begins
    ("renew", "i8"),  # begin again
    ("calls", "i8"),  # of the law in this tick
    ("opaque", "i8"),  # the law takes too long to be called
    ("frozen", "f8", block.STATES),  # the law's state when the observer began
    ("scratch", "f8", block.STATES),
    ("work", "f8", 2 * CELLS + 1),  # of the law's force from the start to each place
    ("fault", "i8", native.FAULT_WORDS),  # of those calls
)

LINE = 8  # int64 words of a cache line


def _lines(*names: str) -> tuple[tuple[str, str, int], ...]:
    return tuple((name, "i8", LINE) for name in names)


# Shared between the loop's thread and the window's: the first word of each line, read by load_acquire and
# written by store_release.
CONTROL = record(
    *_lines("quit", "stop", "clear"),  # the window's: end the loop, E-stop, count of faults cleared
    *_lines("zero", "flip"),  # the window's: how often zero and direction were set
    *_lines("head", "accepted"),  # rows written so far; the generation of settings in force
    *_lines("fault", "done"),  # the latched fault; the loop has ended
    *_lines("missed", "lost_frames", "crc_errors"),  # counts: ticks, frames
    *_lines("stale_count", "stale_causes"),  # counts: all, and one word for each of CAUSES
    *_lines("stale_forces", "board_errors"),  # counts: forces that the board refused as too old, bad frames
)

# a law's own codes, and the loop's between them
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL = native.NOT_A_NUMBER, native.LAW_INDEX, native.LAW_FUEL
LAW_DIVISION = native.LAW_DIVISION
NO_FAULT, OVER_SPEED, STALE_SENSOR, DEVICE_GONE, RUNAWAY = 0, 4, 5, 6, 7
SLOW_LAW, SLOW_LINK = 9, 10

# why the force went to zero for a while: the line brought no sample, the computer was away or the law held it
# up, the board switched its motor off although it was answered, its clock jumped
CAUSES = NO_SAMPLE, AWAY, HELD_UP, CUT, CLOCK_JUMP = range(5)


class LoopArrays(NamedTuple):
    """Everything the tick reads and writes: arrays and records, allocated once."""

    tick: Record  # of TICK
    params: np.ndarray  # (2, 32): one row a slot, what each law reads now
    start: np.ndarray  # (32,): where the ramp of the numbers began
    goal: np.ndarray  # (32,): where it ends
    states: np.ndarray  # (2, 16): one row a slot
    laws: np.ndarray  # (2,): addresses
    memory: np.ndarray  # the velocity estimator's
    fault: np.ndarray  # (native.FAULT_WORDS,), set by laws
    watch: Record  # of WATCH
    sequence: np.ndarray  # the block in force
    settings: Record
    program: np.ndarray  # the law for the board, packed
    draft: Block  # the block being read, perhaps torn
    block: Block  # the block as the window writes it
    control: Record  # of CONTROL


def new_arrays(shared: Block) -> LoopArrays:
    """Return arrays at rest that read their settings from the given block."""
    tick = zeros(TICK)
    tick.signals = interrupts.fileno()
    return LoopArrays(
        tick=tick,
        params=np.zeros((2, block.PARAMS)),
        start=np.zeros(block.PARAMS),
        goal=np.zeros(block.PARAMS),
        states=np.zeros((2, block.STATES)),
        laws=np.zeros(2, dtype=np.int64),
        memory=np.zeros(estimators.MEMORY),
        fault=np.zeros(native.FAULT_WORDS, dtype=np.int64),
        watch=zeros(WATCH),
        **block.new_block()._asdict(),
        draft=block.new_block(),
        block=shared,
        control=zeros(CONTROL),
    )


def restart(r: LoopArrays, hold_seconds: float) -> None:
    """Bring the tick back to its start before a loop runs: settings afresh, the force fades in from zero.

    hold_seconds of zero force come first. E-stop and latched faults stay, but for the device's own going
    away; counts go on.
    """
    if r.control.fault[0] == DEVICE_GONE:
        r.control.fault[0] = NO_FAULT
    for name in TICK.fields or ():
        if name not in _KEPT:
            r.tick[name] = 0
    r.tick.blend = r.tick.ramp = 1.0
    r.tick.hold = hold_seconds
    r.tick.cleared = r.control.clear[0]
    r.watch.renew = r.watch.cells_known = 0
    for name in block.SETTINGS.fields or ():
        r.settings[name] = 0
    r.sequence[0] = 0
    if r.control.fault[0] == NO_FAULT:
        r.fault[:] = 0
    r.control.quit[0] = r.control.done[0] = 0

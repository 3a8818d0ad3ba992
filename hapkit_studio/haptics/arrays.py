"""The arrays of one running loop, and the control words that it shares with the window."""

from typing import NamedTuple

import numpy as np

from hapkit_studio import interrupts
from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.record import Record, record, zeros
from hapkit_studio.laws import native

# number of cells on each side of the start in which the passivity observer can record the law's force
CELLS = 640

# the tick's private state: forces in N, positions in m, times in s
TICK = record(
    ("gain", "f8"),  # factor of the force: fades in from 0 to 1 after every cause of zero force
    ("ramp", "f8"),  # progress from the old parameters to the new ones, 0 to 1
    ("blend", "f8"),  # weight of the new law in a cross-fade, 0 to 1
    ("last_position", "f8"),
    ("energy", "f8"),  # energy given to the handle since the start, J
    ("applied", "f8"),  # the last force sent
    ("hold", "f8"),  # remaining time of zero force after connecting, s
    ("good", "f8"),  # time since the sensor was last stale, s
    ("stale_times", "f8", 3),  # ring of the times at which the sensor became stale
    ("fault_value", "f8"),  # the value that caused the latched fault, in its own unit
    ("fault_position", "f8"),  # position of the fault in m; for a slow law or link, the time limit in s
    ("clock", "f8"),  # time of the simulated board's clock
    ("velocity", "f8"),  # estimated velocity in m/s
    ("law_time", "f8"),  # recent duration of a call of the law in s, in live loops
    ("overrun", "f8"),  # total time in s of law calls longer than a period, since overrun_since
    ("overrun_since", "f8"),
    ("clock_read_at", "f8"),  # processor time at the latest reading of the clock in a headless run, 0 before
    ("slot", "i8"),  # index of the slot in force in params, states and laws
    ("started", "i8"),
    ("number", "i8"),  # number of ticks since the start
    ("stale", "i8"),  # 1 + the cause, 0 while samples arrive
    ("cleared", "i8"),  # last value read from control.clear
    ("row_flags", "i8"),  # flags of the last row
    ("generation", "i8"),  # last accepted generation of the settings
    ("slow_law", "i8"),  # address of the law that was too slow
    ("signals", "i8"),  # headless runs: the socket that reports signals
    ("ticks_done", "i8"),  # headless runs: ticks, and loop iterations, since the clock was last read
    ("work_done", "i8"),
)
_KEPT = "fault_value", "fault_position", "number", "slow_law"  # fields that survive a restart

# limit of the energy that the law may give, and the excess over it, in J
LIMIT = record(("limit", "f8"), ("excess", "f8"))

# state of the passivity observer: energies in J, lengths in m, times in s
WATCH = record(
    ("given", "f8"),  # energy given since the observer started
    ("alarm", LIMIT),  # limit for the alarm, with a tolerance
    ("strict", LIMIT),  # limit for the passivity controller, without a tolerance
    ("most", "f8"),  # maximum work of the law's force from the start to any cell with a known force
    ("edge", "f8"),  # position within the present sensor count, from its lower edge
    ("since", "f8"),  # time since the count last changed
    ("impulse", "f8"),  # impulse of the force in that time, N·s
    ("peak", "f8"),  # maximum force in N
    ("speed", "f8"),  # mean velocity over the last count, m/s
    ("start", "f8"),  # position at which the observer started
    ("ends", "f8", 2),  # force in N in the outermost known cell on the left and on the right
    # The straightest motion through all counts: position of the last reversal, time since then, the integral
    # of v² in m²/s until then and until now; the smallest and largest velocity since then that pass all
    # counts, and their times.
    ("turn", "f8"),
    ("lasted", "f8"),
    ("before", "f8"),
    ("squares", "f8"),
    ("least", "f8"),
    ("least_time", "f8"),
    ("greatest", "f8"),
    ("greatest_time", "f8"),
    ("effect", "f8"),  # mean force over the last period, N
    # 1 + number of cells with a known force, on each side; 0 before the observer starts
    ("cells_known", "i8"),
    ("renew", "i8"),  # nonzero: restart the observer
    ("calls", "i8"),  # calls of the law in this tick
    ("opaque", "i8"),  # nonzero: the law is too slow for extra calls
    ("frozen", "f8", block.STATES),  # the law's state when the observer started
    ("scratch", "f8", block.STATES),
    ("work", "f8", 2 * CELLS + 1),  # work of the law's force from the start to each cell
    ("fault", "i8", native.FAULT_WORDS),  # faults of those calls
)

LINE = 8  # int64 words of a cache line


def _lines(*names: str) -> tuple[tuple[str, str, int], ...]:
    return tuple((name, "i8", LINE) for name in names)


# Shared by the loop's thread and the window's: the first word of each line, read with load_acquire and
# written with store_release.
CONTROL = record(
    # written by the window: end the loop, E-stop, number of times faults were cleared
    *_lines("quit", "stop", "clear"),
    *_lines("zero", "flip"),  # written by the window: number of times zero and direction were set
    *_lines("head", "accepted"),  # number of rows written; generation of the settings in force
    *_lines("fault", "done"),  # the latched fault; the loop has ended
    *_lines("missed", "lost_frames", "crc_errors"),  # numbers of missed ticks and frames
    # numbers of stale periods: total, and one word for each of CAUSES
    *_lines("stale_count", "stale_causes"),
    # numbers of forces that the board refused as too old, and of its bad frames
    *_lines("stale_forces", "board_errors"),
)

# fault codes: a law's own, and between them the loop's
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL = native.NOT_A_NUMBER, native.LAW_INDEX, native.LAW_FUEL
LAW_DIVISION = native.LAW_DIVISION
NO_FAULT, OVER_SPEED, STALE_SENSOR, DEVICE_GONE, RUNAWAY = 0, 4, 5, 6, 7
SLOW_LAW, SLOW_LINK = 9, 10

# why the force was zero temporarily: no sample arrived, the computer was suspended, the law blocked the loop,
# the board switched its motor off although it was answered, the board's clock jumped
CAUSES = NO_SAMPLE, AWAY, HELD_UP, CUT, CLOCK_JUMP = range(5)


class LoopArrays(NamedTuple):
    """All arrays and records that the tick reads and writes, allocated once."""

    tick: Record  # a TICK record
    params: np.ndarray  # (2, 32): parameters that each slot's law reads now
    start: np.ndarray  # (32,): start values of the parameters' ramp
    goal: np.ndarray  # (32,): end values of the ramp
    states: np.ndarray  # (2, 16): the law's state in each slot
    laws: np.ndarray  # (2,): addresses of the laws
    memory: np.ndarray  # state of the velocity estimator
    fault: np.ndarray  # (native.FAULT_WORDS,), written by laws
    watch: Record  # a WATCH record
    sequence: np.ndarray  # sequence number of the block in force
    settings: Record
    program: np.ndarray  # the board's law, packed
    draft: Block  # the block being read, possibly torn
    block: Block  # the block that the window writes
    control: Record  # a CONTROL record


def new_arrays(shared: Block) -> LoopArrays:
    """Return the arrays of a stopped loop that reads its settings from the given block."""
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
    """Reset the tick before a loop runs; the force fades in from zero.

    The first hold_seconds have zero force. E-stop and latched faults remain, except for "device
    disconnected"; counters continue.
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

"""The arrays of one running loop, and the control words that it shares with the window."""

from typing import NamedTuple

import numpy as np

from hapkit_studio import interrupts
from hapkit_studio.dynamics import estimators
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.record import Record, record, zeros
from hapkit_studio.laws import native

# number of position cells on each side of the start; the passivity observer stores the law's work for each
# cell
CELLS = 640

# the tick's private state: forces in N, positions in m, times in s
TICK = record(
    ("gain", "f8"),  # factor on the force; it fades in from 0 to 1 after the force was zero for any reason
    ("ramp", "f8"),  # progress of the parameters from old to new values, 0 to 1
    ("blend", "f8"),  # weight of the new law in a cross-fade, 0 to 1
    ("last_position", "f8"),
    ("energy", "f8"),  # energy given to the handle since the start, J
    ("applied", "f8"),  # the last force sent
    ("zero_force_left", "f8"),  # remaining time of zero force after connecting, in s
    ("good", "f8"),  # time since the sensor was last stale, in s
    ("stale_times", "f8", 3),  # ring buffer of the times at which the sensor became stale
    ("fault_value", "f8"),  # the value that caused the latched fault, in its own unit
    # position at which the fault occurred, in m; for a slow law or link, the time limit in s
    ("fault_position", "f8"),
    ("clock", "f8"),  # time of the simulated board's clock
    ("velocity", "f8"),  # estimated velocity in m/s
    ("law_time", "f8"),  # recent duration of a call of the law in s, in live loops
    ("overrun", "f8"),  # total time in s of law calls that took longer than a period, since overrun_since
    ("overrun_since", "f8"),
    # processor time at the latest reading of the clock in a headless run; 0 before the first reading
    ("clock_read_at", "f8"),
    ("slot", "i8"),  # index of the active slot in params, states and laws
    ("started", "i8"),
    ("number", "i8"),  # number of ticks since the start
    ("stale", "i8"),  # 0 while the sensor is not stale, otherwise 1 + the cause (see CAUSES)
    ("cleared", "i8"),  # value of control.clear at the last reading
    ("row_flags", "i8"),  # flags of the last row
    ("generation", "i8"),  # generation of the settings that was accepted last
    ("slow_law", "i8"),  # address of the law that was too slow
    ("signals", "i8"),  # headless runs: the socket that reports signals of the operating system
    # headless runs: number of ticks, and of loop iterations, since the clock was last read
    ("ticks_done", "i8"),
    ("work_done", "i8"),
)
_SURVIVING = "fault_value", "fault_position", "number", "slow_law"  # fields that survive a restart

# limit of the energy that the law may give, and the excess over this limit, in J
LIMIT = record(("limit", "f8"), ("excess", "f8"))

# state of the passivity observer: energies in J, lengths in m, times in s
WATCH = record(
    ("given", "f8"),  # energy given since the observer started
    ("alarm", LIMIT),  # limit for the alarm, with a tolerance
    ("strict", LIMIT),  # limit for the passivity controller, without a tolerance
    ("most", "f8"),  # largest work of the law's force from the start to any cell with a known force
    ("edge", "f8"),  # position within the current sensor count, from its lower edge
    ("since", "f8"),  # time since the count last changed
    ("impulse", "f8"),  # impulse of the force in that time, N·s
    ("peak", "f8"),  # maximum force in N
    ("speed", "f8"),  # mean velocity over the last count, m/s
    ("start", "f8"),  # position at which the observer started
    ("ends", "f8", 2),  # force in N in the outermost known cell on the left and on the right
    # State of the straightest motion, which has the smallest integral of v² of all motions through the same
    # sensor counts. turn: position of its last reversal. lasted: time since then. before, squares: integral
    # of v² in m²/s up to the reversal and up to now. least, greatest: limits of the velocity since the
    # reversal, each with its time.
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
    ("opaque", "i8"),  # nonzero: the law is too slow for additional calls by the observer
    ("frozen", "f8", block.STATES),  # the state of the law when the observer started
    ("scratch", "f8", block.STATES),
    ("work", "f8", 2 * CELLS + 1),  # work of the law's force from the start to each cell
    ("fault", "i8", native.FAULT_WORDS),  # faults of the observer's calls of the law
)

LINE = 8  # int64 words of a cache line


def _lines(*names: str) -> tuple[tuple[str, str, int], ...]:
    return tuple((name, "i8", LINE) for name in names)


# The loop's thread and the window's thread share these words. Each word is the first word of a cache line.
# They are read with load_acquire and written with store_release.
CONTROL = record(
    # written by the window: end of the loop, E-stop, and how often faults were cleared
    *_lines("quit", "stop", "clear"),
    *_lines("zero", "flip"),  # written by the window: how often zero and direction were set
    *_lines("head", "accepted"),  # number of rows written; generation of the settings that are used
    *_lines("fault", "done"),  # the latched fault; whether the loop has ended
    *_lines("missed", "lost_frames", "crc_errors"),  # numbers of missed ticks and frames
    # how often the force was temporarily zero: in total, and for each of CAUSES
    *_lines("stale_count", "stale_causes"),
    # how many forces the board refused because they were too old, and how many bad frames it received
    *_lines("stale_forces", "board_errors"),
)

# fault codes: laws.native defines the codes of faults in a law; the other codes are faults of the loop
NOT_A_NUMBER, LAW_INDEX, LAW_FUEL = native.NOT_A_NUMBER, native.LAW_INDEX, native.LAW_FUEL
LAW_DIVISION = native.LAW_DIVISION
NO_FAULT, OVER_SPEED, STALE_SENSOR, DEVICE_GONE, RUNAWAY = 0, 4, 5, 6, 7
SLOW_LAW, SLOW_LINK = 9, 10

# Why the force was temporarily zero: no sample arrived, the computer was suspended, the law blocked the loop,
# the board switched its motor off although the computer had answered, or the board's clock jumped.
CAUSES = NO_SAMPLE, AWAY, LAW_BLOCKED, CUT, CLOCK_JUMP = range(5)


class LoopArrays(NamedTuple):
    """All arrays and records that the tick reads and writes; they are allocated once."""

    tick: Record  # a TICK record
    params: np.ndarray  # (2, 32): for each slot, the parameters that its law reads now
    start: np.ndarray  # (32,): start values of the parameters' ramp
    goal: np.ndarray  # (32,): end values of the ramp
    states: np.ndarray  # (2, 16): the law's state in each slot
    laws: np.ndarray  # (2,): addresses of the laws
    memory: np.ndarray  # state of the velocity estimator
    fault: np.ndarray  # (native.FAULT_WORDS,), written by laws
    watch: Record  # a WATCH record
    sequence: np.ndarray  # sequence number of the block that is in use
    settings: Record
    program: np.ndarray  # the packed law for the board
    draft: Block  # the block that is being read, which may be torn
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


def restart(r: LoopArrays, zero_force_seconds: float) -> None:
    """Reset the tick before a loop runs; the force fades in from zero.

    The force is zero for the first zero_force_seconds. E-stop and latched faults remain, except for "device
    disconnected". Counters continue.
    """
    if r.control.fault[0] == DEVICE_GONE:
        r.control.fault[0] = NO_FAULT
    for name in TICK.fields or ():
        if name not in _SURVIVING:
            r.tick[name] = 0
    r.tick.blend = r.tick.ramp = 1.0
    r.tick.zero_force_left = zero_force_seconds
    r.tick.cleared = r.control.clear[0]
    r.watch.renew = r.watch.cells_known = 0
    for name in block.SETTINGS.fields or ():
        r.settings[name] = 0
    r.sequence[0] = 0
    if r.control.fault[0] == NO_FAULT:
        r.fault[:] = 0
    r.control.quit[0] = r.control.done[0] = 0

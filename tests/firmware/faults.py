"""The faults, each with its action on the virtual board, its time and the required result.

Times are board times in s. A medium hand moves the handle in a spring to and fro. The studio's compiled loop
runs on the virtual board and reconnects like the window.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices import virtual_board
from hapkit_studio.haptics import arrays, board_plan, health, link, rows, serial_loop
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest, RenderingDecision
from hapkit_studio.haptics.clib import store_release
from hapkit_studio.haptics.link import GONE_AFTER
from hapkit_studio.protocol import codec
from hapkit_studio.protocol.framing import Decoder, encode
from hapkit_studio.protocol.messages import (
    Force,
    Hello,
    HelloRequest,
    Release,
    Settings,
    SettingsRequest,
    Stream,
)
from tests.firmware.turns import Turns, lead
from tests.firmware.vb import QUANTUM
from tests.haptics.support import LoopHarness

START, END = 0.5, 0.8
"""Start and end of a fault in s."""
STALL = END - START
SECONDS = 1.2

HAND = (
    "0.1 hand 0.010 400 8 0.1 0.3",
    "0.45 hand -0.010 400 8 0.1 0.3",
    "0.85 hand 0.008 400 8 0.1 0.2",
)
JUMP = (arrays.NO_FAULT, arrays.OVER_SPEED)
"""Faults that a sensor may cause by recovering at another position, which looks like over-speed."""
LITTLE = (HAND[0], "0.6 hand 0.004 400 8 0.1 0.1", HAND[2])
"""A motion of less than half a turn of the motor between START and END, so that turns can be counted."""
STIFFNESS = 120.0

WATCHDOG, STALE, RECOVER, FADE, HOLD = 0.025, 0.020, 0.100, 0.030, 0.5
PERIOD = 0.001


def no_spam(time: float) -> bytes:
    return b""


@dataclass(frozen=True)
class Case:
    """One fault and its bounds.

    - ``off``: within this time in s after START, the motor is switched off, and it stays off until END.
    - ``back``: within this time in s after END, the full force is back.
    - ``latched``: the faults that the loop may latch.
    - ``wrong``: the sensor is wrong between START and END, so wrong recorded positions are no errors.
    - ``lossy``: frames are lost.
    - ``extra``: another program sends forces.
    - ``board``: the board renders.
    """

    name: str
    script: Sequence[str] = ()
    options: Sequence[str] = ()
    seconds: float = SECONDS
    off: float | None = None
    back: float | None = None
    latched: Sequence[int] = (arrays.NO_FAULT,)
    wrong: bool = False
    lossy: bool = False
    hand: Sequence[str] = HAND
    killed: float = np.inf
    plugged: float = np.inf
    spam: Callable[[float], bytes] = field(default=no_spam)
    extra: Sequence[float] = ()
    board: bool = False


def during(what: str, on: str, off: str = "0") -> tuple[str, str]:
    """Return the script lines that switch a fault on at START and off at END."""
    return f"{START} {what} {on}", f"{END} {what} {off}"


def _garbage(time: float) -> bytes:
    """Return 90 random bytes and a delimiter from START to END; the function is called once per ms."""
    if not START <= time < END:
        return b""
    return np.random.default_rng(int(1e6 * time)).integers(0, 256, 90, dtype=np.uint8).tobytes() + b"\0"


FOREIGN = 0.4


def _forces(time: float) -> bytes:
    """Return eight valid commands from START to END; the function is called once per ms."""
    return encode(Force(0, 0, FOREIGN)) * 8 if START <= time < END else b""


BACK = RECOVER + FADE + 5 * PERIOD
AGAIN = HOLD + FADE + 0.025
GIVEN_UP = GONE_AFTER + 2.0 * STALE
"""Time in s until a loop gives up a silent board; the loop checks the board every STALE."""

DAMAGE = [
    Case(f"{label} {way} the board", during(f"{direction} {kind}", rate), lossy=True)
    for direction, way in (("to", "to"), ("from", "from"))
    for kind, rate, label in (
        ("drop", "0.01", "1 % of bytes dropped"),
        ("flip", "0.01", "1 % of bytes flipped"),
        ("insert", "0.01", "1 % more bytes inserted"),
        ("burst", "0.002 40", "bursts of 40 bytes"),
    )
]

LATENCY = [
    Case(f"USB latency {1e3 * seconds:g} ms", options=("--latency", str(seconds)), lossy=seconds > 0.002)
    for seconds in (0.0005, 0.001, 0.004, 0.016)
]

STALLS = [
    Case("to the board nothing for 300 ms", (f"{START} to stall {STALL}",), off=WATCHDOG, back=0.2),
    Case(
        "from the board nothing for 300 ms",
        (f"{START} from stall {STALL}",),
        # the computer sends zero after 20 ms of its own clock; if the board's clock is faster, the watchdog
        # of the board acts first
        off=WATCHDOG,
        back=BACK + 0.02,
    ),
    Case(
        "from the board nothing for 40 ms, three times",
        tuple(f"{at} from stall 0.04" for at in (0.3, 0.6, 0.9)),
        seconds=1.3,
        latched=(arrays.STALE_SENSOR,),
    ),
]

ENDS = [
    Case(
        "cable pulled and put back",
        (f"{START} unplug", f"{END} plug"),
        seconds=1.6,
        plugged=END,
        off=WATCHDOG,
        back=AGAIN,
    ),
    Case(
        "board reset in mid-motion",
        (f"{START} reset",),
        seconds=2.6,
        plugged=END,
        off=PERIOD,
        back=GIVEN_UP - STALL + AGAIN,
        hand=(*HAND, "1.9 hand -0.008 400 8 0.1 0.4"),
    ),
    Case("program killed", killed=START, seconds=0.8, off=WATCHDOG, latched=(arrays.DEVICE_GONE,)),
]

SENSOR = [
    Case("sensor stuck", during("sensor stuck", "1"), wrong=True, hand=LITTLE, latched=JUMP),
    Case("sensor noisy, 3 counts", during("sensor noise", "3"), wrong=True),
    Case("sensor flipping, 5 % of readings", during("sensor jump", "0.05"), wrong=True, latched=JUMP),
]

FLOOD = [
    Case("line full of garbage", spam=_garbage, lossy=True),
    Case("line full of valid commands", spam=_forces, lossy=True, extra=(FOREIGN,)),
]

HANDOVER = 0.1
"""Duration in s of a handover: fade-out, settings, loop and scene in several frames, fade-in."""

COMPUTER = [Case("none"), *DAMAGE, *LATENCY, *STALLS, *ENDS, *SENSOR, *FLOOD]
BOARD_RENDERS = ", board renders"
BOARD = [
    replace(
        case,
        name=f"{case.name}{BOARD_RENDERS}",
        board=True,
        # the computer renders until the board has taken over
        back=None if case.back is None else case.back + HANDOVER * (case.plugged < np.inf),
    )
    for case in COMPUTER
]
CASES = [*COMPUTER, *BOARD]
TESTED = [
    *(case for case in COMPUTER if case not in LATENCY[1:3]),
    *(case for case in BOARD if case.off is not None or case.spam is not no_spam),
]
"""These cases are in every test run; the others are in the table only."""


# --- run one case
ROWS = 1 << 12
SPRING = environments.named("spring")
VALUES = {"stiffness": STIFFNESS}


@dataclass
class Run:
    """The result of a run: the truth, the ring's rows, the forces sent with their times, and the counters."""

    case: Case
    truth: np.ndarray
    rows: list[np.ndarray] = field(default_factory=list)  # the list has one array per connection
    forces: list[tuple[float, float]] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)
    summary: dict = field(default_factory=dict)


class Session:
    """The computer's side of a run, over all of its connections."""

    def __init__(self, turns: Turns, board: bool):
        self.turns, self.board = turns, board
        self.harness = LoopHarness(SPRING, VALUES, full=False)
        self.late = health.new_histogram()
        self.out = rows.new_ring(self.harness.r.control, ROWS)
        self.reader = rows.RingReader(self.out)
        turns.quit = lambda: store_release(self.harness.r.control.quit, 0, 1)

    def offer(self, conn: link.Link) -> None:
        """Ask the planner what the board can render, and request it, as the engine does."""
        settings = self.turns.ask(SettingsRequest(), Settings)
        offer = BoardPlanner(self.turns.ask(HelloRequest(), Hello).arena, settings)
        way = offer.plan(PlanRequest(SPRING, SPRING.values(VALUES), "difference", QUANTUM))
        board_plan.configure_link(conn, settings, 255)
        self.harness.set(SPRING, VALUES, decision=RenderingDecision(in_force=way))

    def connect(self, hold: float) -> np.ndarray:
        """Render until the connection or the board's time ends; return the rows."""
        r, conn = self.harness.r, link.new_link(QUANTUM)
        self.turns.send(encode(Stream(0, 0)) + encode(Release()))
        if self.board:
            self.offer(conn)
        arrays.restart(r, hold)
        self.turns.send(encode(Stream(1, 0)))
        serial_loop.run(r, conn, self.out, self.late, self.turns.fd)
        self.bad_frames = int(conn.reader[codec.BAD_FRAMES])
        self.rx_errors = int(conn.samples[0, codec.RX_ERRORS])
        return self.reader.read()


def _render(run: Run, session: Session) -> None:
    """Connect, and connect again after the cable is plugged in."""
    turns, case = session.turns, run.case
    turns.until, turns.killed, turns.spam = case.seconds, case.killed, case.spam
    # the loop gives up a silent board without sending a command
    reset = any("reset" in line for line in case.script)
    hold = 0.0
    while True:
        run.rows.append(session.connect(hold))
        if turns.time >= case.seconds or case.killed < np.inf:
            break
        turns.until = case.seconds
        if not reset:
            turns.unplug()
            turns.alone(case.plugged + 0.02)
            turns.plug_in()
        hold = HOLD
    turns.alone(case.seconds)


def run_case(case: Case, folder: Path) -> Run:
    """Run one case; return its result."""
    turns = Turns(
        folder, sorted([*case.hand, *case.script], key=lambda line: float(line.split()[0])), case.options
    )
    lead(turns)
    run = Run(case, np.empty(0))
    session = Session(turns, case.board)
    _render(run, session)
    run.summary = turns.end()
    run.truth = virtual_board.truth(turns.log)
    for time, data in turns.sent:
        run.forces += [(time, m.force) for m in Decoder().feed(data) if isinstance(m, Force)]
    control = session.harness.r.control
    run.counters = {
        "fault": int(control.fault[0]),
        "stale": int(control.stale_count[0]),
        "lost": int(control.lost_frames[0]),
        "bad": session.bad_frames,
        "counted": session.rx_errors,
    }
    return run

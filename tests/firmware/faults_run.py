"""Run one fault: the studio's compiled loop on the virtual board, reconnecting as the window does."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.devices import virtual_board
from hapkit_studio.haptics import arrays, board_plan, health, link, rows, serial_loop
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.haptics.fences import store_release
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
from tests.firmware.faults_cases import HOLD, STIFFNESS, Case
from tests.firmware.faults_turns import Turns, lead
from tests.firmware.vb import QUANTUM
from tests.haptics.support import LoopHarness

ROWS = 1 << 12
SPRING = environments.named("spring")
VALUES = {"stiffness": STIFFNESS}


@dataclass
class Run:
    """What came of it: the truth, the ring's rows, the forces sent with their times, the counters."""

    case: Case
    truth: np.ndarray
    rows: list[np.ndarray] = field(default_factory=list)  # of each connection
    zeros: list[float] = field(default_factory=list)  # count that each took for zero
    forces: list[tuple[float, float]] = field(default_factory=list)
    counters: dict[str, int] = field(default_factory=dict)
    summary: dict = field(default_factory=dict)


class Session:
    """The host's side over all of its connections."""

    def __init__(self, turns: Turns, board: bool):
        self.turns, self.board = turns, board
        self.harness = LoopHarness(SPRING, VALUES, full=False)
        self.late = health.new_histogram()
        self.out = rows.new_ring(self.harness.r.control, ROWS)
        self.reader = rows.RingReader(self.out)
        self.spec = serial_loop.new_spec()
        turns.quit = lambda: store_release(self.harness.r.control, arrays.QUIT, 1)

    def offer(self, conn: link.Link) -> None:
        """Learn what the board can render and want it to, as the engine does."""
        settings = self.turns.ask(SettingsRequest(), Settings)
        offer = BoardPlanner(self.turns.ask(HelloRequest(), Hello).arena, settings)
        way = offer.require(PlanRequest(SPRING, SPRING.values(VALUES), "difference", QUANTUM))
        board_plan.tell_link(conn, settings, 255)
        self.harness.set(SPRING, VALUES, board=way)

    def connect(self, hold: float) -> tuple[np.ndarray, float]:
        """Render until the line or the time ends; return the rows and the count at zero."""
        r, conn = self.harness.r, link.new_link(QUANTUM)
        self.turns.say(encode(Stream(0, 0)) + encode(Release()))
        if self.board:
            self.offer(conn)
        arrays.restart(r, hold)
        self.turns.say(encode(Stream(1, 0)))
        serial_loop.run(r, conn, self.out, self.late, self.turns.fd, self.spec)
        self.bad_frames = int(conn.reader[codec.BAD_FRAMES])
        self.rx_errors = int(conn.samples[0, codec.RX_ERRORS])
        return self.reader.read(), float(conn.numbers[link.ZERO])


def _render(run: Run, session: Session) -> None:
    """Connect, and again once the cable is back."""
    turns, case = session.turns, run.case
    turns.until, turns.killed, turns.spam = case.seconds, case.killed, case.spam
    reset = any("reset" in words for words in case.script)  # the loop gives a silent board up by itself
    hold = 0.0
    while True:
        rows, zero = session.connect(hold)
        run.rows.append(rows)
        run.zeros.append(zero)
        if turns.time >= case.seconds or case.killed < np.inf:
            break
        turns.until = case.seconds
        if not reset:
            turns.unplug()
            turns.alone(case.plugged + 0.02)
            turns.plug_in()
        hold = HOLD
    turns.alone(case.seconds)


def when(words: str) -> float:
    """Return the time of a line of a script."""
    return float(words.split()[0])


def run_case(case: Case, folder: Path) -> Run:
    """Run one case; return what came of it."""
    turns = Turns(folder, sorted([*case.hand, *case.script], key=when), case.options)
    lead(turns)
    run = Run(case, np.empty(0))
    session = Session(turns, case.board)
    _render(run, session)
    run.summary = turns.end()
    run.truth = virtual_board.truth(turns.log)
    run.forces = sent_forces(turns.sent)
    control = session.harness.r.control
    run.counters = {
        "fault": int(control[arrays.FAULT]),
        "stale": int(control[arrays.STALE_COUNT]),
        "lost": int(control[arrays.LOST_FRAMES]),
        "bad": session.bad_frames,
        "told": session.rx_errors,
        "missed": int(control[arrays.MISSED]),
    }
    return run


def sent_forces(sent: list[tuple[float, bytes]]) -> list[tuple[float, float]]:
    """Return time and force in N of every command that the loop sent."""
    found = []
    for time, data in sent:
        found += [(time, m.force) for m in Decoder().feed(data) if isinstance(m, Force)]
    return found

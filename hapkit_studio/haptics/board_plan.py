"""What a board can render by itself, and how a law is to be rendered there."""

import hashlib
import math
import traceback
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.dynamics import estimators, nominal
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.link import Link
from hapkit_studio.laws.law import Law
from hapkit_studio.laws.machine import FRAME, RAMP, REST_AT_MOST, Refusal
from hapkit_studio.protocol.messages import Board, Estimator, MotorMap, Origin, Settings

if TYPE_CHECKING:
    from hapkit_studio.laws.board import Program

CLOCK = 16e6  # cycles a second of its processor
TICKS = 2e6  # a second of its timer, which counts every period
RATES = tuple(range(4000, 499, -100))
"""Hz at which a board is asked to render, the fastest first; it keeps the nearest whole number of ticks."""
_SHARE = 0.8  # of its processor, which a law takes as a rule at most
_KEPT = 64

ESTIMATORS = {"difference": Estimator.DIFFERENCE, "iir": Estimator.IIR, "kalman": Estimator.KALMAN}
INSTEAD = "kalman"  # the estimator of a board that does not have the one that was chosen


@dataclass(frozen=True)
class BoardPlan:
    """How a board is to render a law: its program, period in ticks of its timer, estimator and coefficients.

    moving: constants that it has room to move at a time; share: of its processor, from 0 to 1, as a rule.
    """

    law: Law
    program: "Program"
    period: int
    estimator: int
    first: float
    second: float
    moving: int
    share: float

    @property
    def rate(self) -> float:
        """Return the rate in Hz."""
        return TICKS / self.period

    @cached_property
    def code_id(self) -> int:
        """Return a number that stands for all of it but the constants."""
        p = self.program
        start = p.given[: p.states]
        shape = p.code, start, len(p.given), p.slots, self.period, self.estimator, self.first, self.second
        return _digest(repr(shape).encode())

    @cached_property
    def program_id(self) -> int:
        """Return a number that stands for the program with its constants."""
        return _digest(self.program.data)


def _digest(data: bytes) -> int:
    """Return a number above 0 that tells what is different."""
    return 1 + int.from_bytes(hashlib.blake2b(data, digest_size=7).digest())


@dataclass(frozen=True)
class PlanRequest:
    """What a board is asked to render: a law with its parameters by key, and how; rate None: the fastest."""

    environment: Environment
    values: Values
    estimator: Spec = "difference"
    quantum: float = nominal.QUANTUM
    rate: float | None = None

    @property
    def key(self) -> tuple:
        """Return what stands for it in a dictionary."""
        law = self.environment.force
        numbers = tuple(self.values[p.key] for p in law.parameters)
        return law, numbers, repr(self.estimator), self.quantum, self.rate


@dataclass(frozen=True)
class BoardPlanner:
    """The room in bytes that a board has for one law, its settings if it is open, and what it was asked."""

    arena: int
    settings: Settings | None = None
    _answers: dict[tuple, BoardPlan | str] = field(default_factory=dict, compare=False, repr=False)
    _latest: dict[tuple, BoardPlan] = field(default_factory=dict, compare=False, repr=False)

    def known(self, request: PlanRequest) -> BoardPlan | str | None:
        """Return the answer to a request that was worked out before: how it is rendered, or why not."""
        return self._answers.get(request.key)

    def plan(self, request: PlanRequest) -> BoardPlan | str:
        """Return how a request is rendered, or in one line why not; compiles the law, for about 0.1 s."""
        found = self.known(request)
        return self.keep(request, self._work_out(request)) if found is None else found

    def keep(self, request: PlanRequest, answer: BoardPlan | str) -> BoardPlan | str:
        """Keep an answer to a request, and return it."""
        while len(self._answers) >= _KEPT:
            self._answers.pop(next(iter(self._answers)), None)
        self._answers[request.key] = answer
        return answer

    def _work_out(self, request: PlanRequest) -> BoardPlan | str:
        """Try the fastest rate up to the one asked for, then those that the law's cycles leave time for."""
        law = request.environment.force
        numbers = tuple(request.values[p.key] for p in law.parameters)
        title, room = request.environment.title, min(self.arena, 8 * block.PROGRAM_WORDS)
        key = law, repr(request.estimator), request.quantum, request.rate
        before = self._latest.get(key)
        if before is not None:  # other constants of the same code keep its rate: it need not be sent again
            program = _compiled(law, numbers, 1.0 / before.rate, room)
            if (
                not isinstance(program, str)
                and program.code == before.program.code
                and fits(program, before.rate)
            ):
                return replace(before, program=program, share=share(program, before.rate))
        rate = RATES[0] if request.rate is None else max(request.rate, RATES[-1])
        while True:
            period = round(TICKS / rate)
            program = _compiled(law, numbers, 1.0 / (TICKS / period), room)
            if isinstance(program, str):
                return f"{title} cannot be rendered on the board. {program}"
            if program.size > room:
                tables = f" Its tables take {program.tables:,}." if program.tables else ""
                return f"{title} needs {program.size:,} bytes, the board has {room:,}.{tables}"
            if fits(program, TICKS / period):
                how = coefficients(request.estimator, TICKS / period, request.quantum)
                moving = (self.arena - 4 * program.slots - len(program.code)) // RAMP
                found = BoardPlan(law, program, period, *how, moving, share(program, TICKS / period))
                self._latest[key] = found
                return found
            slower = [
                other for other in RATES if other < rate and fits(program, TICKS / round(TICKS / other))
            ]
            if not slower:
                hertz = int(fastest(program))
                too_slow = f"{title} takes up to {program.most:,} cycles on the board: {hertz:,} Hz at most"
                return f"{too_slow}, and its slowest rate is {RATES[-1]} Hz."
            rate = slower[0]


class BackgroundPlanner:
    """Works requests out in a thread of its own; of several that wait, the newest.

    done is called in that thread with the planner that has answered.
    """

    def __init__(self, done: Callable[[BoardPlanner], None]):
        self._done = done
        self._thread = ThreadPoolExecutor(1, "hapkit-law")
        self._waiting: Future = Future()

    def plan(self, planner: BoardPlanner, request: PlanRequest) -> BoardPlan | str | None:
        """Return a known answer; None where it is being worked out from now on."""

        def work_out() -> None:
            try:
                planner.plan(request)
            except Exception as defect:  # nobody asks the future
                traceback.print_exc()
                planner.keep(
                    request, f"{request.environment.title} cannot be rendered on the board: {defect}"
                )
            self._done(planner)

        found = planner.known(request)
        if found is None:
            self._waiting.cancel()
            self._waiting = self._thread.submit(work_out)
        return found

    def close(self) -> None:
        """Let the thread end; what waits is forgotten."""
        self._thread.shutdown(wait=False, cancel_futures=True)
        self._thread = ThreadPoolExecutor(1, "hapkit-law")


@lru_cache(maxsize=_KEPT)
def _compiled(law: Law, numbers: tuple[float, ...], period: float, room: int) -> "Program | str":
    """Return a law's program for a room in bytes, or in words why there is none."""
    from hapkit_studio.laws import board  # off the first sample's way

    values = dict(zip((p.key for p in law.parameters), numbers, strict=True))
    try:
        return board.compile(law, values, period, room)
    except LawError as error:
        return str(error)


def share(program: "Program", rate: float) -> float:
    """Return the share of the board's processor that a law takes as a rule at a rate in Hz."""
    return (rate * (program.usual + program.rest) + frames(rate) * FRAME) / CLOCK


def frames(rate: float) -> float:
    """Return the frames of telemetry a second at a rate in Hz: a whole fraction of it, 500 to 1000."""
    return rate / math.ceil(rate / 1000.0 - 1e-9)


def fits(program: "Program", rate: float) -> bool:
    """Return whether a law takes its share at most at a rate in Hz, and never more than a period."""
    return share(program, rate) <= _SHARE and rate * (program.most + REST_AT_MOST) <= CLOCK


def fastest(program: "Program") -> float:
    """Return a rate in Hz that a law can surely have: with a frame of telemetry every millisecond."""
    as_a_rule = (_SHARE * CLOCK - 1000 * FRAME) / (program.usual + program.rest)
    return min(as_a_rule, CLOCK / (program.most + REST_AT_MOST))


_REFUSED: dict[int, str] = {
    Refusal.TOO_LARGE: "has no room for this law",
    Refusal.TOO_SLOW: "has no time for this law at this rate",
}


def refusal_text(why: int) -> str:
    """Return in one line why a board does not render the law that it was sent."""
    name = Refusal(why).name.lower().replace("_", " ") if why in list(Refusal) else f"reason {why}"
    words = _REFUSED.get(why, f"refuses this law ({name})")
    return f"The board {words}. The computer renders."


def check_rate(request: float | None) -> None:
    """Raise ParameterError for a rate that no board has."""
    if request is not None and request not in RATES:
        raise ParameterError(
            f"A board renders at {RATES[-1]} to {RATES[0]:,} Hz in steps of {RATES[0] - RATES[1]} Hz, "
            f"not at {request:,g} Hz."
        )


def spec_on_board(spec: Spec) -> Spec:
    """Return the velocity estimator that a board uses for the one chosen: its own, or Kalman."""
    return spec if estimators.parse(spec)[0].key in ESTIMATORS else INSTEAD


def coefficients(spec: Spec, rate: float, quantum: float) -> tuple[int, float, float]:
    """Return estimator and coefficients as the board takes them, the second one in 1/s."""
    code, coefs = estimators.design(spec_on_board(spec), rate, quantum)
    if code == estimators.KALMAN:
        return int(Estimator.KALMAN), float(coefs[0]), float(coefs[1] * rate)
    if code == estimators.IIR:
        return int(Estimator.IIR), float(coefs[0]), 0.0
    return int(Estimator.DIFFERENCE), 0.0, 0.0


def tell_link(line: Link, settings: Settings, pwm_top: int) -> None:
    """Let a connection know what the board says of its kit."""
    line.motor[: pwm_top + 1] = motor_forces(settings, pwm_top)
    body = Board(**{w.name: getattr(settings, w.name) for w in Board.layout()}).pack()
    line.settings[:] = np.frombuffer(body, np.uint8)
    line.state.configurable = 1
    line.state.calibrated = settings.origin == Origin.STORED


def motor_forces(kit: Settings, top: int) -> np.ndarray:
    """Return the force in N at the handle for each duty from 0 to top, (top + 1,), by the kit's map."""
    share = np.clip((np.arange(top + 1) - kit.dead_band) / (top - kit.dead_band), 0.0, 1.0)
    if kit.motor_map == MotorMap.SQUARE:
        torque = share**2
    elif kit.motor_map == MotorMap.TABLE:
        torque = np.interp(share, np.linspace(0.0, 1.0, 9), (0, *kit.table)) / 255.0
    else:
        torque = share
    return torque * kit.motor_constant * kit.sector_radius / (kit.handle_radius * kit.pulley_radius)

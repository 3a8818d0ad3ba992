"""Plans whether a board can render a law itself, at which rate, and with which estimator."""

import hashlib
import math
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.dynamics import estimators, nominal
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.loop_settings import COMPUTER
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.errors import LawError, ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.link import Link
from hapkit_studio.laws.law import Law
from hapkit_studio.laws.machine import FRAME, RAMP, REST_AT_MOST, Refusal
from hapkit_studio.protocol.messages import Board, Estimator, MotorMap, Origin, Settings
from hapkit_studio.worker import Worker

if TYPE_CHECKING:
    from hapkit_studio.laws.board import Program

CLOCK = 16e6  # Hz: clock frequency of the board's processor
TICKS = 2e6  # Hz: frequency of the board's timer, which measures the periods
RATES = tuple(range(4000, 499, -100))
"""Rates in Hz to request from a board, the fastest first; the board rounds the period to whole ticks."""
_SHARE = 0.8  # largest fraction of the board's processor that a law may typically use
_CACHE_SIZE = 64

ESTIMATORS = {"difference": Estimator.DIFFERENCE, "iir": Estimator.IIR, "kalman": Estimator.KALMAN}
INSTEAD = "kalman"  # estimator that a board uses if it does not have the chosen one


@dataclass(frozen=True)
class BoardPlan:
    """How a board renders a law: program, period in timer ticks, estimator and coefficients.

    ``moving`` is the largest number of constants that the board can ramp at the same time. ``share`` is the
    typical fraction of the processor that the law uses.
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
        return TICKS / self.period

    @cached_property
    def code_id(self) -> int:
        """Return a digest of everything except the constants."""
        p = self.program
        start = p.given[: p.states]
        shape = p.code, start, len(p.given), p.slots, self.period, self.estimator, self.first, self.second
        return _digest(repr(shape).encode())

    @cached_property
    def program_id(self) -> int:
        """Return a digest of the program with its constants."""
        return _digest(self.program.data)


def _digest(data: bytes) -> int:
    """Return a positive 63-bit digest."""
    return 1 + int.from_bytes(hashlib.blake2b(data, digest_size=7).digest())


@dataclass(frozen=True)
class RenderingDecision:
    """The decision whether computer or board renders the current settings; only the engine makes it.

    ``plan`` is how the board renders these settings, or would render them. It is None if the board cannot
    render them, or while the decision is ``pending``, which means that the law is being compiled for the
    board. ``refusal`` says in one line why the board cannot render the settings; while the decision is
    pending, it keeps its last value. ``in_force`` is the plan that the loop uses, None while the computer
    renders.
    """

    where: str = COMPUTER
    plan: BoardPlan | None = None
    refusal: str = ""
    pending: bool = False
    in_force: BoardPlan | None = None


@dataclass(frozen=True)
class PlanRequest:
    """A law that a board is to render, with parameters by key, rate (None for the fastest) and estimator."""

    environment: Environment
    values: Values
    estimator: Spec = "difference"
    quantum: float = nominal.QUANTUM
    rate: float | None = None

    @property
    def key(self) -> tuple:
        """Return the request as a dictionary key."""
        law = self.environment.force
        numbers = tuple(self.values[p.key] for p in law.parameters)
        return law, numbers, repr(self.estimator), self.quantum, self.rate


@dataclass(frozen=True)
class BoardPlanner:
    """Plans how a board renders laws.

    ``arena`` is the number of bytes that the board has for one law. ``settings`` are the settings of the open
    board; None without an open board.
    """

    arena: int
    settings: Settings | None = None
    _answers: dict[tuple, BoardPlan | str] = field(default_factory=dict, compare=False, repr=False)
    _latest: dict[tuple, BoardPlan] = field(default_factory=dict, compare=False, repr=False)

    def known(self, request: PlanRequest) -> BoardPlan | str | None:
        """Return the cached plan, or the reason why the board cannot render; None if neither is cached."""
        return self._answers.get(request.key)

    def plan(self, request: PlanRequest) -> BoardPlan | str:
        """Return the plan for a request, or one line that says why the board cannot render the law.

        Compiling a law takes about 0.1 s.
        """
        found = self.known(request)
        return self.store(request, self._work_out(request)) if found is None else found

    def store(self, request: PlanRequest, answer: BoardPlan | str) -> BoardPlan | str:
        """Cache the answer to a request, and return it."""
        while len(self._answers) >= _CACHE_SIZE:
            self._answers.pop(next(iter(self._answers)), None)
        self._answers[request.key] = answer
        return answer

    def _work_out(self, request: PlanRequest) -> BoardPlan | str:
        """Return the plan for the requested rate or the fastest rate at which the law fits, or a refusal."""
        law = request.environment.force
        numbers = tuple(request.values[p.key] for p in law.parameters)
        title, room = request.environment.title, min(self.arena, 8 * block.PROGRAM_WORDS)
        key = law, repr(request.estimator), request.quantum, request.rate
        before = self._latest.get(key)
        # if only constants of the same code change, keep the rate, so that the code is not sent again
        if before is not None:
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
                tables = f" The tables of the law take {program.tables:,} bytes." if program.tables else ""
                return f"{title} needs {program.size:,} bytes of memory, but the board has {room:,}.{tables}"
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
                return (
                    f"One call of {title} takes up to {program.most:,} cycles of the board's processor. "
                    f"This allows {hertz:,} Hz at most, but the board's slowest rate is {RATES[-1]} Hz."
                )
            rate = slower[0]


class BackgroundPlanner:
    """Plans requests in a separate thread; if several requests wait, only the newest is planned.

    ``done`` is called in this thread with the planner that has finished a plan.
    """

    def __init__(self, done: Callable[[BoardPlanner], None]):
        self._done = done
        self._worker = Worker("hapkit-law")

    def plan(self, planner: BoardPlanner, request: PlanRequest) -> BoardPlan | str | None:
        """Return the cached answer, or None after starting the work."""

        def work_out() -> None:
            try:
                planner.plan(request)
            except Exception as defect:  # report it here, because the future's exception is never read
                traceback.print_exc()
                planner.store(
                    request, f"{request.environment.title} cannot be rendered on the board: {defect}"
                )
            self._done(planner)

        found = planner.known(request)
        if found is None:
            self._worker.submit_newest(work_out)
        return found

    def close(self) -> None:
        """End the thread, and discard a request that waits."""
        self._worker.shutdown(wait=False, cancel_futures=True)
        self._worker = Worker("hapkit-law")


@lru_cache(maxsize=_CACHE_SIZE)
def _compiled(law: Law, numbers: tuple[float, ...], period: float, room: int) -> "Program | str":
    """Return a law's program that fits into ``room`` bytes, or the reason why it cannot be compiled."""
    from hapkit_studio.laws import board  # imported here because the import would delay the first sample

    values = dict(zip((p.key for p in law.parameters), numbers, strict=True))
    try:
        return board.compile(law, values, period, room)
    except LawError as error:
        return str(error)


def share(program: "Program", rate: float) -> float:
    """Return the typical fraction of the board's processor that a law uses at a rate in Hz."""
    return (rate * (program.usual + program.rest) + frames(rate) * FRAME) / CLOCK


def frames(rate: float) -> float:
    """Return the telemetry rate, 500 to 1000 Hz: the loop rate in Hz divided by an integer."""
    return rate / math.ceil(rate / 1000.0 - 1e-9)


def fits(program: "Program", rate: float) -> bool:
    """Return True if a law fits at a rate in Hz.

    Its typical load must be permitted, and its longest call must fit into the period.
    """
    return share(program, rate) <= _SHARE and rate * (program.most + REST_AT_MOST) <= CLOCK


def fastest(program: "Program") -> float:
    """Return a rate in Hz at which a law certainly fits, with one telemetry frame per millisecond."""
    as_a_rule = (_SHARE * CLOCK - 1000 * FRAME) / (program.usual + program.rest)
    return min(as_a_rule, CLOCK / (program.most + REST_AT_MOST))


_REFUSED: dict[int, str] = {
    Refusal.TOO_LARGE: "This law is too large for the board",
    Refusal.TOO_SLOW: "The board is too slow for this law at this rate",
}


def refusal_text(why: int) -> str:
    """Return one line that says why a board refuses a law."""
    name = Refusal(why).name.lower().replace("_", " ") if why in list(Refusal) else f"reason {why}"
    text = _REFUSED.get(why, f"The board refuses this law ({name})")
    return f"{text}. The computer renders instead."


def check_rate(request: float | None) -> None:
    """Raise ParameterError for a rate that no board supports."""
    if request is not None and request not in RATES:
        raise ParameterError(
            f"The board's rate must be {RATES[-1]} to {RATES[0]:,} Hz in steps of {RATES[0] - RATES[1]} Hz, "
            f"not {request:,g} Hz."
        )


def spec_on_board(spec: Spec) -> Spec:
    """Return the velocity estimator that a board uses: the chosen one if the board has it, else Kalman."""
    return spec if estimators.parse(spec)[0].key in ESTIMATORS else INSTEAD


def coefficients(spec: Spec, rate: float, quantum: float) -> tuple[int, float, float]:
    """Return the board's code of the estimator and its two coefficients, the second in 1/s."""
    code, coefs = estimators.design(spec_on_board(spec), rate, quantum)
    if code == estimators.KALMAN:
        return int(Estimator.KALMAN), float(coefs[0]), float(coefs[1] * rate)
    if code == estimators.IIR:
        return int(Estimator.IIR), float(coefs[0]), 0.0
    return int(Estimator.DIFFERENCE), 0.0, 0.0


def configure_link(line: Link, settings: Settings, pwm_top: int) -> None:
    """Store the board's settings, and the board's force at each duty, in the link."""
    line.motor[: pwm_top + 1] = motor_forces(settings, pwm_top)
    body = Board(**{w.name: getattr(settings, w.name) for w in Board.layout()}).pack()
    line.settings[:] = np.frombuffer(body, np.uint8)
    line.state.configurable = 1
    line.state.calibrated = settings.origin == Origin.STORED


def motor_forces(kit: Settings, top: int) -> np.ndarray:
    """Return the force in N at the handle for each motor duty from 0 to ``top``, shape (top + 1,)."""
    share = np.clip((np.arange(top + 1) - kit.dead_band) / (top - kit.dead_band), 0.0, 1.0)
    if kit.motor_map == MotorMap.SQUARE:
        torque = share**2
    elif kit.motor_map == MotorMap.TABLE:
        torque = np.interp(share, np.linspace(0.0, 1.0, 9), (0, *kit.table)) / 255.0
    else:
        torque = share
    return torque * kit.motor_constant * kit.sector_radius / (kit.handle_radius * kit.pulley_radius)

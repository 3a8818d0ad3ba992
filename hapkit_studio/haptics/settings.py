"""Settings as a person gives them, turned into the loop's parameter block."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.passivity import most_damping
from hapkit_studio.parameters import Parameter
from hapkit_studio.protocol import law_frames
from hapkit_studio.protocol.framing import crc16

if TYPE_CHECKING:
    from hapkit_studio.haptics.board_plan import BoardPlan

FADE_SECONDS = 0.030
MAX_SPEED = 3.0

RATE = Parameter("rate", "Rate", "Hz", 1000.0, 100.0, 10_000.0, "How often the loop looks and answers")
DELAY = Parameter("delay", "Added delay", "s", 0.0, 0.0, 0.1, "From a sample to the force it causes")


@dataclass(frozen=True)
class LoopSettings:
    """The loop a person chose: rate in Hz, delay in s from sample to force, velocity estimator.

    controller: the passivity controller damps while the scene gives more energy than it may.
    """

    rate: float = RATE.default
    delay: float = DELAY.default
    estimator: Spec = "difference"
    controller: bool = False

    def changed(
        self,
        rate: float | None = None,
        delay: float | None = None,
        estimator: Spec | None = None,
        controller: bool | None = None,
    ) -> "LoopSettings":
        """Return these settings with the given ones replaced; raise ParameterError."""
        if estimator is not None:
            estimators.parse(estimator)
        return replace(
            self,
            rate=self.rate if rate is None else RATE.check(rate),
            delay=self.delay if delay is None else DELAY.check(delay),
            estimator=self.estimator if estimator is None else estimator,
            controller=self.controller if controller is None else bool(controller),
        )


@dataclass
class Wanted:
    """Everything the block holds, by name.

    coulomb is a simulated device's, a board has its own; mass and viscous are what the passivity observer
    goes by, and a simulated device's damping; true_velocity spares the estimator; designed_for: the
    quantum in m that the estimator expects, None for the sensor's own; releases: how often a simulated
    handle was let go at rest; board: None, the computer renders.
    """

    environment: Environment
    values: Mapping[str, float]
    loop: LoopSettings = field(default_factory=LoopSettings)
    max_force: float = 3.0
    max_speed: float = MAX_SPEED
    quantum: float = 20.7e-6
    mass: float = 0.044
    viscous: float = 0.0
    coulomb: float = 0.0
    true_velocity: bool = False
    designed_for: float | None = None
    grip: Grip | None = None
    target: float | None = None
    releases: int = 0
    board: "BoardPlan | None" = None
    generation: int = 0

    def encode(self) -> Block:
        """Return the block's content; compiles the law if it is new."""
        content = block.new_block()
        values, words, program = content
        law = self.environment.force.compiled()
        numbers = [self.values[p.key] for p in self.environment.parameters]
        for p, number in zip(self.environment.parameters, numbers, strict=True):
            if not math.isfinite(number):
                raise ParameterError(f"{p.label} must be a finite number, not {number:g}.")
        values[: len(numbers)] = numbers
        start = law.initial_state
        values[block.INITIAL_STATE : block.INITIAL_STATE + len(start)] = start
        expected = self.quantum if self.designed_for is None else self.designed_for
        code, coefs = estimators.design(self.loop.estimator, self.loop.rate, expected)
        values[block.COEFS : block.PERIOD] = coefs
        period, delay = 1.0 / self.loop.rate, self.loop.delay
        limits = self.max_force, self.max_speed, FADE_SECONDS
        values[block.PERIOD : block.FADE + 1] = period, delay, *limits
        values[block.VISCOUS : block.QUANTUM + 1] = self.viscous, self.coulomb, self.quantum
        if self.loop.controller:
            values[block.DAMPER] = most_damping(self.mass, period, delay)
        if self.grip is not None and self.target is not None:
            hand = self.grip.mass, self.grip.damping, self.grip.stiffness, self.target
            values[block.HAND_MASS : block.HAND_TARGET + 1] = hand
            words[block.HAND_ON] = 1
        words[block.RELEASES] = self.releases
        self._encode_board(values, words, program)
        words[block.LAW] = law.address
        stored = self.environment.stored
        words[block.STORED] = stored.compiled().address if stored else 0
        words[block.N_PARAMS] = len(numbers)
        words[block.N_STATE] = len(start)
        words[block.DISCRETE] = sum(1 << i for i, p in enumerate(self.environment.parameters) if p.discrete)
        words[block.ESTIMATOR] = block.TRUTH if self.true_velocity else code
        words[block.GENERATION] = self.generation
        return content

    def _encode_board(self, values: np.ndarray, words: np.ndarray, program: np.ndarray) -> None:
        plan = self.board
        if plan is None:
            return
        data = plan.program.data
        program[:] = law_frames.packed(data, block.PROGRAM_WORDS)
        words[block.CODE_ID], words[block.PROGRAM_ID] = plan.code_id, plan.program_id
        words[block.BOARD_LAW] = plan.law.compiled().address
        words[block.BOARD_PERIOD], words[block.BOARD_ESTIMATOR] = plan.period, plan.estimator
        words[block.BOARD_STATES], words[block.BOARD_GIVEN] = plan.program.states, len(plan.program.given)
        words[block.BOARD_SLOTS], words[block.BOARD_CODE] = plan.program.slots, len(plan.program.code)
        words[block.BOARD_CHECK], words[block.BOARD_MOVING] = crc16(data), plan.moving
        values[block.BOARD_FIRST], values[block.BOARD_SECOND] = plan.first, plan.second

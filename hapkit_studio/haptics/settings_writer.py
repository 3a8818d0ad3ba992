"""Settings as a person gives them, turned into the loop's parameter block."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import Grip
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.observer import most_damping
from hapkit_studio.parameters import Parameter

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

    def changed(self, rate=None, delay=None, estimator=None, controller=None) -> "LoopSettings":
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


@dataclass(frozen=True)
class BoardWay:
    """What a board is to render: the law's number there, rate in Hz, estimator and its coefficients."""

    law: int
    rate: int
    estimator: int
    first: float = 0.0
    second: float = 0.0


@dataclass
class Wanted:
    """Everything the block holds, by name.

    coulomb is a simulated device's, a board has its own; mass and viscous are what the passivity observer
    goes by, and a simulated device's damping; true_velocity spares the estimator; designed_for: the
    quantum in m that the estimator expects, None for the sensor's own; board: None, the computer renders.
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
    board: BoardWay | None = None
    generation: int = 0

    def encode(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the block's values and words; compiles the law if it is new."""
        values, words = block.new_block()
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
        values[block.PERIOD] = 1.0 / self.loop.rate
        values[block.DELAY] = self.loop.delay
        values[block.MAX_FORCE] = self.max_force
        values[block.MAX_SPEED] = self.max_speed
        values[block.FADE] = FADE_SECONDS
        values[block.VISCOUS] = self.viscous
        values[block.COULOMB] = self.coulomb
        values[block.QUANTUM] = self.quantum
        if self.loop.controller:
            values[block.DAMPER] = most_damping(self.mass, values[block.PERIOD], self.loop.delay)
        self._encode_hand(values, words)
        self._encode_board(values, words)
        words[block.LAW] = law.address
        stored = self.environment.stored
        words[block.STORED] = stored.compiled().address if stored else 0
        words[block.N_PARAMS] = len(numbers)
        words[block.N_STATE] = len(start)
        words[block.DISCRETE] = sum(1 << i for i, p in enumerate(self.environment.parameters) if p.discrete)
        words[block.ESTIMATOR] = block.TRUTH if self.true_velocity else code
        words[block.GENERATION] = self.generation
        return values, words

    def _encode_board(self, values: np.ndarray, words: np.ndarray) -> None:
        if self.board is None:
            return
        words[block.BOARD_LAW] = 1 + self.board.law
        words[block.BOARD_RATE] = self.board.rate
        words[block.BOARD_ESTIMATOR] = self.board.estimator
        values[block.BOARD_FIRST] = self.board.first
        values[block.BOARD_SECOND] = self.board.second

    def _encode_hand(self, values: np.ndarray, words: np.ndarray) -> None:
        if self.grip is None or self.target is None:
            return
        values[block.HAND_MASS] = self.grip.mass
        values[block.HAND_DAMPING] = self.grip.damping
        values[block.HAND_STIFFNESS] = self.grip.stiffness
        values[block.HAND_TARGET] = self.target
        words[block.HAND_ON] = 1

"""The content of the loop's parameter block, by name."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.passivity import most_damping
from hapkit_studio.protocol import law_frames
from hapkit_studio.protocol.framing import crc16

if TYPE_CHECKING:
    from hapkit_studio.haptics.board_plan import BoardPlan

FADE_SECONDS = 0.030
MAX_SPEED = 3.0


@dataclass
class BlockContent:
    """Everything that the parameter block holds, by name.

    settings.mass and viscous are what the passivity observer assumes; viscous and coulomb are those of a
    simulated device, 0 for a board, which has its own. true_velocity: the law gets the paddle's own velocity.
    designed_for: sensor quantum in m that the estimator expects, None for settings.quantum. target: of the
    hand in m, None while it has let go. releases: how often a simulated handle was released at rest. board:
    how the board renders, None while the computer does.
    """

    environment: Environment
    values: Mapping[str, float]
    settings: LoopSettings = field(default_factory=LoopSettings)
    max_speed: float = MAX_SPEED
    true_velocity: bool = False
    designed_for: float | None = None
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
        loop, grip = self.settings, self.settings.grip
        expected = loop.quantum if self.designed_for is None else self.designed_for
        code, coefs = estimators.design(loop.estimator, loop.rate, expected)
        values[block.COEFS : block.PERIOD] = coefs
        limits = loop.max_force, self.max_speed, FADE_SECONDS
        values[block.PERIOD : block.FADE + 1] = loop.period, loop.delay, *limits
        values[block.VISCOUS : block.QUANTUM + 1] = loop.viscous, loop.coulomb, loop.quantum
        if loop.controller:
            values[block.DAMPER] = most_damping(loop.mass, loop.period, loop.delay)
        if grip is not None and self.target is not None:
            hand = grip.mass, grip.damping, grip.stiffness, self.target
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

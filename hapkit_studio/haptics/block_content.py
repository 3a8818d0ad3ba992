"""The content of the loop's parameter block, by name."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from hapkit_studio.dynamics import estimators
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import block
from hapkit_studio.haptics.block import Block
from hapkit_studio.haptics.board_plan import RenderingDecision
from hapkit_studio.haptics.passivity import most_damping
from hapkit_studio.protocol import law_frames
from hapkit_studio.protocol.framing import crc16

FADE_SECONDS = 0.030
MAX_SPEED = 3.0


@dataclass
class BlockContent:
    """The content of the parameter block, by name.

    ``settings.mass`` and ``settings.viscous`` are the values that the passivity observer assumes. ``viscous``
    and ``coulomb`` are the friction of a simulated device; they are 0 for a board, whose friction is real. If
    ``true_velocity`` is true, the law gets the paddle's true velocity. ``designed_for`` is the sensor quantum
    in m that the estimator assumes; None means settings.quantum. ``target`` is the hand's target position in
    m; it is None after a release. ``releases`` is the number of times that a simulated handle was released
    with its speed set to zero. ``decision`` states whether the computer or the board renders, and contains
    the board's plan.
    """

    environment: Environment
    values: Mapping[str, float]
    settings: LoopSettings = field(default_factory=LoopSettings)
    max_speed: float = MAX_SPEED
    true_velocity: bool = False
    designed_for: float | None = None
    target: float | None = None
    releases: int = 0
    decision: RenderingDecision = field(default_factory=RenderingDecision)
    generation: int = 0

    def encode(self) -> Block:
        """Return the content as a block; compile the law if it is new."""
        content = block.new_block()
        settings = content.settings
        law = self.environment.force.compiled()
        numbers = [self.values[p.key] for p in self.environment.parameters]
        for p, number in zip(self.environment.parameters, numbers, strict=True):
            if not math.isfinite(number):
                raise ParameterError(f"{p.label} must be a finite number, not {number:g}.")
        settings.params[: len(numbers)] = numbers
        start = law.initial_state
        settings.initial_state[: len(start)] = start
        loop, grip = self.settings, self.settings.grip
        expected = loop.quantum if self.designed_for is None else self.designed_for
        code, coefs = estimators.design(loop.estimator, loop.rate, expected)
        settings.coefs = coefs
        settings.period, settings.delay = loop.period, loop.delay
        settings.max_force, settings.max_speed, settings.fade = loop.max_force, self.max_speed, FADE_SECONDS
        settings.viscous, settings.coulomb, settings.quantum = loop.viscous, loop.coulomb, loop.quantum
        if loop.controller:
            settings.damper = most_damping(loop.mass, loop.period, loop.delay)
        if grip is not None and self.target is not None:
            settings.hand = grip.mass, grip.damping, grip.stiffness
            settings.hand_target = self.target
            settings.hand_on = 1
        settings.releases = self.releases
        self._encode_board(content)
        settings.law = law.address
        stored = self.environment.stored
        settings.stored = stored.compiled().address if stored else 0
        settings.n_params = len(numbers)
        settings.n_state = len(start)
        settings.discrete = sum(1 << i for i, p in enumerate(self.environment.parameters) if p.discrete)
        settings.estimator = block.TRUTH if self.true_velocity else code
        settings.generation = self.generation
        return content

    def _encode_board(self, content: Block) -> None:
        plan = self.decision.in_force
        if plan is None:
            return
        settings, program = content.settings, plan.program
        data = program.data
        content.program[:] = law_frames.packed(data, block.PROGRAM_WORDS)
        settings.code_id, settings.program_id = plan.code_id, plan.program_id
        settings.board_law = plan.law.compiled().address
        sizes = program.states, len(program.given), program.slots, len(program.code)
        settings.board_form = plan.period, plan.estimator, *sizes, crc16(data)
        settings.board_moving = plan.moving
        settings.board_first, settings.board_second = plan.first, plan.second

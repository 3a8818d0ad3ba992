"""Find the cheapest option that the board can render and that feels the same as a refused option."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Prescribed, hand_named
from hapkit_studio.dynamics.loop_settings import LoopSettings
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.board_plan import BoardPlan, BoardPlanner, PlanRequest
from hapkit_studio.parameters import Choice

FELT = 0.06
"""Just-noticeable difference of a force, as a fraction of the largest force."""
AVERAGED = 0.01
"""s: time over which forces are averaged, because a person does not feel that a pulse is one sample late."""
SECONDS = 3.0


@dataclass(frozen=True)
class RefusedRequest:
    """A request that a board cannot render."""

    planner: BoardPlanner
    request: PlanRequest


@dataclass(frozen=True)
class Alternative:
    """An option that the board can render.

    The largest difference from the refused option (``apart``) and the largest force, both in N, are measured
    over one movement.
    """

    question: RefusedRequest
    choice: Choice
    option: int
    plan: BoardPlan
    apart: float = 0.0
    force: float = 0.0

    @property
    def text(self) -> str:
        """Return the option's cost and difference in one line."""
        program = self.plan.program
        return (
            f"{self.choice.option_label(self.option)} takes {program.size:,} bytes and "
            f"{program.usual:,.0f} cycles, and feels like your choice: the forces differ by at most "
            f"{self.apart:.2f} N (largest force: {self.force:.1f} N)."
        )


@dataclass(frozen=True)
class AlternativeResult:
    """The result of a search; ``found`` is None if no option feels the same."""

    question: RefusedRequest
    found: Alternative | None


def find(question: RefusedRequest) -> AlternativeResult:
    """Return the cheapest option that the board can render and that feels the same as the refused one."""
    request = question.request
    for one in sorted(_options(question), key=lambda one: one.plan.program.usual):
        other = replace(request, values={**request.values, one.choice.key: float(one.option)})
        was, now = (_forces(w, one.plan.rate) for w in (request, other))
        apart, force = float(np.abs(now - was).max()), float(np.abs(was).max())
        if apart <= FELT * force:
            return AlternativeResult(question, replace(one, apart=apart, force=force))
    return AlternativeResult(question, None)


def _options(question: RefusedRequest) -> Iterator[Alternative]:
    """Yield every option that the board can render and that differs from the request in a single choice."""
    request = question.request
    for choice in (p for p in request.environment.parameters if isinstance(p, Choice)):
        for option in range(len(choice.options)):
            values = {**request.values, choice.key: float(option)}
            plan = question.planner.plan(replace(request, values=values))
            if isinstance(plan, BoardPlan) and not request.environment.check(values):
                yield Alternative(question, choice, option, plan)


def _forces(request: PlanRequest, rate: float) -> np.ndarray:
    """Return the moving average (n,) of a law's force in N at a rate in Hz, during the scene's movement."""
    device = SimulatedHapkit(quantum=request.quantum)
    loop = LoopSettings(rate)
    scene = headless.Scene(request.environment, request.values, device, loop, true_velocity=True)
    hand = hand_named(next((name for name in request.environment.hands if name != "released"), "press"))
    motion = Prescribed(lambda t: float(hand.target(t)))
    force = headless.render(scene, motion, round(SECONDS * rate))[0][:, rows.FORCE]
    samples = round(AVERAGED * rate)
    return np.convolve(force, np.full(samples, 1.0 / samples), "same")

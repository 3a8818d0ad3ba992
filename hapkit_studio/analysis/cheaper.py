"""The cheapest option in the place of one that a board cannot render, if its force feels the same."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Prescribed, hand_named
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.board_plan import BoardPlan, BoardPlanner, PlanRequest
from hapkit_studio.haptics.settings_writer import LoopSettings
from hapkit_studio.parameters import Choice

FELT = 0.06
"""Share of the largest force from which on a person can tell two forces apart, about."""
AVERAGED = 0.01
"""s over which forces are averaged: nobody feels that a blow comes a sample later."""
SECONDS = 3.0


@dataclass(frozen=True)
class Question:
    """A wish that a board has refused."""

    offer: BoardPlanner
    wish: PlanRequest


@dataclass(frozen=True)
class Cheaper:
    """An option that the board renders; over one movement, in N: greatest difference, largest force."""

    question: Question
    choice: Choice
    option: int
    way: BoardPlan
    apart: float = 0.0
    force: float = 0.0

    @property
    def words(self) -> str:
        """Return in one line what it costs, and by how much it differs."""
        program = self.way.program
        return (
            f"{self.choice.word(self.option)} takes {program.size:,} bytes, {program.usual:,.0f} cycles, and "
            f"feels the same: {self.apart:.2f} N apart at most, of {self.force:.1f} N."
        )


@dataclass(frozen=True)
class Answer:
    """What was found for a question, None where nothing feels the same."""

    question: Question
    found: Cheaper | None


def find(question: Question) -> Answer:
    """Look for the option that costs the board least and cannot be told from the one that was refused."""
    wish = question.wish
    for one in sorted(_options(question), key=lambda one: one.way.program.usual):
        other = replace(wish, values={**wish.values, one.choice.key: float(one.option)})
        was, now = (_forces(w, one.way.rate) for w in (wish, other))
        apart, force = float(np.abs(now - was).max()), float(np.abs(was).max())
        if apart <= FELT * force:
            return Answer(question, replace(one, apart=apart, force=force))
    return Answer(question, None)


def _options(question: Question) -> Iterator[Cheaper]:
    """Yield everything that the board renders and that differs by one choice."""
    wish = question.wish
    for choice in (p for p in wish.environment.parameters if isinstance(p, Choice)):
        for option in range(len(choice.options)):
            values = {**wish.values, choice.key: float(option)}
            way = question.offer.plan(replace(wish, values=values))
            if isinstance(way, BoardPlan) and not wish.environment.check(values):
                yield Cheaper(question, choice, option, way)


def _forces(wish: PlanRequest, rate: float) -> np.ndarray:
    """Return the averaged force (n,) in N of a law at a rate in Hz while a hand moves as its scene says."""
    device = SimulatedHapkit(quantum=wish.quantum)
    scene = headless.Scene(wish.environment, wish.values, device, LoopSettings(rate), true_velocity=True)
    hand = hand_named(next((name for name in wish.environment.hands if name != "released"), "press"))
    motion = Prescribed(lambda t: float(hand.target(t)))
    asked = headless.render(scene, motion, round(SECONDS * rate))[0][:, rows.ASKED]
    samples = round(AVERAGED * rate)
    return np.convolve(asked, np.full(samples, 1.0 / samples), "same")

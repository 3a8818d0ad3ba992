"""The hand that presses into the wall: a simulated one hits it by itself, a person is asked to press."""

import time
from typing import Protocol as Interface

import numpy as np

from hapkit_studio.analysis.zwidth_bench import Bench, Interrupted, pressing, useless
from hapkit_studio.analysis.zwidth_result import Condition
from hapkit_studio.dynamics.hand import GRIPS, Grip
from hapkit_studio.haptics import rows

_STEP_SECONDS = 0.01
_AWAY = 0.005
_AWAY_SECONDS = 1.5
_SLOW = 0.03
_PATIENCE_SECONDS = 60.0
_LEAST_SHARE, _MOST_SHARE = 0.3, 0.85
ASK = "Press gently into the wall and hold"
USUAL_GRIP = "medium"


class Presser(Interface):
    """A hand on the handle."""

    @property
    def grip(self) -> str:
        """Return the grip that the linear limit is computed with."""

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """Return how it pressed."""

    def begin(self) -> None:
        """Get ready for a trial, the wall being a calm one."""

    def press(self, stiffness: float) -> None:
        """Press into the wall that is in force now."""

    def presses(self, found: np.ndarray) -> bool:
        """Return whether the rows show a hand that presses as it should."""


class SimulatedHand:
    """Goes away from the wall, hits it at a speed and holds it with a force."""

    def __init__(self, bench: Bench):
        self._bench = bench
        grip = bench.engine.grip
        self._grip = grip if GRIPS[grip] is not None else USUAL_GRIP
        bench.engine.set_grip(self._grip)

    @property
    def grip(self) -> str:
        """Return the name of the grip."""
        return self._grip

    @property
    def conditions(self) -> tuple[Condition, ...]:
        care = self._bench.care
        return (
            Condition("hand", self._grip, "Hand", f"simulated, {self._grip}"),
            Condition("speed", care.hit, "Hit at", f"{care.hit:g} m/s", "v₀"),
            Condition("push", care.push, "Push", f"{care.push:g} N"),
        )

    def begin(self) -> None:
        """Go away from the wall and wait until the handle has come along."""
        away = self._bench.surface - self._bench.into * _AWAY
        self._bench.engine.move_hand(away)
        end = time.monotonic() + _AWAY_SECONDS
        while time.monotonic() < end:
            found = self._bench.collect(2.0 * _STEP_SECONDS, judged=False)
            near = np.abs(found[:, rows.POSITION] - away) < 0.5 * _AWAY
            if near.all() and np.ptp(found[:, rows.POSITION]) < _SLOW * 2.0 * _STEP_SECONDS:
                return

    def press(self, stiffness: float) -> None:
        """Move the hand at its speed to where wall and grip balance at the push."""
        grip = GRIPS[self._grip]
        assert isinstance(grip, Grip)
        bench, care = self._bench, self._bench.care
        goal = care.push / grip.stiffness + care.push / stiffness
        start, depth = bench.collect(_STEP_SECONDS)[-1, rows.BOARD_TIME], -_AWAY
        while depth < goal:
            now = bench.collect(_STEP_SECONDS)[-1, rows.BOARD_TIME]
            depth = min(care.hit * (now - start) - _AWAY, goal)
            bench.engine.move_hand(bench.surface + bench.into * depth)

    def presses(self, found: np.ndarray) -> bool:
        """Return whether it does: in a window somebody may have taken the handle away."""
        least = _LEAST_SHARE * self._bench.care.push
        return not useless(found) and pressing(found, self._bench.into) >= least


class Person:
    """Is asked to press and to hold, and watched whether it does."""

    grip = "released"

    def __init__(self, bench: Bench):
        self._bench = bench
        care = bench.care
        self._least, self._most = _LEAST_SHARE * care.push, _MOST_SHARE * care.max_force

    @property
    def conditions(self) -> tuple[Condition, ...]:
        words = f"{self._least:.2g} to {self._most:.2g} N"
        return (
            Condition("hand", "person", "Hand", "a person's, held"),
            Condition("push", words, "Push", words),
        )

    def begin(self) -> None:
        """Wait until a person presses; raise Interrupted where nobody does."""
        end = time.monotonic() + _PATIENCE_SECONDS
        said = ""
        while not self.presses(found := self._bench.collect(0.2, judged=False)):
            words = self._words(found)
            if words != said:
                self._bench.say(words)
            said = words
            if time.monotonic() > end:
                raise Interrupted(f"Nobody pressed for {_PATIENCE_SECONDS:.0f} s. The measurement ended.")
        self._bench.say("Hold")

    def press(self, stiffness: float) -> None:
        """Leave it to the person."""

    def presses(self, found: np.ndarray) -> bool:
        return not useless(found) and self._least <= pressing(found, self._bench.into) <= self._most

    def _words(self, found: np.ndarray) -> str:
        force = pressing(found, self._bench.into)
        if force <= self._most:
            return f"{ASK}."
        return f"Press more gently: {force:.1f} N now, {self._bench.care.push:g} N is enough."

"""The error of one way to render a scene, against the scene itself, and what each component contributes.

The scene itself: its law by the exact method, in a loop so fast and with so little delay that a faster one
feels the same, with an ideal sensor, the true velocity and no force limit, under every hand of the scene. The
error is the largest difference that a hand feels, in just-noticeable differences (JND, see perception).

Each component of a way (method, rate, delay, velocity estimate, sensor steps, force limit) may be the real
one or the ideal one. A component's part of the error is its Shapley value: the mean, over every order in
which the components become real, of what it adds. The parts add up to the error. A part below 0 compensates
another: semi-implicit Euler runs half a step ahead, which makes up for part of the force being held for a
period.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import numpy as np

from hapkit_studio.analysis import fidelity, perception
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.estimators import Spec
from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import LoopSettings

IDEAL_RATE = 64_000.0
"""Hz of the loop of the scene itself: a hand feels less than 0.05 JND of a loop that is twice as fast."""
METHOD, SAMPLING, DELAY, VELOCITY, SENSOR, LIMIT = "method", "rate", "delay", "velocity", "sensor", "limit"
COMPONENTS = {
    METHOD: "method",
    SAMPLING: "rate",
    DELAY: "delay",
    VELOCITY: "velocity estimate",
    SENSOR: "sensor steps",
    LIMIT: "force limit",
}
"""Name in words of each component of a way to render."""
# columns that go on between two samples; all others are those of the last sample
_MOVING = (rows.TRUE_POSITION, rows.TRUE_VELOCITY)
_STEP = 1e-6  # s either side of a moment, for the velocity of a hand's target


@dataclass(frozen=True)
class Way:
    """One way to render: values with its method, rate in Hz, delay in s, velocity estimator."""

    values: Values
    rate: float
    delay: float
    estimator: Spec


@dataclass(frozen=True)
class Felt:
    """The largest difference that is felt: in JND, of which sense, under which hand."""

    error: float
    sense: str
    hand: str


class SceneError:
    """Judges ways to render one scene; what it has rendered it does not render again.

    exact: the scene's values with the exact method; hands: names of scripts.
    """

    def __init__(
        self, environment: Environment, exact: Values, device: SimulatedHapkit, hands: tuple[str, ...] = ()
    ):
        self.environment, self.exact, self.device = environment, exact, device
        self.hands = hands or environment.hands or fidelity.HANDS
        outcomes = [fidelity.outcome_named(key, environment.state_names) for key in environment.outcomes]
        self._counts = [outcome.column for outcome in outcomes if outcome.column is not None]
        ideal = Way(exact, IDEAL_RATE, 0.0, "difference")
        sensor = replace(device, quantum=0.0, max_force=math.inf)
        self._reference = cache(lambda hand: self._render(ideal, hand, sensor, True))
        self._found: dict[tuple, Felt] = {}

    def felt(self, way: Way, real: tuple[str, ...] = tuple(COMPONENTS)) -> Felt:
        """Return the largest error over all hands, with the components not in `real` ideal."""
        return max((self._told(way, hand, real) for hand in self.hands), key=lambda found: found.error)

    def parts(self, way: Way) -> dict[str, float]:
        """Return each component's part of the error in JND; they add up to it. inf where the error is inf.

        A component that makes no difference by itself and none when it alone is ideal has no part.
        """
        everything = tuple(COMPONENTS)
        worth = cache(lambda real: self.felt(way, real).error if real else 0.0)
        total = worth(everything)
        if math.isinf(total):
            return {METHOD: total}
        players = tuple(
            one for one in everything
            if worth((one,)) or worth(tuple(c for c in everything if c != one)) != total
        )  # fmt: skip
        # what has no part may be real or ideal in every coalition alike
        found = shapley(players, worth)
        return {one: found.get(one, 0.0) for one in everything}

    def _told(self, way: Way, hand: str, real: tuple[str, ...]) -> Felt:
        """Return the error with one hand; ways that differ only in ideal components share one run."""
        effective = Way(
            way.values if METHOD in real else self.exact,
            way.rate if SAMPLING in real else IDEAL_RATE,
            way.delay if DELAY in real else 0.0,
            way.estimator if VELOCITY in real else "difference",
        )
        device = replace(
            self.device,
            quantum=self.device.quantum if SENSOR in real else 0.0,
            max_force=self.device.max_force if LIMIT in real else math.inf,
        )
        key = tuple(effective.values.items()), effective.rate, effective.delay, effective.estimator
        loop = hand, *key, *(component in real for component in (VELOCITY, SENSOR, LIMIT))
        if loop not in self._found:
            out = self._render(effective, hand, device, VELOCITY not in real)
            found = perception.difference_under(hand_named(hand), self._reference(hand), out, self._counts)
            self._found[loop] = Felt(found.most, found.word, hand)
        return self._found[loop]

    def _render(self, way: Way, hand: str, device: SimulatedHapkit, true_velocity: bool) -> np.ndarray:
        """Return the rows at perception.RATE of a way on a device."""
        trial = fidelity.script(hand)
        device = replace(device, initial_velocity=trial.thrown)
        loop = LoopSettings(way.rate, way.delay, way.estimator)
        scene = headless.Scene(self.environment, way.values, device, loop, true_velocity=true_velocity)
        out = headless.prepare_run(scene, trial.hand, math.ceil(trial.seconds * way.rate) + 1).run()
        found = at_moments(out, way.rate, round(trial.seconds * perception.RATE))
        found[:, rows.HAND_FORCE] = _hand_force(trial.hand, found)
        return found


def at_moments(out: np.ndarray, rate: float, count: int) -> np.ndarray:
    """Return count rows at perception.RATE of rows (n, ROW_WIDTH) at a rate in Hz.

    What moves is taken on a straight line between two samples, everything else from the last sample.
    """
    moments = np.arange(count) * (rate / perception.RATE)
    before = np.minimum((moments + 1e-9).astype(int), len(out) - 1)
    found = out[before]
    for column in _MOVING:
        found[:, column] = np.interp(moments, np.arange(len(out)), out[:, column])
    return found


def _hand_force(hand: Hand, found: np.ndarray) -> np.ndarray:
    """Return the force (n,) in N of a hand on a handle that moves as in rows (n, ROW_WIDTH).

    The rows' own hand force has the target's velocity of the sample before: up to 11 mN off at 1 kHz.
    """
    t = np.arange(len(found)) / perception.RATE
    speed = (hand.target(t + _STEP) - hand.target(t - _STEP)) / (2.0 * _STEP)  # type: ignore[arg-type, operator]
    force = hand.stiffness * (hand.target(t) - found[:, rows.TRUE_POSITION])  # type: ignore[arg-type]
    return np.where(t < hand.release, force + hand.damping * (speed - found[:, rows.TRUE_VELOCITY]), 0.0)


def shapley(players: tuple[str, ...], worth: Callable[[tuple[str, ...]], float]) -> dict[str, float]:
    """Return each player's Shapley value of the worth of a coalition, named in the order of the players."""
    count = len(players)
    values = dict.fromkeys(players, 0.0)
    for player in players:
        others = tuple(p for p in players if p != player)
        for size in range(count):
            weight = math.factorial(size) * math.factorial(count - size - 1) / math.factorial(count)
            for some in combinations(others, size):
                joined = tuple(p for p in players if p in some or p == player)
                values[player] += weight * (worth(joined) - worth(some))
    return values

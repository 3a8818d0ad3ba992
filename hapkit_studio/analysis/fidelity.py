"""Model no more than a scene needs: what each term of the device and its loop changes, and what it costs.

The reference models everything. One term at a time is left out, and every outcome that the scene names is
compared under every hand that it names. What moves an outcome by more than 2 % of its scale, a third of the
smallest change of force that people feel (6 %, Jones), is needed.

Fingers hold a force to 0.3 N at best and know a length to 0.4 mm (Ho 1996); energy is measured by what went
to and fro, restitution by 1, and a count is right or wrong.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from statistics import fmean

import numpy as np

from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.hand import hand_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import LoopSettings

MOST_CHANGE = 0.02
# What the terms left out may change together: the smallest change of force that people feel.
TOGETHER = 0.06
RATE, FINE_RATE = 1000.0, 16_000.0
DELAY = 1e-3
ESTIMATOR = ("iir", {"cutoff": 35.5})
# A released handle is thrown from the middle to the right, or nothing would happen.
THROWN = 0.5
SECONDS = {
    "released": 1.0, "press": 1.5, "tap": 0.8, "stroke": 2.4, "sweep": 1.8, "hold": 0.8, "pluck": 2.0,
    "shake": 2.0, "pet": 9.6, "rub": 2.4,
}  # fmt: skip
OTHER_SECONDS = 2.0
# Of an environment that names none, a student's own.
HANDS = ("released", "press", "stroke")
USUAL_OUTCOMES = ("peak_force", "final_position", "energy")
# The shortest of some runs is what rendering takes: never fewer than these, and short ones more often.
REPEATS = 4
REPEAT_NS = 3_000_000

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Effect:
    """What leaving out one term changes most: a share of the outcome's scale, None where it was not judged.

    ns_with and ns_without are the costs in ns of a simulated second.
    """

    scene: str
    term: str
    change: float | None
    outcome: str
    hand: str
    ns_with: float
    ns_without: float

    @property
    def needed(self) -> bool:
        return self.change is not None and self.change > MOST_CHANGE


@dataclass(frozen=True)
class Fidelity:
    """A scene's effects, one a term, and what all terms that it does not need change together."""

    scene: str
    effects: tuple[Effect, ...]
    together: Effect

    @property
    def needs(self) -> tuple[str, ...]:
        """Return the terms that the scene needs."""
        return tuple(e.term for e in self.effects if e.needed)


@dataclass(frozen=True)
class _Run:
    """One run's rows, the ns it took and the seconds it simulated."""

    table: np.ndarray
    spent: int
    seconds: float

    @property
    def cost(self) -> float:
        """Return the ns of a simulated second."""
        return self.spent / self.seconds


def _holds(name: str) -> bool:
    """Return whether the hand stays on the handle and brings a mass of its own."""
    hand = hand_named(name)
    return hand.mass > 0.0 and math.isinf(hand.release)


def _scene(environment: Environment, gone: set[str], thrown: bool) -> headless.Scene:
    """Return the scene with its defaults, without some terms."""
    device = SimulatedHapkit(initial_velocity=THROWN if thrown else 0.0).without(gone)
    rate = FINE_RATE if "sampling" in gone else RATE
    loop = LoopSettings(rate, 0.0 if "delay" in gone else DELAY, ESTIMATOR)
    return headless.Scene(environment, environment.values(), device, loop, true_velocity="filter" in gone)


def _render(environment: Environment, removed: Iterable[str], name: str) -> _Run:
    """Render the scene under a hand; its last row is at the end of the time, whatever the rate."""
    gone, hand = set(removed), hand_named(name)
    if not _holds(name):
        gone.discard("mass")
    scene = _scene(environment, gone, thrown=hand.release <= 0.0)
    seconds = SECONDS.get(name, OTHER_SECONDS)
    made = headless.prepare_run(scene, hand, round(seconds * scene.loop.rate) + 1)
    made.out.fill(0.0)  # so that the time is the loop's, not the memory's
    begin = time.perf_counter_ns()
    made.run()
    spent = time.perf_counter_ns() - begin
    return _Run(made.out, spent, seconds)


def _pair(environment: Environment, removed: tuple[str, ...], name: str) -> tuple[_Run, _Run]:
    """Return the quickest run with everything and without some terms, in turns: both see the same machine."""
    pairs: list[tuple[_Run, _Run]] = []
    while len(pairs) < REPEATS or sum(a.spent + b.spent for a, b in pairs) < REPEAT_NS:
        pairs.append((_render(environment, (), name), _render(environment, removed, name)))
    quickest = [min(runs, key=lambda run: run.spent) for runs in zip(*pairs, strict=True)]
    return quickest[0], quickest[1]


class _Judge:
    """One scene's outcomes and hands, and what differs without some terms."""

    def __init__(self, environment: Environment):
        self.environment = environment
        self.hands = environment.hands or HANDS
        keys = environment.outcomes or USUAL_OUTCOMES
        self.outcomes = [outcome_named(key, environment.state_names) for key in keys]

    def effect(self, label: str, removed: Iterable[str], hands: Iterable[str]) -> Effect:
        """Return the largest change of any outcome under any of the hands."""
        gone = tuple(removed)
        pairs = {name: _pair(self.environment, gone, name) for name in hands}
        if not pairs:
            return Effect(self.environment.key, label, None, "", "", math.nan, math.nan)
        change, outcome, hand = max(self._changes(pairs))
        costs = [fmean(run.cost for run in runs) for runs in zip(*pairs.values(), strict=True)]
        return Effect(self.environment.key, label, change, outcome, hand, *costs)

    def _changes(self, pairs: dict[str, tuple[_Run, _Run]]) -> Iterator[tuple[float, str, str]]:
        for name, (reference, without) in pairs.items():
            for outcome in self.outcomes:
                if not outcome.thrown or hand_named(name).release <= 0.0:
                    yield outcome.change(reference.table, without.table), outcome.key, name


def compute(environment: Environment, progress: Progress = lambda done, of: None) -> Fidelity:
    """Return what each term changes in a scene with its defaults; raise ParameterError.

    progress is told how many of how many steps are done.
    """
    judge = _Judge(environment)
    steps = len(TERMS) + 2
    effects: list[Effect] = []
    for key in TERMS:
        progress(len(effects) + 1, steps)
        hands = filter(_holds, judge.hands) if key == "mass" else judge.hands
        effects.append(judge.effect(key, (key,), hands))
    progress(steps - 1, steps)
    together = _together(judge, [e.term for e in effects if not e.needed])
    progress(steps, steps)
    return Fidelity(environment.key, tuple(effects), together)


def _together(judge: _Judge, removed: list[str]) -> Effect:
    """Return what all these terms change; the cost is that at 1 kHz, good enough where no other is needed."""
    ideal = judge.effect("together", removed, judge.hands)
    if "sampling" not in removed:
        return ideal
    coarse = judge.effect("together", [key for key in removed if key != "sampling"], judge.hands)
    return replace(ideal, ns_with=coarse.ns_with, ns_without=coarse.ns_without)


FORCE = 0.3
LENGTH = 0.4e-3
COUNT = "count:"
# Slower than this is standing still, in m/s: what trembles while it sticks has not turned.
STANDING = 1e-3
# What is no number any more has changed more than anything that is.
MOST = 1e6


@dataclass(frozen=True)
class Outcome:
    """A run's number, taken from its rows (n, ROW_WIDTH), and the scale of a change beside a reference run.

    thrown: it means something only where the handle flies by itself.
    """

    key: str
    unit: str
    value: Callable[[np.ndarray], float]
    scale: Callable[[np.ndarray], float]
    thrown: bool = False

    def change(self, reference: np.ndarray, other: np.ndarray) -> float:
        """Return how far the other run's number is from the reference's, as a share of the scale."""
        moved = abs(self.value(other) - self.value(reference)) / self.scale(reference)
        return min(moved, MOST) if math.isfinite(moved) else MOST


def peak_force(table: np.ndarray) -> float:
    """Return the largest force in N that was applied, either way."""
    return float(np.abs(table[:, rows.APPLIED]).max())


def final_position(table: np.ndarray) -> float:
    """Return where the handle is in the end, in m."""
    return float(table[-1, rows.TRUE_POSITION])


def peak_position(table: np.ndarray) -> float:
    """Return how far from the middle the handle came, in m."""
    return float(np.abs(table[:, rows.TRUE_POSITION]).max())


def restitution(table: np.ndarray) -> float:
    """Return a thrown handle's highest speed back over its highest speed in, 0 if it stays.

    For a mass that meets a spring and damper it is exp(-2 zeta phi / sqrt(1 - zeta^2)), cos phi = zeta.
    """
    velocity = table[:, rows.TRUE_VELOCITY]
    forward_speed = velocity * np.sign(velocity[np.argmax(np.abs(velocity) > STANDING)])
    if not (forward_speed < -STANDING).any():
        return 0.0
    turn = int(np.argmax(forward_speed < -STANDING))
    return float(-forward_speed[turn:].min() / forward_speed[:turn].max())


def given_energy(table: np.ndarray) -> float:
    """Return the energy in J that the device has given to handle and hand; negative: it took that much."""
    return float(table[-1, rows.ENERGY])


def exchanged(table: np.ndarray) -> float:
    """Return the energy in J that went to and fro, at least that of a force and a length nobody feels."""
    return max(float(np.abs(np.diff(table[:, rows.ENERGY])).sum()), FORCE * LENGTH)


OUTCOMES: dict[str, Outcome] = {
    o.key: o
    for o in (
        Outcome("peak_force", "N", peak_force, lambda table: max(FORCE, peak_force(table))),
        Outcome("final_position", "m", final_position, lambda table: LENGTH),
        Outcome("peak_position", "m", peak_position, lambda table: LENGTH),
        Outcome("restitution", "", restitution, lambda table: 1.0, thrown=True),
        Outcome("energy", "J", given_energy, exchanged),
    )
}


def outcome_named(key: str, state_names: tuple[str, ...] = ()) -> Outcome:
    """Return an outcome by its key, "count:NAME" for the last value of a state; raise ParameterError."""
    if key in OUTCOMES:
        return OUTCOMES[key]
    name = key.removeprefix(COUNT)
    if name == key or name not in state_names:
        known = [*OUTCOMES, *(COUNT + state for state in state_names)]
        raise ParameterError(f"An outcome is one of {', '.join(known)}, not {key!r}.")
    column = rows.STATE + state_names.index(name)
    return Outcome(key, "", lambda table: float(table[-1, column]), lambda table: 1.0)

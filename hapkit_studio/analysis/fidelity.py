"""Model no more than is felt: what each term of the device and its loop changes, and what it costs.

The reference models everything. One term at a time is left out, and both runs are compared under every hand
that the scene names. A term is needed if a person tells them apart, by more than one just-noticeable
difference (see perception); of the others as many are left out together as nobody tells from everything.
A hand does what its script says; where that shows no difference, it also throws the handle at other speeds,
goes on for longer, and lets go at many moments: a handle that flies by itself shows what a hand hides.

Beside it stands a rule that knows no senses: what moves an outcome that the scene names by more than 2 % of
its scale. Fingers hold a force to 0.3 N at best and know a length to 0.4 mm (Ho 1996); energy is measured by
what went to and fro, restitution by 1, and a count is right or wrong.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.perception import MOMENT, difference_under
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import TERMS, SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand, hand_named
from hapkit_studio.environments.base import Environment
from hapkit_studio.errors import ParameterError
from hapkit_studio.haptics import headless, rows
from hapkit_studio.haptics.settings import LoopSettings

MOST_CHANGE = 0.02
RATE, FINE_RATE = 1000.0, 16_000.0
DELAY = 1e-3
ESTIMATOR = ("iir", {"cutoff": 35.5})
# A released handle is thrown from the middle to the right, or nothing would happen; in m/s.
THROWN = 0.5
THROWS = np.linspace(0.3, 0.7, 81)
SECONDS = {
    "released": 1.0, "press": 1.5, "tap": 0.8, "stroke": 2.4, "sweep": 1.8, "hold": 0.8, "pluck": 2.0,
    "shake": 2.0, "pet": 9.6, "rub": 2.4,
}  # fmt: skip
OTHER_SECONDS = 2.0
# The longer run, and how long the handle is watched after a hand let go, in s.
LONG, WATCHED = 3.0, 1.0
# Of an environment that names none, a student's own.
HANDS = ("released", "press", "stroke")
USUAL_OUTCOMES = ("peak_force", "final_position", "energy")
# The shortest of some runs is what rendering takes: never fewer than these, and short ones more often.
REPEATS = 4
REPEAT_NS = 3_000_000


@dataclass(frozen=True)
class Effect:
    """What leaving out one term changes most, under any hand; None where it was not judged.

    felt: in just-noticeable differences, of which sense, under which hand. change: a share of the outcome's
    scale. ns_with and ns_without are the costs in ns of a simulated second.
    """

    scene: str
    term: str
    felt: float | None
    sense: str
    hand: str
    change: float | None
    outcome: str
    ns_with: float
    ns_without: float

    @property
    def needed(self) -> bool:
        """Return whether a person tells the difference of this one alone."""
        return self.felt is not None and self.felt > 1.0

    @property
    def moves(self) -> bool:
        """Return whether an outcome moves by more than 2 % of its scale."""
        return self.change is not None and self.change > MOST_CHANGE


@dataclass(frozen=True)
class Fidelity:
    """A scene's effects, one a term, the terms that it needs, and what all others change together."""

    scene: str
    effects: tuple[Effect, ...]
    needs: tuple[str, ...]
    together: Effect


@dataclass(frozen=True)
class Trial:
    """A hand at a scene, for how many seconds, and how fast the handle starts in m/s."""

    words: str
    hand: Hand
    seconds: float
    thrown: float = 0.0

    @property
    def holds(self) -> bool:
        """Return whether the hand stays on the handle and brings a mass of its own."""
        return self.hand.mass > 0.0 and math.isinf(self.hand.release)


def script(name: str) -> Trial:
    """Return what a named hand does."""
    hand = hand_named(name)
    return Trial(name, hand, SECONDS.get(name, OTHER_SECONDS), THROWN if hand.release <= 0.0 else 0.0)


def variants(name: str) -> Iterator[Trial]:
    """Yield what else a named hand may do: throw at other speeds; go on for longer, let go at some moment."""
    usual = script(name)
    if usual.thrown:
        for speed in THROWS:
            yield Trial(f"thrown {speed:.3g} m/s", usual.hand, LONG, speed)
        return
    if usual.seconds < LONG:
        yield replace(usual, words=f"{name} for {LONG:g} s", seconds=LONG)
    for moment in np.arange(MOMENT, usual.seconds, MOMENT):
        let_go = replace(usual.hand, release=moment)
        yield Trial(f"{name} until {moment:.3g} s", let_go, moment + WATCHED)


def _render(environment: Environment, removed: Iterable[str], trial: Trial) -> tuple[int, np.ndarray]:
    """Render the scene with its defaults, without some terms, in a trial; return its ns, rows at RATE.

    The last row is at the end of the time.
    """
    gone = set(removed)
    if not trial.holds:
        gone.discard("mass")
    device = SimulatedHapkit(initial_velocity=trial.thrown).without(gone)
    rate = FINE_RATE if "sampling" in gone else RATE
    loop = LoopSettings(rate, 0.0 if "delay" in gone else DELAY, ESTIMATOR)
    values, true = environment.values(), "filter" in gone
    scene = headless.Scene(environment, values, device, loop, true_velocity=true)
    made = headless.prepare_run(scene, trial.hand, round(trial.seconds * rate) + 1)
    begin = time.perf_counter_ns()
    made.run()
    return time.perf_counter_ns() - begin, made.out[:: round(rate / RATE)]


def _told(
    trial: Trial, reference: np.ndarray, other: np.ndarray, counts: list[int]
) -> tuple[float, str, str]:
    """Return the largest difference that is felt in a trial, as which sense, in which trial."""
    found = difference_under(trial.hand, reference, other, counts)
    return found.most, found.word, trial.words


def _effect(environment: Environment, label: str, removed: Iterable[str], hands: Iterable[str]) -> Effect:
    """Return the largest difference under any of the hands where some terms are left out.

    Costs are those of the quickest runs with everything and without the terms, in turns: both see the same
    machine.
    """
    keys, gone = environment.outcomes or USUAL_OUTCOMES, tuple(removed)
    outcomes = [outcome_named(key, environment.state_names) for key in keys]
    counts = [o.column for o in outcomes if o.column is not None]
    changes: list[tuple[float, str]] = []
    felt: list[tuple[float, str, str]] = []
    costs = []
    for trial in map(script, hands):
        pairs: list[tuple] = []
        while len(pairs) < REPEATS or sum(ns for pair in pairs for ns, _ in pair) < REPEAT_NS:
            pairs.append((_render(environment, (), trial), _render(environment, gone, trial)))
        (_, reference), (_, without) = pairs[0]
        felt.append(_told(trial, reference, without, counts))
        changes += [(o.change(reference, without), o.key) for o in outcomes if trial.thrown or not o.thrown]
        costs.append([min(ns for ns, _ in runs) / trial.seconds for runs in zip(*pairs, strict=True)])
    if not costs:
        return Effect(environment.key, label, None, "", "", None, "", math.nan, math.nan)
    if max(felt)[0] <= 1.0:
        for trial in (variant for name in hands for variant in variants(name)):
            (_, reference), (_, without) = (_render(environment, terms, trial) for terms in ((), gone))
            felt.append(_told(trial, reference, without, counts))
    cost = np.mean(costs, axis=0).tolist()
    return Effect(environment.key, label, *max(felt), *max(changes, default=(None, "")), *cost)


def compute(environment: Environment, progress: Progress = no_progress) -> Fidelity:
    """Return what each term changes in a scene with its defaults; raise ParameterError.

    progress is told how many of how many steps are done.
    """
    hands, steps = environment.hands or HANDS, len(TERMS) + 2
    effects: list[Effect] = []
    for key in TERMS:
        progress(len(effects) + 1, steps)
        held = [name for name in hands if key != "mass" or script(name).holds]
        effects.append(_effect(environment, key, (key,), held))
    progress(steps - 1, steps)
    spare = sorted((e for e in effects if not e.needed), key=lambda e: e.felt or 0.0)
    together = _effect(environment, "together", (e.term for e in spare), hands)
    while together.needed:
        spare.pop()
        together = _effect(environment, "together", (e.term for e in spare), hands)
    removed = {e.term for e in spare}
    if "sampling" in removed:  # the cost is that at 1 kHz, good enough where no other is needed
        coarse = _effect(environment, "together", removed - {"sampling"}, hands)
        together = replace(together, ns_with=coarse.ns_with, ns_without=coarse.ns_without)
    progress(steps, steps)
    needs = tuple(key for key in TERMS if key not in removed)
    return Fidelity(environment.key, tuple(effects), needs, together)


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

    thrown: it means something only where the handle flies by itself; column: of the rows, where it counts.
    """

    key: str
    value: Callable[[np.ndarray], float]
    scale: Callable[[np.ndarray], float]
    thrown: bool = False
    column: int | None = None

    def change(self, reference: np.ndarray, other: np.ndarray) -> float:
        """Return how far the other run's number is from the reference's, as a share of the scale."""
        moved = abs(self.value(other) - self.value(reference)) / self.scale(reference)
        return min(moved, MOST) if math.isfinite(moved) else MOST


def _last(column: int) -> Callable[[np.ndarray], float]:
    return lambda table: float(table[-1, column])


def _largest(column: int) -> Callable[[np.ndarray], float]:
    return lambda table: float(np.abs(table[:, column]).max())


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


def exchanged(table: np.ndarray) -> float:
    """Return the energy in J that went to and fro, at least that of a force and a length nobody feels."""
    return max(float(np.abs(np.diff(table[:, rows.ENERGY])).sum()), FORCE * LENGTH)


_PEAK = _largest(rows.APPLIED)
OUTCOMES: dict[str, Outcome] = {
    o.key: o
    for o in (
        Outcome("peak_force", _PEAK, lambda table: max(FORCE, _PEAK(table))),
        Outcome("final_position", _last(rows.TRUE_POSITION), lambda table: LENGTH),
        Outcome("peak_position", _largest(rows.TRUE_POSITION), lambda table: LENGTH),
        Outcome("restitution", restitution, lambda table: 1.0, thrown=True),
        Outcome("energy", _last(rows.ENERGY), exchanged),
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
    return Outcome(key, _last(column), lambda table: 1.0, column=column)

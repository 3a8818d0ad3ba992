"""Model no more than a scene needs: what each term of the device and its loop changes, and what it costs.

The reference models everything. One term at a time is left out, and every outcome that the scene names is
compared under every hand that it names. What moves an outcome by more than 2 % of its scale, a third of the
smallest change of force that people feel (6 %, Jones), is needed.

Fingers hold a force to 0.3 N at best and know a length to 0.4 mm (Ho 1996); energy is measured by what went
to and fro, restitution by 1, and a count is right or wrong.
"""

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio.analysis.sweeps import Progress, no_progress
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


def _holds(name: str) -> bool:
    """Return whether the hand stays on the handle and brings a mass of its own."""
    hand = hand_named(name)
    return hand.mass > 0.0 and math.isinf(hand.release)


def _render(environment: Environment, removed: Iterable[str], name: str) -> tuple[int, np.ndarray]:
    """Render the scene with its defaults, without some terms, under a hand; return its ns and rows.

    The last row is at the end of the time, whatever the rate.
    """
    gone, hand = set(removed), hand_named(name)
    if not _holds(name):
        gone.discard("mass")
    device = SimulatedHapkit(initial_velocity=THROWN if hand.release <= 0.0 else 0.0).without(gone)
    rate = FINE_RATE if "sampling" in gone else RATE
    loop = LoopSettings(rate, 0.0 if "delay" in gone else DELAY, ESTIMATOR)
    values, true = environment.values(), "filter" in gone
    scene = headless.Scene(environment, values, device, loop, true_velocity=true)
    made = headless.prepare_run(scene, hand, round(SECONDS.get(name, OTHER_SECONDS) * rate) + 1)
    begin = time.perf_counter_ns()
    made.run()
    return time.perf_counter_ns() - begin, made.out


def _effect(environment: Environment, label: str, removed: Iterable[str], hands: Iterable[str]) -> Effect:
    """Return the largest change of any outcome under any of the hands where some terms are left out.

    Costs are those of the quickest runs with everything and without the terms, in turns: both see the same
    machine.
    """
    keys, gone = environment.outcomes or USUAL_OUTCOMES, tuple(removed)
    outcomes = [outcome_named(key, environment.state_names) for key in keys]
    changes: list[tuple[float, str, str]] = []
    costs = []
    for name in hands:
        pairs: list[tuple] = []
        while len(pairs) < REPEATS or sum(ns for pair in pairs for ns, _ in pair) < REPEAT_NS:
            pairs.append((_render(environment, (), name), _render(environment, gone, name)))
        thrown = hand_named(name).release <= 0.0
        (_, reference), (_, without) = pairs[0]
        changes += [(o.change(reference, without), o.key, name) for o in outcomes if thrown or not o.thrown]
        seconds = SECONDS.get(name, OTHER_SECONDS)
        costs.append([min(ns for ns, _ in runs) / seconds for runs in zip(*pairs, strict=True)])
    if not costs:
        return Effect(environment.key, label, None, "", "", math.nan, math.nan)
    return Effect(environment.key, label, *max(changes), *np.mean(costs, axis=0).tolist())


def compute(environment: Environment, progress: Progress = no_progress) -> Fidelity:
    """Return what each term changes in a scene with its defaults; raise ParameterError.

    progress is told how many of how many steps are done.
    """
    hands, steps = environment.hands or HANDS, len(TERMS) + 2
    effects: list[Effect] = []
    for key in TERMS:
        progress(len(effects) + 1, steps)
        held = [name for name in hands if key != "mass" or _holds(name)]
        effects.append(_effect(environment, key, (key,), held))
    progress(steps - 1, steps)
    removed = [e.term for e in effects if not e.needed]
    together = _effect(environment, "together", removed, hands)
    if "sampling" in removed:  # the cost is that at 1 kHz, good enough where no other is needed
        coarse = _effect(environment, "together", [key for key in removed if key != "sampling"], hands)
        together = replace(together, ns_with=coarse.ns_with, ns_without=coarse.ns_without)
    progress(steps, steps)
    return Fidelity(environment.key, tuple(effects), together)


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
    value: Callable[[np.ndarray], float]
    scale: Callable[[np.ndarray], float]
    thrown: bool = False

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
    return Outcome(key, _last(rows.STATE + state_names.index(name)), lambda table: 1.0)

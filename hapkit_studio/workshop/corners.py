"""The first calls of a law, over the corners of its parameters and of what the loop can see."""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hapkit_studio.environments.base import Environment
from hapkit_studio.parameters import AnyParameter, Choice

CALLS = 10_000
PERIODS = (1e-3, 1e-4, 1e-2)
FAR, FAST, QUANTUM = 0.06, 3.0, 20.7e-6
POSITIONS = (0.005, -0.005, 0.03, -0.03, FAR, -FAR)
SPEEDS = (0.0, 0.1, -0.1, FAST, -FAST)
_RESTING, _STEPS, _WANDER = 5, 8, 100
_MOST_BY_CHANCE = 400

Values = dict[str, float]


@dataclass(frozen=True)
class Sequence:
    """Calls in a row with one state: parameters by key, x in m and v in m/s (n,), the period in s."""

    values: Values
    x: np.ndarray
    v: np.ndarray
    dt: float


def sequences(environment: Environment) -> Iterator[Sequence]:
    """Yield sequences of CALLS calls or more, those nearest the defaults first.

    Values that do not go together, as the environment itself says, are left out.
    """
    parameters, calls = environment.parameters, 0
    for values in filter(lambda v: not environment.check(v), near(parameters)):
        for dt in PERIODS:
            x, v = visits(places(parameters, values), dt)
            yield Sequence(values, x, v, dt)
            calls += len(x)
    chance = random.Random(1)
    for turn in range(_MOST_BY_CHANCE):
        values = {p.key: chance.choice([*_ends(p), p.default]) for p in parameters}
        if calls < CALLS and not environment.check(values):
            dt = PERIODS[turn % len(PERIODS)]
            x, v = wander(chance, dt)
            yield Sequence(values, x, v, dt)
            calls += len(x)


def near(parameters: tuple[AnyParameter, ...]) -> Iterator[Values]:
    """Yield the defaults, then one parameter at a limit, then all of them at their low and high ones."""
    start = {p.key: p.default for p in parameters}
    yield start
    for p in parameters:
        yield from ({**start, p.key: value} for value in _ends(p) if value != p.default)
    if len(parameters) > 1:
        yield {p.key: p.low for p in parameters}
        yield {p.key: p.high for p in parameters}


def places(parameters: tuple[AnyParameter, ...], values: Values) -> list[float]:
    """Return positions worth a look: where a parameter is a length, there too."""
    own = [sign * values[p.key] for p in parameters if p.unit == "m" for sign in (1.0, -1.0)]
    return list(dict.fromkeys([*(x for x in own if abs(x) <= FAR), *POSITIONS]))


def visits(at: list[float], dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x in m and v in m/s (n,): rest, every place at every speed, sensor steps across each, rest."""
    x, v = [0.0] * _RESTING, [0.0] * _RESTING
    for place in at:
        x += [place] * len(SPEEDS)
        v += SPEEDS
    for place in at:
        x += [place + QUANTUM * (i - _STEPS // 2) for i in range(_STEPS)]
        v += [QUANTUM / dt] * _STEPS
    return np.array(x + [x[-1]] * _RESTING), np.array(v + [0.0] * _RESTING)


def wander(chance: random.Random, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x in m and v in m/s (n,) of a handle swung at random, as a sensor of whole counts sees it."""
    swing, rate, phase = chance.uniform(0.001, FAR), chance.uniform(0.5, 8.0), chance.uniform(0.0, math.tau)
    t = dt * np.arange(_WANDER)
    x = QUANTUM * np.floor(swing * np.sin(math.tau * rate * t + phase) / QUANTUM)
    return x, np.clip(np.diff(x, prepend=x[0]) / dt, -FAST, FAST)


def _ends(p: AnyParameter) -> list[float]:
    return [float(i) for i in range(len(p.options))] if isinstance(p, Choice) else [p.low, p.high]

"""The just-noticeable difference of a person, measured by comparisons in an adaptive staircase.

Each comparison has two intervals in random order: one renders a base value, the other the base plus a step.
The person says in which interval the value is larger. The step falls after three right answers in a row and
rises after a wrong one, which converges on 79.4 % right answers (Levitt 1971, from memory). The threshold is
the step with this fraction of right answers under a Weibull function. Its estimate is the median of the
posterior from all answers, and its interval is the central 95 %; the priors of the logarithms of threshold
and slope are uniform. (A profile-likelihood interval contained the true threshold in only 85 % of simulated
runs.)
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np

from hapkit_studio.errors import FileError
from hapkit_studio.files import checked_integer, checked_number, checked_text

COMPARISON = "comparison"
"""The kind of a session's event that contains an answer."""
UNITS = ("N/m", "N·s/m", "N")
"""Units of the parameters that are proportional to the force of a given movement."""
RIGHT_IN_A_ROW = 3
CONVERGES = 0.5 ** (1.0 / RIGHT_IN_A_ROW)
"""Fraction of right answers at the threshold."""
FIRST = 0.5  # step of the first comparison, as a fraction of the base
LARGEST, SMALLEST = 1.0, 0.005  # limits of the step, as fractions of the base
COARSE, FINE = 2.0, math.sqrt(2.0)  # factors of the step before and after the first reversals
COARSE_REVERSALS = 2
REVERSALS, MEAN_OF = 12, 6  # reversals in a run; the geometric mean of the last ones is Levitt's threshold
MOST_ANSWERS = 120  # largest number of answers in a run
LAPSES = 0.02  # fraction of answers that do not depend on the step
# slopes of the Weibull function that are tried; a comparison of noisy impressions has a slope of 1.3
_SLOPES = np.geomspace(0.7, 4.0, 17)
# number of thresholds tried, from the smallest step / _BEYOND to the largest step × _BEYOND
_THRESHOLDS = 400
_BEYOND = 8.0
_CENTRAL = 0.025, 0.5, 0.975  # quantiles of the posterior: low, value, high
_MOST = 10_000  # largest number of answers in a file


class Staircase:
    """A three-down one-up staircase; ``step`` is the next step, between SMALLEST and ``largest``."""

    def __init__(self, first: float = FIRST, largest: float = LARGEST):
        self._largest = largest
        self.step = min(first, largest)
        self.reversals: list[float] = []
        self.answers = self._row = self._direction = 0

    @property
    def finished(self) -> bool:
        """Return True if no more comparison is needed."""
        return len(self.reversals) >= REVERSALS or self.answers >= MOST_ANSWERS

    def answer(self, right: bool) -> None:
        """Record an answer, and choose the next step."""
        self.answers += 1
        self._row = self._row + 1 if right else 0
        if right and self._row < RIGHT_IN_A_ROW:
            return
        direction = -1 if right else 1
        if direction == -self._direction:
            self.reversals.append(self.step)
        self._direction, self._row = direction, 0
        factor = COARSE if len(self.reversals) < COARSE_REVERSALS else FINE
        self.step = min(max(self.step * factor**direction, SMALLEST), self._largest)


@dataclass(frozen=True)
class Comparison:
    """One answer: the compared parameter, with base and step in SI units.

    ``more`` is the interval with the larger value, and ``chosen`` the interval that the person chose.
    ``reversal`` is True if the staircase changed its direction at this answer.
    """

    environment: str
    parameter: str
    unit: str
    base: float
    step: float
    more: int
    chosen: int
    reversal: bool = False

    @property
    def right(self) -> bool:
        """Return True if the answer is right."""
        return self.more == self.chosen


# --- events


def event(one: Comparison) -> dict[str, Any]:
    """Return an answer as an event of a session."""
    return asdict(one)


def comparisons(events: Iterable[Mapping[str, Any]], name: str = "") -> list[Comparison]:
    """Return the answers among a session's events; raise FileError for a wrong value."""
    found: list[Comparison] = []
    for at, what in enumerate(events, 1):
        place = f"{name}: comparison {at}".lstrip(": ")
        checked_integer(at, place, 1, _MOST)
        environment, parameter, unit = (
            checked_text(what.get(key), f"{place}: {key}", 100)
            for key in ("environment", "parameter", "unit")
        )
        base, step = (checked_number(what.get(key), f"{place}: {key}", 1e-9, 1e9) for key in ("base", "step"))
        more, chosen = (checked_integer(what.get(key), f"{place}: {key}", 1, 2) for key in ("more", "chosen"))
        turned = what.get("reversal", False)
        if not isinstance(turned, bool):
            raise FileError(f"{place}: reversal must be true or false.")
        found.append(Comparison(environment, parameter, unit, base, step, more, chosen, turned))
    return found


# --- results


class Bounds(NamedTuple):
    """An estimate and its 95 % interval."""

    value: float
    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Return True if a value is inside the interval."""
        return self.low <= value <= self.high

    def over(self, base: float) -> "Bounds":
        """Return the estimate as a fraction of the base."""
        return Bounds(*(value / base for value in self))


@dataclass(frozen=True)
class Threshold:
    """A person's threshold of a parameter, in its SI unit, from all answers at one base.

    ``reversals`` is the geometric mean of the last steps at which the staircase reversed; it is NaN with
    fewer than MEAN_OF reversals.
    """

    environment: str
    parameter: str
    unit: str
    base: float
    threshold: Bounds
    reversals: float
    answers: tuple[Comparison, ...] = field(repr=False)

    @property
    def weber(self) -> Bounds:
        """Return the Weber fraction, which is the threshold over the base."""
        return self.threshold.over(self.base)

    @property
    def right(self) -> int:
        """Return the number of right answers."""
        return sum(one.right for one in self.answers)


def evaluate(found: Sequence[Comparison]) -> list[Threshold]:
    """Return a threshold for each parameter and base, in the order of their first answers."""
    kinds = dict.fromkeys((one.environment, one.parameter, one.unit, one.base) for one in found)
    return [
        _threshold(kind, [o for o in found if (o.environment, o.parameter, o.unit, o.base) == kind])
        for kind in kinds
    ]


def _threshold(kind: tuple[str, str, str, float], found: Sequence[Comparison]) -> Threshold:
    threshold = fit([one.step for one in found], [one.right for one in found])
    turned = [one.step for one in found if one.reversal][-MEAN_OF:]
    mean = math.exp(float(np.mean(np.log(turned)))) if len(turned) == MEAN_OF else math.nan
    return Threshold(*kind, threshold, mean, tuple(found))


def right_share(step: np.ndarray | float, threshold: np.ndarray | float, slope: np.ndarray | float) -> Any:
    """Return the probability of a right answer; at the threshold it equals ``CONVERGES``.

    The fraction of guesses is ``LAPSES``.
    """
    reach = 0.5 - 0.5 * LAPSES
    at = -math.log(1.0 - (CONVERGES - 0.5) / reach)
    return 0.5 + reach * -np.expm1(-at * (step / threshold) ** slope)


def fit(steps: Sequence[float], right: Sequence[bool]) -> Bounds:
    """Return the threshold with its interval from the posterior, in the unit of the steps."""
    levels, places = np.unique(np.asarray(steps, float), return_inverse=True)
    wins = np.bincount(places, np.asarray(right, float))
    losses = np.bincount(places) - wins
    tried = np.geomspace(levels[0] / _BEYOND, levels[-1] * _BEYOND, _THRESHOLDS)
    share = right_share(levels, tried[:, None, None], _SLOPES[:, None])
    score = (wins * np.log(share) + losses * np.log1p(-share)).sum(axis=2)
    posterior = np.exp(score - score.max()).sum(axis=1)
    low, value, high = np.interp(_CENTRAL, np.cumsum(posterior) / posterior.sum(), tried)
    return Bounds(float(value), float(low), float(high))


# --- the virtual observer


@dataclass(frozen=True)
class Observer:
    """An observer that compares two noisy impressions and is right with probability Φ(Δ/(σ√2)).

    Δ is the step. ``noise`` is σ as a fraction of the base (Green and Swets, from memory).
    """

    noise: float = 0.10

    def share(self, step: float) -> float:
        """Return the probability of a right answer for a step as a fraction of the base."""
        return 0.5 * math.erfc(-step / (2.0 * self.noise))

    @property
    def threshold(self) -> float:
        """Return the step at which a right answer has probability CONVERGES, as a fraction of the base."""
        from scipy.stats import norm  # imported here because it is slow

        return float(math.sqrt(2.0) * self.noise * norm.ppf(CONVERGES))

    def run(self, base: float, chance: np.random.Generator) -> list[Comparison]:
        """Return the answers of a whole staircase about a base stiffness in N/m."""
        stairs, found = Staircase(), list[Comparison]()
        while not stairs.finished:
            step, more = stairs.step, int(chance.integers(1, 3))
            right, turns = bool(chance.random() < self.share(step)), len(stairs.reversals)
            stairs.answer(right)
            chosen = more if right else 3 - more
            turned = len(stairs.reversals) > turns
            found.append(Comparison("spring", "stiffness", "N/m", base, step * base, more, chosen, turned))
        return found

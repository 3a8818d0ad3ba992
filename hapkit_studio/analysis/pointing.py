"""Pointing experiment: how friction changes the time of a movement to a target (Richard and Cutkosky 2000).

A plan consists of several rounds. Each round contains every condition in a random order, and for each
condition every pair of distance and width once. A trial ends when the handle rests. Its movement time is
fitted to the index of difficulty log2(D/W + 1) (Shannon form, MacKenzie and Buxton 1992). The effective width
is 4.133 standard deviations of the end points (ISO 9241-411, from memory). With few trials the logarithm of
the effective width has a bias, which is removed.
"""

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from hapkit_studio.environments.friction import MODELS
from hapkit_studio.files import checked_integer, checked_number, checked_text

POINTING = "pointing"
"""The kind of a session's event that contains a trial."""
ENVIRONMENT = "friction"
DISTANCES = (0.010, 0.020, 0.040)  # m: from the middle of the start to the middle of the target
WIDTHS = (0.002, 0.004, 0.008)  # m
ROUNDS = 4
NONE, LOW, HIGH = 0.0, 0.5, 1.5  # N: friction force
MODEL = "tether"  # friction model of the conditions *low* and *high*
START_WIDTH = 0.004  # m: width of the area in which a movement begins

REST_SECONDS, REST_RANGE = 0.3, 0.0005  # s, m: a handle rests if it stays within this range for this time
SLOWEST = 0.005  # m/s: smallest peak speed of a movement; slower motions are ignored
LONGEST = 6.0  # s: longest time of a movement
HOLD = 0.6, 1.2  # s: range of the random time that the person waits at the start before the target is shown
_LONGEST_TRIAL = 30.0  # s: longest trial that is accepted from a file, because all its samples are read
_LEFT = 0.25  # fraction of the distance after which the handle has left the start
_GAP = 0.1  # s: longest time between two samples
EFFECTIVE = 4.133  # width that contains 96 % of a normal distribution, in standard deviations
FEWEST_CELLS = 3  # pairs of distance and width; a line through two points has no confidence interval
_MOST_TRIALS = 2_000  # largest number of trials in a file
# the start of a movement is extrapolated from the times of these fractions of the peak speed
_FITTED = 0.05, 0.20
_SMOOTHED = 0.3  # window of the speed's polynomial, as a fraction of the time from 10 % to 90 % of the way


@dataclass(frozen=True)
class Condition:
    """A friction condition: the name in tables, the model's key, and the level in N."""

    name: str
    model: str
    force: float

    @property
    def values(self) -> dict[str, Any]:
        """Return the values of the environment *friction*."""
        return {
            "model": self.model,
            "kinetic_force": self.force,
            "static_force": self.force,
            "viscous": 0.0,
        }


CONDITIONS = Condition("none", MODEL, NONE), Condition("low", MODEL, LOW), Condition("high", MODEL, HIGH)
BY_MODEL = CONDITIONS[0], *(Condition(model, model, LOW) for model in MODELS)
"""No friction, and every model at the low level."""


def difficulty(distance: float, width: float) -> float:
    """Return the index of difficulty in bit."""
    return math.log2(distance / width + 1.0)


@dataclass(frozen=True)
class Target:
    """A planned trial: distance and width in m; ``side`` is 1 to the right, -1 to the left."""

    condition: Condition
    distance: float
    width: float
    side: int

    @property
    def start(self) -> float:
        """Return the middle of the start in m."""
        return -0.5 * self.side * self.distance

    @property
    def middle(self) -> float:
        """Return the middle of the target in m."""
        return 0.5 * self.side * self.distance


def plan(
    conditions: Sequence[Condition] = CONDITIONS,
    distances: Sequence[float] = DISTANCES,
    widths: Sequence[float] = WIDTHS,
    rounds: int = ROUNDS,
    seed: int | None = None,
) -> list[Target]:
    """Return the trials in random order; an even number of rounds also balances the two sides."""
    chance = np.random.default_rng(seed)
    cells = list(product(distances, widths))
    first = chance.choice((-1, 1), (len(conditions), len(cells)))
    found: list[Target] = []
    for turn in range(rounds):
        for at in chance.permutation(len(conditions)):
            for cell in chance.permutation(len(cells)):
                side = int(first[at, cell]) * (-1) ** turn
                distance, width = cells[cell]
                found.append(Target(conditions[at], distance, width, side))
    return found


@dataclass(frozen=True)
class Trial:
    """A movement: start, target and end in m, and its duration in s.

    The samples between ``begin`` and ``stop``, in s of the recording computer's clock, contain the movement.
    """

    condition: str
    model: str
    force: float
    distance: float
    width: float
    start: float
    target: float
    seconds: float
    end: float
    begin: float
    stop: float

    @property
    def deviation(self) -> float:
        """Return how far in m the movement ended beyond the target's middle; negative if it ended before."""
        return math.copysign(1.0, self.target - self.start) * (self.end - self.target)

    @property
    def missed(self) -> bool:
        """Return True if the movement ended outside the target."""
        return abs(self.deviation) > 0.5 * self.width


# --- one movement


class Movement(NamedTuple):
    """A movement's duration in s, its end in m, and the times in s at which it begins and ends."""

    seconds: float
    end: float
    begin: float
    stop: float


def movement(time: np.ndarray, position: np.ndarray) -> Movement | None:
    """Return the movement in samples (n,) in s and m that start and end at rest; None without a movement.

    Start and end are extrapolated from the times at which the speed crosses 5 % and 20 % of its peak. This is
    exact for a minimum-jerk movement, whose speed is 30 D/T τ²(1 − τ)² (Flash and Hogan 1985, from memory).
    Small corrections at the end do not change the extrapolation. The end point is the mean position of the
    last REST_SECONDS.
    """
    from scipy.signal import savgol_filter  # imported here because it is slow

    if len(time) < 2:
        return None
    period = float(np.median(np.diff(time)))
    if not period > 0.0:
        return None
    even = np.arange(time[0], time[-1] + 0.5 * period, period)
    place = np.interp(even, time, position)
    share = np.abs(place - place[0]) / max(abs(place[-1] - place[0]), 1e-9)
    # time from 10 % to 90 % of the way
    inner = period * (int(np.argmax(share > 0.9)) - int(np.argmax(share > 0.1)))
    window = 2 * round(0.5 * _SMOOTHED * inner / period) + 1
    if window < 5 or len(even) < 2 * window:
        return None
    speed = np.abs(savgol_filter(place, window, 4, deriv=1, delta=period, mode="nearest"))
    peak = float(speed.max())
    if peak <= SLOWEST:
        return None
    begin, stop = (forward * _start(forward * even[::forward], speed[::forward], peak) for forward in (1, -1))
    if not begin < stop:
        return None
    return Movement(stop - begin, float(position[time >= time[-1] - REST_SECONDS].mean()), begin, stop)


def _start(time: np.ndarray, speed: np.ndarray, peak: float) -> float:
    """Return the time at which a movement starts.

    With reversed samples and negative times, the result is the negative time at which the movement ends.
    """
    low, high = (_crossing(time, speed, share * peak) for share in _FITTED)
    first, second = (0.5 - math.sqrt(0.25 - 0.25 * math.sqrt(share)) for share in _FITTED)
    moving = first / (1.0 - 2.0 * first) * (float(time[np.flatnonzero(speed > _FITTED[0] * peak)[-1]]) - low)
    return low - min(first / (second - first) * (high - low), moving)


def _crossing(time: np.ndarray, speed: np.ndarray, level: float) -> float:
    """Return the time at which the speed first exceeds the level, by linear interpolation."""
    at = int(np.argmax(speed > level))
    if at == 0:
        return float(time[0])
    share = (level - speed[at - 1]) / (speed[at] - speed[at - 1])
    return float(time[at - 1] + share * (time[at] - time[at - 1]))


def rests(time: np.ndarray, position: np.ndarray) -> bool:
    """Return True if the last REST_SECONDS of samples (n,) are at rest."""
    if not len(time) or time[-1] - time[0] < REST_SECONDS:
        return False
    return float(np.ptp(position[time >= time[-1] - REST_SECONDS])) < REST_RANGE


def trial(target: Target, time: np.ndarray, position: np.ndarray) -> Trial | None:
    """Return the trial of a target from its samples (n,) in s and m; None if the handle did not move."""
    found = movement(time, position)
    if found is None:
        return None
    one = target.condition
    start = float(position[time <= max(found.begin, float(time[0]))].mean())
    return Trial(
        one.name, one.model, one.force, target.distance, target.width, start, target.middle, found.seconds,
        found.end, float(time[0]), float(time[-1]),
    )  # fmt: skip


class Run:
    """Leads a person through the trials: the person stays at the start, sees the target, and moves to it.

    ``going`` is True while the target is shown. ``done`` contains the trials so far. A trial is repeated if
    it takes longer than LONGEST or if samples are missing; a trial that takes too long is repeated at the
    end.
    """

    def __init__(self, targets: Sequence[Target], seed: int | None = None):
        self._left, self._chance = deque(targets), np.random.default_rng(seed)
        self.done: list[Trial] = []
        self.count = len(targets)
        self.restart()

    @property
    def target(self) -> Target | None:
        """Return the next target; None after the last one."""
        return self._left[0] if self._left else None

    def restart(self) -> None:
        """Begin the current trial again."""
        self.going = False
        self._wait = float(self._chance.uniform(*HOLD))
        self._time, self._place = np.empty(0), np.empty(0)

    def feed(self, time: np.ndarray, place: np.ndarray) -> Trial | None:
        """Add new samples (n,) in s and m; return the trial if these samples end it, else None."""
        target = self.target
        if target is None or not len(time):
            return None
        if len(self._time) and time[0] - self._time[-1] > _GAP:
            self.restart()
        self._time, self._place = np.append(self._time, time), np.append(self._place, place)
        if self.going:
            return self._end(target)
        kept = self._time >= self._time[-1] - self._wait
        held = float(self._time[-1] - self._time[0]) >= self._wait
        self._time, self._place = self._time[kept], self._place[kept]
        self.going = held and bool((np.abs(self._place - target.start) <= 0.5 * START_WIDTH).all())
        return None

    def _end(self, target: Target) -> Trial | None:
        """Return the trial if its movement has ended."""
        if self._time[-1] - self._time[0] > LONGEST:
            self._left.rotate(-1)
            self.restart()
            return None
        left = abs(self._place[-1] - self._place[0]) >= _LEFT * target.distance
        if not left or not rests(self._time, self._place):
            return None
        found = trial(target, self._time, self._place)
        if found is not None:
            self.done.append(found)
            self._left.popleft()
        self.restart()
        return found


# --- events


def event(one: Trial) -> dict[str, Any]:
    """Return a trial as an event of a session."""
    return asdict(one)


def trials(events: Iterable[Mapping[str, Any]], name: str = "") -> list[Trial]:
    """Return the trials among a session's events of kind POINTING; raise FileError for a wrong value."""
    found: list[Trial] = []
    for at, what in enumerate(events, 1):
        place = f"{name}: pointing trial {at}".lstrip(": ")
        checked_integer(at, place, 1, _MOST_TRIALS)
        condition = checked_text(what.get("condition"), f"{place}: condition", 40)
        model = checked_text(what.get("model"), f"{place}: model", 40)
        numbers = {
            key: checked_number(what.get(key), f"{place}: {key}", *limits) for key, limits in _LIMITS.items()
        }
        seconds = numbers["stop"] - numbers["begin"]
        checked_number(seconds, f"{place}: time from start to stop", 0.0, _LONGEST_TRIAL, "s")
        found.append(Trial(condition, model, **numbers))
    return found


_PLACE, _CLOCK = (-1.0, 1.0, "m"), (-1e9, 1e9, "s")
_LIMITS: dict[str, tuple[float, float, str]] = {
    "force": (0.0, 100.0, "N"),
    "distance": (1e-4, 1.0, "m"),
    "width": (1e-5, 1.0, "m"),
    "start": _PLACE,
    "target": _PLACE,
    "seconds": (0.01, 60.0, "s"),
    "end": _PLACE,
    "begin": _CLOCK,
    "stop": _CLOCK,
}


# --- results


class Interval(NamedTuple):
    """An estimate and half of its 95 % interval; NaN if there are too few measurements."""

    value: float
    half: float

    def holds(self, value: float) -> bool:
        """Return True if a value is inside the interval."""
        return abs(value - self.value) <= self.half


def mean(values: Sequence[float] | np.ndarray) -> Interval:
    """Return the mean with its interval by Student's t."""
    from scipy.stats import sem, t  # imported here because it is slow

    count = len(values)
    if count < 2:
        return Interval(float(values[0]) if count else math.nan, math.nan)
    return Interval(float(np.mean(values)), float(t.ppf(0.975, count - 1) * sem(values)))


@dataclass(frozen=True)
class Cell:
    """The trials of one distance and width: their number, mean time in s, misses, effective width in m.

    ``effective_difficulty`` in bit is computed from the mean distance covered and the effective width.
    """

    distance: float
    width: float
    count: int
    seconds: float
    missed: int
    effective_width: float
    effective_difficulty: float

    @property
    def difficulty(self) -> float:
        """Return the index of difficulty in bit."""
        return difficulty(self.distance, self.width)


@dataclass(frozen=True)
class Line:
    """The results of one condition: MT = intercept + slope·ID, in s and s/bit, and the fit's r².

    ``throughput`` is in bit/s. ``change`` is the relative change of the time from the first condition.
    """

    condition: str
    model: str
    force: float
    cells: tuple[Cell, ...]
    intercept: Interval
    slope: Interval
    fit: float
    throughput: Interval
    change: Interval

    @property
    def count(self) -> int:
        """Return the number of trials."""
        return sum(cell.count for cell in self.cells)

    @property
    def missed(self) -> int:
        """Return the number of trials that ended outside the target."""
        return sum(cell.missed for cell in self.cells)


def evaluate(found: Sequence[Trial]) -> list[Line]:
    """Return the results of each condition in the order of force; the first one is the reference."""
    conditions = {(one.condition, one.model, one.force): None for one in found}
    ordered = sorted(conditions, key=lambda key: key[2])
    results: list[Line] = []
    for key in ordered:
        own = [one for one in found if (one.condition, one.model, one.force) == key]
        results.append(_line(key, own, results[0] if results else None))
    return results


def _line(key: tuple[str, str, float], found: Sequence[Trial], first: Line | None) -> Line:
    pairs = sorted({(one.distance, one.width) for one in found})
    cells = tuple(_cell(*pair, [o for o in found if (o.distance, o.width) == pair]) for pair in pairs)
    intercept, slope, fit = regression([cell.difficulty for cell in cells], [cell.seconds for cell in cells])
    rates = [cell.effective_difficulty / cell.seconds for cell in cells]
    known = [rate for rate in rates if math.isfinite(rate)]
    return Line(*key, cells, intercept, slope, fit, mean(known), _change(cells, first))


def _cell(distance: float, width: float, found: Sequence[Trial]) -> Cell:
    wide = _effective_width(np.array([one.deviation for one in found]))
    covered = float(np.mean([abs(one.end - one.start) for one in found]))
    effective = difficulty(covered, wide) if wide > 0.0 else math.nan
    seconds = float(np.mean([one.seconds for one in found]))
    missed = sum(one.missed for one in found)
    return Cell(distance, width, len(found), seconds, missed, wide, effective)


def _effective_width(deviations: np.ndarray) -> float:
    from scipy.special import digamma  # imported here because it is slow

    free = 0.5 * (len(deviations) - 1)
    if not free:
        return math.nan
    # bias of the logarithm of a normal sample's standard deviation
    bias = 0.5 * (digamma(free) - math.log(free))
    return EFFECTIVE * float(deviations.std(ddof=1)) * math.exp(-bias)


def regression(x: Sequence[float], y: Sequence[float]) -> tuple[Interval, Interval, float]:
    """Return intercept and slope of a least-squares line with their intervals by Student's t, and r²."""
    from scipy.stats import linregress, t  # imported here because it is slow

    if len(x) < FEWEST_CELLS or len(set(x)) < 2:
        nothing = Interval(math.nan, math.nan)
        return nothing, nothing, math.nan
    found = linregress(x, y)
    width = float(t.ppf(0.975, len(x) - 2))
    return (
        Interval(float(found.intercept), width * float(found.intercept_stderr)),
        Interval(float(found.slope), width * float(found.stderr)),
        float(found.rvalue) ** 2,
    )


def _change(cells: Sequence[Cell], first: Line | None) -> Interval:
    """Return the time's change relative to ``first``, averaged over common pairs of distance and width."""
    if first is None:
        return Interval(math.nan, math.nan)
    before = {(cell.distance, cell.width): cell.seconds for cell in first.cells}
    pairs = [(cell.seconds, before.get((cell.distance, cell.width))) for cell in cells]
    return mean([now / then - 1.0 for now, then in pairs if then])


# --- the virtual subject


@dataclass(frozen=True)
class Subject:
    """A simulated subject that moves with minimum jerk: intercept in s, slope in s/bit, noise in s (1 σ).

    The end points are normally distributed about the target's middle, with 4 % outside the target.
    """

    intercept: float = 0.15
    slope: float = 0.16
    noise: float = 0.03

    def samples(
        self, target: Target, chance: np.random.Generator, begin: float = 0.0, rate: float = 1000.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return times in s and positions in m (n,) of one trial, at rest before and after."""
        seconds = self.intercept + self.slope * difficulty(target.distance, target.width)
        seconds = max(seconds + self.noise * chance.standard_normal(), 0.1)
        end = target.middle + target.width / EFFECTIVE * chance.standard_normal()
        wait, after = 0.3, REST_SECONDS + 0.1
        time = np.arange(round((wait + seconds + after) * rate)) / rate
        share = np.clip((time - wait) / seconds, 0.0, 1.0)
        path = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        return begin + time, target.start + (end - target.start) * path

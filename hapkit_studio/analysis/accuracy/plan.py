"""Work-precision charts: the error of methods over their cost, the Pareto front and the best methods.

The cost is the computing time of a simulated second in ns, or the board's cycles per second. The cost of
compiled work is the shortest time of many runs; several other runs must nearly reach this time. All
candidates run alternately. The spread of a cost is the range of the fastest quarter of the runs; it is at
least the fraction KNOWN of the cost. Only the thread's own processor time is measured; other programs can
lengthen it a little, but never shorten it.
"""

import math
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hapkit_studio import environments
from hapkit_studio.formatting import compact, power_of_ten, significant, with_unit
from hapkit_studio.haptics import board_plan
from hapkit_studio.haptics.board_plan import BoardPlanner, PlanRequest
from hapkit_studio.laws.machine import ARENA

# the reason for a tolerance of 2 %
FELT = "A third of 6 %, the smallest change of force that people can feel"
# fractions of the true value; for an error in m/s, 0.1 stands for the scene's own tolerance
TOLERANCES = 0.1, 0.01, 1e-3, 1e-4
# decades of error: largest deviation of points from the straight line whose slope is the order of convergence
STRAIGHT = 0.15
# errors below the first or above the second value are formatted as powers of ten; a speed error is in µm/s if
# the tolerance is below the third value
_TINY, _HUGE, _SLOW = 1e-2, 1e5, 1e-4
_NAMED = 3  # maximum number of listed methods with the same cost


@dataclass(frozen=True)
class Point:
    """One method at one step: its error, and its cost on a computer and on the board.

    ``cycles`` are the board's cycles per second; NaN if the board lacks the method. ``ns`` is the computing
    time of a simulated second, ± ``spread``.
    """

    method: str
    label: str
    step_s: float
    error: float = math.nan
    cycles: float = math.nan
    ns: float = math.nan
    spread: float = 0.0

    def cost(self, board: bool) -> float:
        """Return the cost on the board, or on a computer."""
        return self.cycles if board else self.ns

    def cost_text(self, board: bool = False) -> str:
        """Format the computing time of a simulated second, or the board's cycles per second."""
        if board:
            cycles = f"{significant(1e-6 * self.cycles, 3)} million processor cycles"
            return cycles if math.isfinite(self.cycles) else "–"
        milliseconds = f"{significant(1e-6 * self.ns)} ms"
        return milliseconds if self.ns >= 0.995e6 else f"{significant(1e-3 * self.ns)} µs"


Work = Callable[[], object]
Motion = tuple[Work, Callable[[], float]]  # a simulation, and a function that afterwards returns its error
# a point of a chart before it is measured; a function that prepares a number of repetitions;
# the simulated time in s
Run = tuple[Point, Callable[[int], Motion], float]


def error(prepare: Callable[[int], Motion]) -> float:
    """Run a simulation once, and return its error; a NaN becomes inf."""
    work, found = prepare(1)
    work()
    with np.errstate(all="ignore"):
        off = found()
    return off if math.isfinite(off) else math.inf


def front(points: Sequence[Point], board: bool = False) -> tuple[Point, ...]:
    """Return the points that are not Pareto-dominated in error and cost; the cheapest is first."""

    def dominates(one: Point, other: Point) -> bool:
        pairs = (one.error, other.error), (one.cost(board), other.cost(board))
        return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)

    sound = [p for p in points if math.isfinite(p.error) and math.isfinite(p.cost(board))]
    found = [p for p in sound if not any(dominates(q, p) for q in sound)]
    return tuple(sorted(found, key=lambda p: (p.cost(board), -p.error)))


@dataclass(frozen=True)
class Scene:
    """A test problem of a chart.

    ``error`` is the label of the error axis. ``unit`` is "" if the error is a fraction. ``reason`` explains
    the tolerance. ``conditions`` are pairs of a name and a value with its unit.
    """

    key: str
    title: str
    error: str
    tolerance: float
    reason: str
    unit: str = ""
    conditions: tuple[tuple[str, str], ...] = ()

    @property
    def tolerances(self) -> tuple[float, ...]:
        """Return the tolerances for which the best methods are determined; the widest is first."""
        return tuple(10.0 * t * self.tolerance for t in TOLERANCES) if self.unit else TOLERANCES

    @property
    def shown_unit(self) -> tuple[float, str]:
        """Return the factor from an error's own unit to the displayed unit, and the displayed unit."""
        if not self.unit:
            return 100.0, "%"
        return (1e6, "µm/s") if self.tolerance < _SLOW else (1e3, "mm/s")

    def error_text(self, error: float) -> str:
        """Format an error with its unit; a fraction is in %, a speed in mm/s or µm/s."""
        factor, name = self.shown_unit
        value = error * factor
        if not math.isfinite(value):
            return "none"
        plain = value == 0.0 or _TINY <= value < _HUGE
        return f"{significant(value) if plain else power_of_ten(value)} {name}"

    def tolerance_text(self, tolerance: float) -> str:
        """Format a tolerance, which is a round number."""
        factor, name = self.shown_unit
        return with_unit(tolerance * factor, name)


@dataclass(frozen=True)
class Sheet:
    """A scene's points; ``methods`` maps the key of each line to its label."""

    chart: str
    scene: Scene
    methods: Mapping[str, str]
    points: tuple[Point, ...]

    @property
    def boarded(self) -> bool:
        """Return True if the board has any of the methods."""
        return any(math.isfinite(p.cycles) for p in self.points)

    def line(self, method: str) -> tuple[Point, ...]:
        """Return a method's points in the order in which they were computed."""
        return tuple(p for p in self.points if p.method == method)

    def winners(self, tolerance: float, board: bool = False) -> tuple[Point, ...]:
        """Return the cheapest point within a tolerance, followed by points of indistinguishable cost."""
        good = [p for p in self.points if p.error <= tolerance and math.isfinite(p.cost(board))]
        good.sort(key=lambda p: (p.cost(board), p.error))
        spread = 0.0 if board or not good else good[0].spread
        return tuple(p for p in good if p.cost(board) - good[0].cost(board) <= spread)

    def order(self, method: str) -> float:
        """Return the order of convergence, which is the log-log slope of error over step.

        The order is NaN if the points are not on a straight line. Points with an error above 0.1, or within
        rounding errors, are excluded.
        """
        usual = [p for p in self.line(method) if 1e-11 < p.error < 0.1]
        if len({p.step_s for p in usual}) < 3:
            return math.nan
        x, y = (np.log10([getattr(p, key) for p in usual]) for key in ("step_s", "error"))
        slope, start = np.polyfit(x, y, 1)
        return float(slope) if np.abs(start + slope * x - y).max() < STRAIGHT else math.nan

    def name_text(self, point: Point) -> str:
        """Format a point's method, with the step in ms if the chart has several steps."""
        several = len({p.step_s for p in self.points}) > 1
        return f"{point.label}, {compact(1e3 * point.step_s, 4)} ms step" if several else point.label

    def winner_text(self, tolerance: float, board: bool = False) -> str:
        """Format the cheapest point within a tolerance, and the points with the same cost."""
        names = [self.name_text(p) for p in self.winners(tolerance, board)]
        return " or ".join(names[:_NAMED]) + " or others" * (len(names) > _NAMED) or "none"

    def sentence(self, board: bool = False) -> str:
        """Return a sentence on the cheapest point within the scene's tolerance."""
        where = self.scene.tolerance_text(self.scene.tolerance)
        found = self.winners(self.scene.tolerance, board)
        if not found:
            return f"No method has an error within {where}."
        best, cost = self.name_text(found[0]), found[0].cost_text(board)
        of = "a second" if board else "per simulated second"
        others = f" {len(found) - 1} more cost{'s' * (len(found) == 2)} the same." if found[1:] else ""
        return f"The cheapest method with an error within {where} is {best}: {cost} {of}.{others}"


@dataclass(frozen=True)
class Plan:
    """One chart; ``runs(scene)`` returns its simulations. A module declares its chart as ``PLAN``."""

    key: str
    title: str
    question: str
    methods: Mapping[str, str]
    scenes: tuple[Scene, ...]
    runs: Callable[[Scene], Iterable[Run]]
    order: int

    def sheet(self, scene: Scene) -> Sheet:
        """Return a scene's sheet; its runs are timed alternately."""
        runs = list(self.runs(scene))
        # short work is repeated until TIMED_STEPS steps are timed together
        times = [max(1, math.ceil(TIMED_STEPS / round(seconds / p.step_s))) for p, _, seconds in runs]
        works = [lambda run=run, n=n: run[1](n)[0] for run, n in zip(runs, times, strict=True)]
        found = []
        for (point, prepare, seconds), n, (ns, spread) in zip(runs, times, shortest(works), strict=True):
            of = n * seconds
            found.append(replace(point, error=error(prepare), ns=ns / of, spread=spread / of))
        return Sheet(self.key, scene, self.methods, tuple(found))


_PLANNER = BoardPlanner(ARENA)


def board_cycles(environment: str, parameter: str, option: str, rate: float) -> float:
    """Return the board's cycles per second for a method of a law at a rate in Hz.

    Return NaN if the board lacks the method.
    """
    found = environments.named(environment)
    planned = _PLANNER.plan(PlanRequest(found, found.values({parameter: option})))
    if isinstance(planned, str):
        return math.nan
    return board_plan.CLOCK * board_plan.share(planned.program, rate)


TIMED_STEPS = 8000
LEAST_TURNS, MOST_TURNS = 40, 400
# A minimum is confirmed if HITS runs are within the factor NEAR of it, or after ENOUGH_NS ns of work.
HITS, NEAR = 8, 1.03
KNOWN = 2 * (NEAR - 1)  # costs with a smaller relative difference are considered equal
ENOUGH_NS = 500_000_000
# the thread's processor time; on Windows wall-clock time, because processor time has steps of 16 ms there
CLOCK: Callable[[], int] = time.perf_counter_ns if sys.platform == "win32" else time.thread_time_ns


def shortest(
    prepares: Sequence[Callable[[], Work]], now: Callable[[], int] = CLOCK
) -> list[tuple[float, float]]:
    """Return a confirmed minimum in ns of each candidate's work, and its spread.

    The preparation is not timed. A round runs every candidate once; each round starts with the next
    candidate.
    """
    for prepare in prepares:
        prepare()()
    turns: list[list[float]] = [[] for _ in prepares]
    spent = 0.0
    for turn in range(MOST_TURNS):
        for place in range(len(prepares)):
            candidate = (turn + place) % len(prepares)
            work = prepares[candidate]()
            begin = now()
            work()
            turns[candidate].append(float(now() - begin))
            spent += turns[candidate][-1]
        believed = all(sorted(found)[HITS - 1 :][0] <= NEAR * min(found) for found in turns if turn >= HITS)
        if turn + 1 >= LEAST_TURNS and (spent > ENOUGH_NS or believed):
            break
    ranked = map(sorted, turns)
    return [(f[HITS - 1], max(f[len(f) // 4] - f[0], KNOWN * f[HITS - 1])) for f in ranked]

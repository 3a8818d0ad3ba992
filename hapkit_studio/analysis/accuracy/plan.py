"""What a chart of speed against accuracy is: its scenes, points, the answer they give, how it is computed.

A scene's answer is the cheapest method within its tolerance; the points that no other beats in both error and
cost are the Pareto front. A default serves several scenes, so that it is chosen over all of them. Costs that
differ by less than they were measured to spread are equal: the error decides.

What compiled work costs: the time that several of its shortest turns kept within, all candidates in the same
turns. It spreads by how far the shortest quarter of the turns lie apart, and by no less than the nearness at
which both of two costs are believed: where the compiler places a loop moves its cost by as much.

What counts is the thread's own time on its core: another program that takes the core costs nothing. One that
shares caches or the core's other half makes work longer, by up to half, never shorter, so the shortest turns
are the nearest to the work itself, and they go on until every candidate was as short several times: a clock
that slips may make one turn shorter than its work. A turn goes once round all candidates, each time from the
next one on, so that a slow moment meets them all alike. Work should last a tenth of a millisecond: calling it
takes up to 5 µs.
"""

import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import mean
from typing import Generic, TypeVar

import numpy as np

from hapkit_studio import environments
from hapkit_studio.formatting import plain

FELT = "A third of the smallest change of force that people feel, 6 %"
"""Why a tolerance is 2 %."""
BY_HAND = "the view Speed and accuracy, not this chart, decides the scene's default"
Work = Callable[[], object]
Prepare = Callable[[], Work]
Clock = Callable[[], int]


class Rival:
    """What competes by its error and its price, each the less the better."""

    error: float
    pareto: bool

    @property
    def price(self) -> tuple[float, float]:
        """Return what it costs, and how far that is known."""
        raise NotImplementedError

    def as_cheap(self, other: "Rival") -> bool:
        """Return whether both cost the same, as far as is known."""
        (mine, spread), (its, its_spread) = self.price, other.price
        return abs(mine - its) <= max(spread, its_spread)

    def beats(self, other: "Rival") -> bool:
        """Return whether the other is better in nothing, and worse in error or cost."""
        less, tied = self.price[0] < other.price[0], self.as_cheap(other)
        return (less or tied) and (self.error < other.error or (self.error == other.error and not tied))


R = TypeVar("R", bound=Rival)


@dataclass(frozen=True)
class Point(Rival):
    """One method at one step in one scene: its error, and the ns of computing a simulated second.

    ns_spread is how far that cost is known; label names the method with its options. extra: what only some
    charts measure.
    """

    chart: str
    scene: str
    method: str
    step_s: float
    error: float
    ns_per_simulated_s: float
    pareto: bool = False
    label: str = ""
    options: tuple[tuple[str, float], ...] = ()
    extra: tuple[tuple[str, float], ...] = ()
    ns_spread: float = 0.0

    @property
    def price(self) -> tuple[float, float]:
        return self.ns_per_simulated_s, self.ns_spread

    def row(self) -> dict[str, object]:
        """Return the point as an object for programs; an error that is not finite is None."""
        keys = ("chart", "scene", "method", "step_s", "error", "ns_per_simulated_s", "ns_spread", "pareto")
        options = {"options": dict(self.options)} if self.options else {}
        return plain({**{key: getattr(self, key) for key in keys}, **options, **dict(self.extra)})


def mark_front(points: Sequence[R]) -> tuple[R, ...]:
    """Return the points, those marked that no other beats: the Pareto front.

    Equal points are in it together; one whose error is no number, or endless, never is.
    """
    return tuple(
        replace(p, pareto=math.isfinite(p.error) and not any(q.beats(p) for q in points))  # type: ignore[type-var]
        for p in points
    )


@dataclass(frozen=True)
class Method:
    """One line of a chart: its key in files and programs, and its label for people."""

    key: str
    label: str


@dataclass(frozen=True)
class Default:
    """What the studio uses in a scene by default: a method, its step in s and its options."""

    method: str
    step_s: float = 1e-3
    options: tuple[tuple[str, float], ...] = ()

    def names(self, point: Point) -> bool:
        """Return whether a point is the default's."""
        same = point.method == self.method and point.options == self.options
        return same and math.isclose(point.step_s, self.step_s)


def default_of(environment: str, parameter: str) -> Default:
    """Return the method with which an environment starts: its parameter's default."""
    found = environments.named(environment)
    choice = next(p for p in found.parameters if p.key == parameter)
    return Default(choice.text(found.values()[parameter]))


@dataclass(frozen=True)
class Scene:
    """What is computed: error says of what and over what, unit is "" for a share, reason is the tolerance's.

    conditions are name and value with unit, for people. step_s is the step at which methods compete, the
    loop's own; None where the step is what is chosen. goal says what the tolerance is where no number does.
    """

    key: str
    title: str
    error: str
    tolerance: float
    reason: str
    default: Default
    unit: str = ""
    conditions: tuple[tuple[str, str], ...] = ()
    step_s: float | None = 1e-3
    goal: str = ""

    def competes(self, point: Point) -> bool:
        """Return whether a point may be the answer."""
        return self.step_s is None or math.isclose(point.step_s, self.step_s)


@dataclass(frozen=True)
class Answer(Generic[R]):
    """The most accurate of the cheapest points that will do, those as cheap beside it, and the default's.

    cheapest is the default where that is as good. None where there is no such point.
    """

    cheapest: R | None
    as_cheap: tuple[R, ...]
    default: R | None

    @classmethod
    def among(cls, points: Sequence[R], default: R | None) -> "Answer[R]":
        """Return the answer from all points that will do."""
        if not points:
            return cls(None, (), default)
        cheapest = min(points, key=lambda p: p.price[0])
        tied = sorted((p for p in points if p.as_cheap(cheapest)), key=lambda p: (p.error, p is not default))
        return cls(tied[0], tuple(tied[1:]), default)

    @property
    def right(self) -> bool:
        """Return whether the default is the cheapest."""
        return self.cheapest is not None and self.cheapest is self.default

    @property
    def tied(self) -> bool:
        """Return whether the default is the cheapest or as cheap."""
        return self.right or self.default in self.as_cheap


@dataclass(frozen=True)
class Sheet:
    """A scene's points, the front marked."""

    chart: str
    scene: Scene
    methods: tuple[Method, ...]
    points: tuple[Point, ...]

    @cached_property
    def answer(self) -> Answer[Point]:
        """Return the cheapest point within the tolerance, and whether the default is it."""
        default = next((p for p in self.points if self.scene.default.names(p)), None)
        return Answer.among([p for p in self.competing if self.passes(p)], default)

    @property
    def competing(self) -> tuple[Point, ...]:
        """Return the points that may be the answer."""
        return tuple(p for p in self.points if self.scene.competes(p))

    def passes(self, point: Point | None) -> bool:
        """Return whether a point is within the tolerance."""
        return point is not None and point.error <= self.scene.tolerance

    @property
    def front(self) -> tuple[Point, ...]:
        """Return the Pareto front from the cheapest to the most accurate."""
        marked = [p for p in self.points if p.pareto]
        return tuple(sorted(marked, key=lambda p: (p.ns_per_simulated_s, -p.error)))

    def line(self, method: str) -> tuple[Point, ...]:
        """Return a method's points in the order in which they were computed."""
        return tuple(p for p in self.points if p.method == method)


@dataclass(frozen=True)
class Choice:
    """What one default serves: sheets with the same competitors."""

    sheets: tuple[Sheet, ...]

    def serving(self, point: Point) -> list[tuple[Sheet, Point]]:
        """Return every sheet with the point of the same method, step and options there."""
        key = point.method, point.step_s, point.options
        return [(s, p) for s in self.sheets for p in s.competing if (p.method, p.step_s, p.options) == key]

    def passed(self, point: Point) -> int:
        """Return in how many sheets a method is within the tolerance."""
        return sum(sheet.passes(found) for sheet, found in self.serving(point))

    @cached_property
    def answer(self) -> Answer[Point]:
        """Return the cheapest of those that are within the tolerance in the most sheets."""
        found = [self._overall(p) for p in self.sheets[0].competing]
        default = next((p for p in found if self.sheets[0].scene.default.names(p)), None)
        most = max(map(self.passed, found), default=0)
        return Answer.among([p for p in found if self.passed(p) == most > 0], default)

    def _overall(self, point: Point) -> Point:
        """Return a method with its mean cost, its widest spread, and its largest error in tolerances."""
        pairs = self.serving(point)
        return replace(
            point,
            scene=" ".join(sheet.scene.key for sheet in self.sheets),
            error=max(p.error / sheet.scene.tolerance for sheet, p in pairs),
            ns_per_simulated_s=mean(p.ns_per_simulated_s for _, p in pairs),
            ns_spread=max(p.ns_spread for _, p in pairs),
            pareto=False,
        )


@dataclass(frozen=True)
class Chart:
    """One chart: a sheet a scene."""

    key: str
    title: str
    sheets: tuple[Sheet, ...]

    def sheet(self, scene: str) -> Sheet:
        """Return a scene's sheet."""
        return next(s for s in self.sheets if s.scene.key == scene)

    @cached_property
    def choices(self) -> tuple[Choice, ...]:
        """Return what each default serves."""
        defaults = dict.fromkeys(sheet.scene.default for sheet in self.sheets)
        return tuple(Choice(tuple(s for s in self.sheets if s.scene.default == d)) for d in defaults)


@dataclass(frozen=True)
class Accuracy:
    """What was computed, and how long that took in s."""

    charts: tuple[Chart, ...]
    seconds: float

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """Return every sheet of every chart."""
        return tuple(sheet for chart in self.charts for sheet in chart.sheets)

    def rows(self) -> list[dict[str, object]]:
        """Return one row a point."""
        return [point.row() for sheet in self.sheets for point in sheet.points]


# Of work that is short, so much is timed at once.
TIMED_STEPS = 8000


def repeats(steps: int) -> int:
    """Return how often to repeat work of this many steps for one timing."""
    return max(1, -(-TIMED_STEPS // max(steps, 1)))


def always(work: Work) -> Prepare:
    """Return a preparation for work that can be repeated as it is."""
    return lambda: work


@dataclass(frozen=True)
class Run:
    """One method at one step: its error, and what to time, which simulates so many seconds."""

    method: str
    label: str
    step_s: float
    error: float
    prepare: Prepare
    seconds: float
    options: tuple[tuple[str, float], ...] = ()
    extra: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Trace:
    """A motion and its true one over t in s, each (n,), in m; scale: what 100 % of its error is, in m.

    nan where the error is not of the motion itself.
    """

    t: np.ndarray
    x: np.ndarray
    true: np.ndarray
    scale: float


@dataclass(frozen=True)
class Plan:
    """One chart: ``runs(scene)`` computes every error; found by the name ``PLAN``.

    ``trace(point)`` computes a point's motion again, to be drawn over time.
    """

    key: str
    title: str
    methods: tuple[Method, ...]
    scenes: tuple[Scene, ...]
    runs: Callable[[Scene], Sequence[Run]]
    order: int
    trace: Callable[[Point], Trace] | None = None

    def sheet(self, scene: Scene) -> Sheet:
        """Return a scene's sheet, its runs timed beside each other, and those that compete once more alone.

        Few take short turns, so that more turns fit in where the machine is calm.
        """
        runs = self.runs(scene)
        spent = shortest([run.prepare for run in runs])
        points = [self._point(scene, run, *cost) for run, cost in zip(runs, spent, strict=True)]
        rivals = [i for i, point in enumerate(points) if scene.competes(point)]
        again = shortest([runs[i].prepare for i in rivals])
        for i, cost in zip(rivals, again, strict=True):
            points[i] = self._point(scene, runs[i], *min(cost, spent[i]))
        return Sheet(self.key, scene, self.methods, mark_front(points))

    def _point(self, scene: Scene, run: Run, ns: float, spread: float) -> Point:
        error = run.error if not math.isnan(run.error) else math.inf
        measured = run.step_s, error, ns / run.seconds
        named = run.label, run.options, run.extra
        return Point(self.key, scene.key, run.method, *measured, False, *named, spread / run.seconds)


LEAST_TURNS, MOST_TURNS = 40, 400
# The shortest turns are believed once so many turns came as near to it as this, or after so many ns of work.
HITS, NEAR = 8, 1.03
# Two costs nearer than this part of themselves are equal.
KNOWN = 2 * (NEAR - 1)
ENOUGH_NS = 500_000_000
# The thread's own time; the wall's on Windows, where a thread's moves on in steps of 16 ms.
CLOCK: Clock = time.perf_counter_ns if sys.platform == "win32" else time.thread_time_ns


def shortest(prepares: Sequence[Prepare], now: Clock = CLOCK) -> list[tuple[float, float]]:
    """Return the ns of each candidate's work, within which HITS turns were, and their spread.

    A candidate makes its work ready outside of the time.
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
        if turn + 1 >= LEAST_TURNS and (spent > ENOUGH_NS or all(map(_believed, turns))):
            break
    ranked = map(sorted, turns)
    return [(f[HITS - 1], max(f[len(f) // 4] - f[0], KNOWN * f[HITS - 1])) for f in ranked]


def _believed(found: list[float]) -> bool:
    return sorted(found)[HITS - 1] <= NEAR * min(found)

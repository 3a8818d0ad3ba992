"""What a chart of speed against accuracy is: its scenes, points, the answer they give, how it is computed.

A scene's answer is the cheapest method within its tolerance; the points that no other beats in both error and
cost are the Pareto front.

What compiled work costs: the shortest of several turns, all candidates in the same turns.

What counts is the thread's own time on its core, where its clock is fine enough: another program that takes
the core costs nothing. One that shares caches or the core's other half makes work longer, by up to half,
never shorter, so the shortest turn is the nearest to the work itself, and turns go on until every candidate
was as short several times. A turn goes once round all candidates, each time from the next one on, so that a
slow moment meets them all alike. Work should last a tenth of a millisecond: calling it takes up to 5 µs.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from hapkit_studio import environments
from hapkit_studio.formatting import plain

Work = Callable[[], object]
Prepare = Callable[[], Work]
Clock = Callable[[], int]


@dataclass(frozen=True)
class Point:
    """One method at one step in one scene: its error, and the ns of computing a simulated second.

    label names the method with its options. extra: what only some charts measure.
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

    def row(self) -> dict[str, object]:
        """Return the point as an object for programs; an error that is not finite is None."""
        keys = ("chart", "scene", "method", "step_s", "error", "ns_per_simulated_s", "pareto")
        options = {"options": dict(self.options)} if self.options else {}
        return plain({**{key: getattr(self, key) for key in keys}, **options, **dict(self.extra)})


def mark_front(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points, those marked that no other beats: the Pareto front.

    Equal points are in it together; one whose error is no number, or endless, never is.
    """
    front: set[tuple[float, float]] = set()
    least = math.inf
    sound = {(p.ns_per_simulated_s, p.error) for p in points if math.isfinite(p.error)}
    for cost, error in sorted(sound):
        if error < least:
            front.add((cost, error))
            least = error
    return tuple(replace(p, pareto=(p.ns_per_simulated_s, p.error) in front) for p in points)


# Costs this close are equal: so far the same code measured twice may differ where others use the machine.
TIE = 1.10


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
        return same and abs(point.step_s - self.step_s) <= 1e-9 * self.step_s


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
        return self.step_s is None or abs(point.step_s - self.step_s) <= 1e-9 * self.step_s


@dataclass(frozen=True)
class Answer:
    """The cheapest points within the tolerance, those as cheap beside it (within TIE), and the default's.

    cheapest is the default where that is among them. None where there is no such point.
    """

    cheapest: Point | None
    as_cheap: tuple[Point, ...]
    default: Point | None

    @property
    def right(self) -> bool:
        """Return whether the default is the cheapest within the tolerance."""
        return self.cheapest is not None and self.cheapest is self.default


@dataclass(frozen=True)
class Sheet:
    """A scene's points, the front marked."""

    chart: str
    scene: Scene
    methods: tuple[Method, ...]
    points: tuple[Point, ...]

    @cached_property
    def answer(self) -> Answer:
        """Return the cheapest point within the tolerance, and whether the default is it."""
        default = next((p for p in self.points if self.scene.default.names(p)), None)
        within = [p for p in self.points if self.scene.competes(p) and p.error <= self.scene.tolerance]
        if not within:
            return Answer(None, (), default)
        within.sort(key=lambda p: p.ns_per_simulated_s)
        tied = [p for p in within if p.ns_per_simulated_s <= TIE * within[0].ns_per_simulated_s]
        cheapest = default if default in tied else tied[0]
        return Answer(cheapest, tuple(p for p in tied if p is not cheapest), default)

    @property
    def front(self) -> tuple[Point, ...]:
        """Return the Pareto front from the cheapest to the most accurate."""
        marked = [p for p in self.points if p.pareto]
        return tuple(sorted(marked, key=lambda p: (p.ns_per_simulated_s, -p.error)))

    def line(self, method: str) -> tuple[Point, ...]:
        """Return a method's points in the order in which they were computed."""
        return tuple(p for p in self.points if p.method == method)


@dataclass(frozen=True)
class Chart:
    """One chart: a sheet a scene."""

    key: str
    title: str
    sheets: tuple[Sheet, ...]

    def sheet(self, scene: str) -> Sheet:
        """Return a scene's sheet."""
        return next(s for s in self.sheets if s.scene.key == scene)


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
class Plan:
    """One chart: ``runs(scene)`` computes every error; found by the name ``PLAN``."""

    key: str
    title: str
    methods: tuple[Method, ...]
    scenes: tuple[Scene, ...]
    runs: Callable[[Scene], Sequence[Run]]
    order: int

    def sheet(self, scene: Scene) -> Sheet:
        """Return a scene's sheet, its runs timed beside each other, and those that compete once more alone.

        Few take short turns, so that more turns fit in where the machine is calm.
        """
        runs = self.runs(scene)
        spent = shortest([run.prepare for run in runs])
        points = [self._point(scene, run, ns) for run, ns in zip(runs, spent, strict=True)]
        rivals = [i for i, point in enumerate(points) if scene.competes(point)]
        again = shortest([runs[i].prepare for i in rivals])
        for i, ns in zip(rivals, again, strict=True):
            points[i] = self._point(scene, runs[i], min(ns, spent[i]))
        return Sheet(self.key, scene, self.methods, mark_front(points))

    def _point(self, scene: Scene, run: Run, ns: float) -> Point:
        error = run.error if not math.isnan(run.error) else math.inf
        measured = run.step_s, error, ns / run.seconds
        return Point(self.key, scene.key, run.method, *measured, False, run.label, run.options, run.extra)


LEAST_TURNS, MOST_TURNS = 40, 400
# The shortest is believed once so many turns came as near to it as this, or after so many ns of work.
HITS, NEAR = 8, 1.03
ENOUGH_NS = 500_000_000
# A clock is fine enough that moves on within so many ns, and by less.
_FINE_NS, _LOOKS = 10_000, 5


def clock() -> Clock:
    """Return the thread's own time in ns, the wall's where that moves on in long steps, as on Windows."""
    return time.thread_time_ns if any(_fine() for _ in range(_LOOKS)) else time.perf_counter_ns


def _fine() -> bool:
    begin, until = time.thread_time_ns(), time.perf_counter_ns() + _FINE_NS
    while time.perf_counter_ns() < until:
        if time.thread_time_ns() != begin:
            return time.thread_time_ns() - begin < _FINE_NS
    return False


def shortest(prepares: Sequence[Prepare], now: Clock | None = None) -> list[float]:
    """Return the ns of each candidate's work; a candidate makes its work ready outside of the time."""
    now = now or clock()
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
    return [min(found) for found in turns]


def _believed(found: list[float]) -> bool:
    limit = NEAR * min(found)
    return sum(lasted <= limit for lasted in found) >= HITS

"""A scene's points with the answer that they give: the cheapest method within the tolerance."""

from dataclasses import dataclass
from functools import cached_property

from hapkit_studio.analysis.accuracy.points import Point

# Costs this close are equal: so far the same code measured twice may differ where others use the machine.
TIE = 1.10


@dataclass(frozen=True)
class Method:
    """One line of a chart: its key in files and programs, and its label for people."""

    key: str
    label: str


@dataclass(frozen=True)
class Default:
    """What the product uses in a scene unless told otherwise: a method, its step in s and its options."""

    method: str
    step_s: float = 1e-3
    options: tuple[tuple[str, float], ...] = ()

    def names(self, point: Point) -> bool:
        """Return whether a point is the default's."""
        same = point.method == self.method and point.options == self.options
        return same and abs(point.step_s - self.step_s) <= 1e-9 * self.step_s


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

    def label(self, method: str) -> str:
        """Return a method's label."""
        return next(m.label for m in self.methods if m.key == method)


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

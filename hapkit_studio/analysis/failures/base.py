"""What a failure is: where a method stops working, why, how to try and chart it, how to feel it live."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, wraps
from typing import Any

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.failures.plane import Plane
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.devices.simulated import SimulatedHapkit
from hapkit_studio.dynamics.hand import Hand, Prescribed
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain, with_unit
from hapkit_studio.haptics import headless
from hapkit_studio.haptics.settings import RATE, LoopSettings
from hapkit_studio.parameters import AnyParameter, Choice, Parameter, resolve

__all__ = ["Choice", "Parameter", "Progress"]

# One number for each option of a failure, a choice's as its index: what Failure.case returns.
Case = Mapping[str, float]
THEORY, MEASURED, OTHER = "theory", "measured", "other"


# Points of a trace: a pixel has two of them, its lowest and its highest.
POINTS = 2400


@dataclass(frozen=True)
class Evidence:
    """What one try showed: samples (n,) that are step s apart, the number it was judged by, the verdict.

    The samples end where the motion is lost. measure is in unit measure_unit; words say both in one line, for
    a person. held: a value lasts until the next.
    """

    samples: np.ndarray
    step: float
    label: str
    unit: str
    holds: bool
    measure: float
    measure_unit: str
    words: str
    held: bool = False

    @property
    def seconds(self) -> float:
        """Return how long the samples take."""
        return self.step * (len(self.samples) - 1)

    @cached_property
    def trace(self) -> tuple[np.ndarray, np.ndarray]:
        """Return time and samples, of at most about POINTS pieces the lowest and the highest of each."""
        x = self.samples
        time = self.step * np.arange(len(x))
        if len(x) <= POINTS:
            return time, x
        size = -(-2 * len(x) // POINTS)
        count = len(x) // size
        pieces = x[: count * size].reshape(count, size)
        first = size * np.arange(count)
        lowest, highest = first + pieces.argmin(axis=1), first + pieces.argmax(axis=1)
        chosen = np.unique(np.r_[lowest, highest, len(x) - 1])
        return time[chosen], x[chosen]


@dataclass(frozen=True)
class Curve:
    """One curve to chart: of(x, case) is y, nan where it is not drawn; at(case): places of its own.

    Without ``of`` y is what the failure's probe measures, without ``at`` it runs over the plot's places. role
    is "theory", "measured" (points) or "other" (to compare).
    """

    label: str
    of: Callable[[float, Case], float] | None = None
    role: str = MEASURED
    at: Callable[[Case], np.ndarray] | None = None


@dataclass(frozen=True)
class Plot:
    """How a failure is charted: curves over shares (n,) of its limit, or over the places (n,) of a case.

    boundary labels the limit; "" where x_label says that x is not the knob (times ``factor``). marks: other
    places worth seeing, by their labels. level: the y at which it begins to fail. Unless declared otherwise
    y is a growth, which must stay below 0.
    """

    x_label: str
    at: np.ndarray | Callable[[Case], np.ndarray]
    curves: tuple[Curve, ...]
    boundary: str = ""
    marks: Callable[[Case], dict[str, float]] = lambda case: {}
    y_label: str = "growth, 1/s"
    level: float | Callable[[Case], float] | None = 0.0
    level_label: str = "no growth"
    log_x: bool = False
    log_y: bool = False
    factor: float = 1.0


@dataclass(frozen=True)
class Line:
    """A curve of a chart as computed: y (n,) over x (n,)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    role: str


@dataclass(frozen=True)
class Chart:
    """What a plot shows in one case, x in the chart's unit; the first mark is the boundary, if any."""

    plot: Plot
    lines: tuple[Line, ...]
    marks: dict[str, float]
    level: float | None


@dataclass(frozen=True)
class Live:
    """The same in the window: an environment, values within a person's limits, the loop, what to do.

    loop holds some of rate Hz, delay s, estimator, options (pairs), model; grip is a grip's name: the mouse
    button held down is that hand, let go is let go.
    """

    environment: str
    values: Mapping[str, float]
    loop: Mapping[str, object] = field(default_factory=dict)
    grip: str = "medium"
    advice: str = ""


@dataclass(frozen=True)
class Try:
    """One value of the knob, what it showed, and how the window would show it."""

    value: float
    evidence: Evidence
    live: Live | None = None


@dataclass(frozen=True)
class Failure:
    """One way in which a method fails; its file in this folder is found by the name ``FAILURE``.

    knob is what is turned, low to high all that may be tried; below limit(case) the method holds, above it
    fails, for certain from ``margin`` (a share of the limit) on: 0.01 where the boundary is sharp. The limit
    is inf where nothing fails, 0 where nothing holds. A case has one number for each of options. probe tries
    one value of the knob by the code that renders; plot draws many and the formula beside them. plane: the
    same limit in dimensionless numbers, for every device. span: the shares of the limit worth turning to.
    """

    key: str
    title: str
    summary: str
    formula: str
    explanation: str
    knob: Parameter
    limit: Callable[[Case], float]
    probe: Callable[[float, Case], Evidence]
    plot: Plot
    options: tuple[AnyParameter, ...] = ()
    live: Callable[[float, Case], Live] | None = None
    plane: Callable[[Case], Plane] | None = None
    margin: float = 0.01
    span: tuple[float, float] = (0.5, 1.5)
    order: int = 100

    def case(self, options: Mapping[str, object] | None = None) -> dict[str, float]:
        """Return every option's number, defaults filled in; raise ParameterError."""
        numbers = resolve(self.options, options or {}, self.title)
        return {p.key: n for p, n in zip(self.options, numbers, strict=True)}

    def inside(self, case: Case) -> float:
        """Return the knob's value just inside the limit, where the method holds."""
        return self.limit(case) * (1.0 - self.margin)

    def outside(self, case: Case) -> float:
        """Return the knob's value just outside the limit, where the method fails."""
        return self.limit(case) * (1.0 + self.margin)

    def bound(self, case: Case) -> float:
        """Return the limit; raise ParameterError where a case has none."""
        limit = self.limit(case)
        if not 0.0 < limit < math.inf:
            what = "fails" if limit else "holds"
            raise ParameterError(f"Nothing {what} under these conditions: change one.")
        return limit

    def try_at(self, value: object, options: Mapping[str, object] | None = None) -> Evidence:
        """Return what happens at one value of the knob; raise ParameterError for what cannot be tried."""
        case = self.case(options)
        return self.probe(self.knob.check(value), case)

    def curve(self, case: Case, progress: Progress) -> Chart:
        """Compute every curve of the plot; the progress counts all points but those of theory."""
        plot, limit, done = self.plot, self.limit(case), 0
        shared = plot.at(case) if callable(plot.at) else limit * plot.at
        places = [curve.at(case) if curve.at else shared for curve in plot.curves]
        of = sum(len(x) for x, curve in zip(places, plot.curves, strict=True) if curve.role != THEORY)
        lines = []
        for xs, curve in zip(places, plot.curves, strict=True):
            y = np.empty(len(xs))
            for index, x in enumerate(xs):
                y[index] = curve.of(float(x), case) if curve.of else self.probe(float(x), case).measure
                if curve.role != THEORY:
                    done += 1
                    progress(done, of)
            lines.append(Line(curve.label, plot.factor * xs, y, curve.role))
        marks = ({plot.boundary: limit} if plot.boundary else {}) | plot.marks(case)
        level = plot.level(case) if callable(plot.level) else plot.level
        return Chart(plot, tuple(lines), {label: plot.factor * x for label, x in marks.items()}, level)


def remembered(limit: Callable[[Case], float]) -> Callable[[Case], float]:
    """Keep the limits of the last cases: each takes long to find, and is asked for often."""
    found = lru_cache(maxsize=64)(lambda numbers: limit(dict(numbers)))
    return wraps(limit)(lambda case: found(tuple(case.items())))


def within(key: str, values: Mapping[str, float]) -> dict[str, float]:
    """Return values of an environment, cut to what a person may set there."""
    declared = {p.key: p for p in environments.named(key).parameters}
    return {k: min(max(float(v), declared[k].low), declared[k].high) for k, v in values.items()}


def short(value: float, bound: float = math.inf) -> float:
    """Return a value in four figures, or in as many as keep it on its side of the bound."""
    for digits in range(4, 17):
        rounded = float(f"{value:.{digits}g}")
        if (rounded < bound) == (value < bound) and (rounded > bound) == (value > bound):
            return rounded
    return value


def live_rate(rate: float) -> float:
    """Return a rate in Hz, cut to what a person may set."""
    return min(max(rate, RATE.low), RATE.high)


@dataclass
class Shown:
    """What is known of a failure in one case: its limit, a try on each side of it, the chart.

    old: the names of what belongs to other conditions.
    """

    failure: Failure
    case: Case
    limit: float | None = None
    inside: Try | None = None
    outside: Try | None = None
    chart: Chart | None = None
    plane: Plane | None = None
    old: set[str] = field(default_factory=set)

    @property
    def scale(self) -> float | None:
        """Return the factor from the knob's unit to the chart's x axis; None where x is another quantity."""
        return self.chart.plot.factor if self.chart and self.chart.plot.boundary and self.limit else None

    @property
    def as_theory_says(self) -> bool:
        """Say whether the inner try holds and the outer one fails."""
        return [one and one.evidence.holds for one in (self.inside, self.outside)] == [True, False]


def show(
    failure: Failure,
    options: Mapping[str, object] | None = None,
    *,
    chart: bool = True,
    plane: bool = False,
    progress: Progress = no_progress,
) -> Shown:
    """Return a failure tried on both sides of its limit; raise ParameterError for options without a limit."""
    case = failure.case(options)
    limit, values = failure.bound(case), (failure.inside(case), failure.outside(case))
    inside, outside = (Try(value, failure.probe(value, case)) for value in values)
    curve = failure.curve(case, progress) if chart else None
    return Shown(
        failure, case, limit, inside, outside, curve, failure.plane(case) if plane and failure.plane else None
    )


def as_json(shown: Shown, traces: bool = False) -> dict[str, Any]:
    """Return a failure shown as one object, SI units; traces: with what moved, and the chart's lines."""
    failure, chart = shown.failure, shown.chart
    found = {
        **{key: getattr(failure, key) for key in ("key", "title", "formula", "margin")},
        "knob": failure.knob.key,
        "knob_unit": failure.knob.unit,
        "options": {
            p.key: p.text(shown.case[p.key]) if p.discrete else shown.case[p.key] for p in failure.options
        },
        "limit": shown.limit,
        "inside": try_json(shown.inside, traces),
        "outside": try_json(shown.outside, traces),
        "as_theory_says": shown.as_theory_says,
    }
    if traces and chart:
        labels = {key: getattr(chart.plot, key) for key in ("x_label", "y_label")}
        marks = [{"label": label, "x": x} for label, x in chart.marks.items()]
        found["chart"] = {**labels, "level": chart.level, "lines": chart.lines, "marks": marks}
    return plain(found)


def try_json(one: Try | None, traces: bool = False) -> dict[str, Any]:
    """Return one try as an object; a measure that is not finite is None."""
    if one is None:
        return {}
    found = one.evidence
    keys = ("holds", "measure", "measure_unit", "words")
    numbers = {"value": one.value, **{key: getattr(found, key) for key in keys}}
    if traces:
        time, trace = found.trace
        numbers |= {"time": time, "trace": trace, "trace_label": found.label, "trace_unit": found.unit}
    return plain(numbers)


# What several failures do alike: render, judge a motion, write its verdict.


def render(
    key: str,
    given: Mapping[str, float],
    device: SimulatedHapkit,
    loop: LoopSettings,
    count: int,
    hand: Hand | Prescribed | None = None,
) -> np.ndarray:
    """Return count telemetry rows of an environment, its other values their defaults."""
    environment = environments.named(key)
    scene = headless.Scene(environment, {**environment.values(), **given}, device, loop)
    return headless.render(scene, hand, count)[0]


def growth_evidence(
    x: np.ndarray, step: float, rate: float, label: str = "position", unit: str = "mm", more: str = ""
) -> Evidence:
    """Return the evidence of a motion x (n,) that grows by rate in 1/s; it holds where that is below 0."""
    words = f"{'decays' if rate < 0.0 else 'grows'} by {with_unit(abs(rate), '1/s')}{more}"
    return Evidence(x, step, label, unit, rate < 0.0, rate, "1/s", words)


def before_lost(x: np.ndarray, most: float) -> int:
    """Return how many samples of x (n,) come before the first beyond ``most`` or not finite."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.abs(x) <= most)
    return int(np.argmax(lost)) if lost.any() else len(x)


def alive(size: np.ndarray, least: float) -> int:
    """Return how many samples of size (n,) there are up to the last that is ``least`` or more."""
    big = np.flatnonzero(size >= least)
    return int(big[-1]) + 1 if len(big) else 0


def growth(size: np.ndarray, seconds: float) -> float:
    """Return the growth in 1/s of an oscillation's size (n,), samples ``seconds`` apart.

    From the last two thirds of it, so that what dies out at once does not count; 0 where nothing moves.
    """
    third = len(size) // 3
    if third == 0:
        return math.inf
    before, after = np.linalg.norm(size[-2 * third : -third]), np.linalg.norm(size[-third:])
    if after == 0.0:
        return 0.0 if before == 0.0 else -math.inf
    with np.errstate(divide="ignore"):
        return float(np.log(after / before) / (third * seconds))

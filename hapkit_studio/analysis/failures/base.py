"""The class of a failure: a method's limit and its cause, a trial, a chart, and a way to feel it live."""

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
from hapkit_studio.dynamics.loop_settings import RATE, LoopSettings
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import plain, with_unit
from hapkit_studio.haptics import headless
from hapkit_studio.parameters import AnyParameter, Choice, Parameter, resolve

__all__ = ["Choice", "Parameter", "Progress"]

# the value of each option of a failure, by its key; the value of a choice is an index
Case = Mapping[str, float]
THEORY, MEASURED, OTHER = "theory", "measured", "other"


# largest number of points of a trace: the minimum and the maximum for each of 1,200 pixels
POINTS = 2400


@dataclass(frozen=True)
class Evidence:
    """The result of one trial: samples (n,), period ``step`` in s, the measured number, and the verdict.

    The samples end when the motion diverges. ``measure`` has the unit measure_unit. ``text`` describes
    measure and verdict in one line. If ``held`` is true, the samples are drawn as steps.
    """

    samples: np.ndarray
    step: float
    label: str
    unit: str
    holds: bool
    measure: float
    measure_unit: str
    text: str
    held: bool = False

    @property
    def seconds(self) -> float:
        """Return the duration of the samples in s."""
        return self.step * (len(self.samples) - 1)

    @cached_property
    def trace(self) -> tuple[np.ndarray, np.ndarray]:
        """Return time and samples; each of about POINTS / 2 parts is reduced to its minimum and maximum."""
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
    """One curve of a chart: of(x, case) returns y, NaN for a gap; at(case) returns the curve's x values.

    If ``of`` is None, y is the failure's measured value. If ``at`` is None, the plot's x values are used.
    ``role`` is "theory", "measured" (points) or "other" (for comparison).
    """

    label: str
    of: Callable[[float, Case], float] | None = None
    role: str = MEASURED
    at: Callable[[Case], np.ndarray] | None = None


@dataclass(frozen=True)
class Plot:
    """The chart of a failure: curves over multiples (n,) of its limit, or over x values (n,) of a case.

    ``boundary`` is the label of the limit; it is "" if the x axis does not show the knob's value times
    ``factor``. ``marks`` are further x values with labels. ``level`` is the y value at which the method
    fails; by default y is a growth rate, and the motion is stable below 0.
    """

    x_label: str
    at: np.ndarray | Callable[[Case], np.ndarray]
    curves: tuple[Curve, ...]
    boundary: str = ""
    marks: Callable[[Case], dict[str, float]] = lambda case: {}
    y_label: str = "growth rate, 1/s"
    level: float | Callable[[Case], float] | None = 0.0
    level_label: str = "no growth"
    log_x: bool = False
    log_y: bool = False
    factor: float = 1.0


@dataclass(frozen=True)
class Line:
    """A computed curve: y (n,) over x (n,)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    role: str


@dataclass(frozen=True)
class Chart:
    """A computed plot of one case, with x in the chart's unit; the first mark may be the boundary."""

    plot: Plot
    lines: tuple[Line, ...]
    marks: dict[str, float]
    level: float | None


@dataclass(frozen=True)
class Live:
    """A failure as the window shows it: environment, values within the window's limits, loop, instruction.

    ``loop`` contains any of: rate in Hz, delay in s, estimator, options (pairs), model. ``grip`` is the name
    of the grip with which a pressed mouse button holds the handle. Releasing the button releases the handle.
    """

    environment: str
    values: Mapping[str, float]
    loop: Mapping[str, object] = field(default_factory=dict)
    grip: str = "medium"
    advice: str = ""


@dataclass(frozen=True)
class Try:
    """A value of the knob with its result and its live settings."""

    value: float
    evidence: Evidence
    live: Live | None = None


@dataclass(frozen=True)
class Failure:
    """The limit of a method. A module in this folder declares its failure as ``FAILURE``.

    ``knob`` is the varied parameter, between low and high. The method works below limit(case) and fails above
    it. The outcome is certain if the distance from the limit exceeds ``margin``, a fraction of the limit; the
    margin is 0.01 for a sharp boundary.
    The limit is inf if the method never fails, and 0 if it never works. A case has one number per option.
    ``probe`` tries one value with the rendering code. ``plot`` shows many values and the formula. ``plane``
    shows the same limit in dimensionless numbers. ``span`` contains the multiples of the limit that are worth
    trying.
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
        """Return the value or default of every option; raise ParameterError for an invalid value."""
        numbers = resolve(self.options, options or {}, self.title)
        return {p.key: n for p, n in zip(self.options, numbers, strict=True)}

    def inside(self, case: Case) -> float:
        """Return a value of the knob just inside the limit, at which the method works."""
        return self.limit(case) * (1.0 - self.margin)

    def outside(self, case: Case) -> float:
        """Return a value of the knob just outside the limit, at which the method fails."""
        return self.limit(case) * (1.0 + self.margin)

    def bound(self, case: Case) -> float:
        """Return the limit; raise ParameterError if the case has no limit."""
        limit = self.limit(case)
        if not 0.0 < limit < math.inf:
            what = "works" if limit else "fails"
            raise ParameterError(
                f"There is no limit under these conditions: every value {what}. Change a condition."
            )
        return limit

    def try_at(self, value: object, options: Mapping[str, object] | None = None) -> Evidence:
        """Return the result at one value of the knob; raise ParameterError for an invalid value."""
        case = self.case(options)
        return self.probe(self.knob.check(value), case)

    def curve(self, case: Case, progress: Progress) -> Chart:
        """Compute every curve of the plot; ``progress`` counts all points except those of theory curves."""
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
    """Cache the limits of recent cases, because they are slow to compute."""
    found = lru_cache(maxsize=64)(lambda numbers: limit(dict(numbers)))
    return wraps(limit)(lambda case: found(tuple(case.items())))


def within(key: str, values: Mapping[str, float]) -> dict[str, float]:
    """Return an environment's values, clipped to the window's limits."""
    declared = {p.key: p for p in environments.named(key).parameters}
    return {k: min(max(float(v), declared[k].low), declared[k].high) for k, v in values.items()}


def short(value: float, bound: float = math.inf) -> float:
    """Return a value rounded to four digits, or to more digits if four would cross the bound."""
    for digits in range(4, 17):
        rounded = float(f"{value:.{digits}g}")
        if (rounded < bound) == (value < bound) and (rounded > bound) == (value > bound):
            return rounded
    return value


def live_rate(rate: float) -> float:
    """Return a rate in Hz, clipped to the window's limits."""
    return min(max(rate, RATE.low), RATE.high)


@dataclass
class Shown:
    """A failure in one case: its limit, a trial on each side of the limit, and the chart.

    ``old`` contains the names of the fields that were computed for earlier conditions.
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
        """Return the factor from the knob's unit to the chart's x axis; None if x is a different quantity."""
        return self.chart.plot.factor if self.chart and self.chart.plot.boundary and self.limit else None

    @property
    def as_theory_says(self) -> bool:
        """Return True if the inner trial works and the outer one fails, as the theory predicts."""
        return [one and one.evidence.holds for one in (self.inside, self.outside)] == [True, False]


def show(
    failure: Failure,
    options: Mapping[str, object] | None = None,
    *,
    chart: bool = True,
    plane: bool = False,
    progress: Progress = no_progress,
) -> Shown:
    """Simulate a failure on both sides of its limit; raise ParameterError for a failure without a limit."""
    case = failure.case(options)
    limit, values = failure.bound(case), (failure.inside(case), failure.outside(case))
    inside, outside = (Try(value, failure.probe(value, case)) for value in values)
    curve = failure.curve(case, progress) if chart else None
    return Shown(
        failure, case, limit, inside, outside, curve, failure.plane(case) if plane and failure.plane else None
    )


def as_json(shown: Shown, traces: bool = False) -> dict[str, Any]:
    """Return the result as one object in SI units; ``traces`` includes the samples and the chart's lines."""
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
    """Return one trial as an object; a non-finite measure becomes None."""
    if one is None:
        return {}
    found = one.evidence
    keys = ("holds", "measure", "measure_unit", "text")
    numbers = {"value": one.value, **{key: getattr(found, key) for key in keys}}
    if traces:
        time, trace = found.trace
        numbers |= {"time": time, "trace": trace, "trace_label": found.label, "trace_unit": found.unit}
    return plain(numbers)


# --- helpers shared by failures: rendering, judging a motion, describing the result


def render(
    key: str,
    given: Mapping[str, float],
    device: SimulatedHapkit,
    loop: LoopSettings,
    count: int,
    hand: Hand | Prescribed | None = None,
) -> np.ndarray:
    """Return ``count`` telemetry rows of an environment; parameters not given have their defaults."""
    environment = environments.named(key)
    scene = headless.Scene(environment, {**environment.values(), **given}, device, loop)
    return headless.render(scene, hand, count)[0]


def growth_evidence(
    x: np.ndarray, step: float, rate: float, label: str = "position", unit: str = "mm", more: str = ""
) -> Evidence:
    """Return the evidence of a motion x (n,) with growth ``rate`` in 1/s; the method works if rate < 0."""
    text = f"the motion {'decays' if rate < 0.0 else 'grows'} at {with_unit(abs(rate), '1/s')}{more}"
    return Evidence(x, step, label, unit, rate < 0.0, rate, "1/s", text)


def before_lost(x: np.ndarray, most: float) -> int:
    """Return the number of samples of x (n,) before the first that exceeds ``most`` or is not finite."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.abs(x) <= most)
    return int(np.argmax(lost)) if lost.any() else len(x)


def alive(size: np.ndarray, least: float) -> int:
    """Return the number of samples up to the last one whose size (n,) is at least ``least``."""
    big = np.flatnonzero(size >= least)
    return int(big[-1]) + 1 if len(big) else 0


def growth(size: np.ndarray, seconds: float) -> float:
    """Return the growth in 1/s of an oscillation from its amplitudes (n,) every ``seconds`` seconds.

    Only the last two thirds are used, to exclude transients. The growth is 0 without motion.
    """
    third = len(size) // 3
    if third == 0:
        return math.inf
    before, after = np.linalg.norm(size[-2 * third : -third]), np.linalg.norm(size[-third:])
    if after == 0.0:
        return 0.0 if before == 0.0 else -math.inf
    with np.errstate(divide="ignore"):
        return float(np.log(after / before) / (third * seconds))

"""What a failure is: where a method stops working, why, how to try and chart it, how to feel it live."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hapkit_studio import environments
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


@dataclass(frozen=True)
class Evidence:
    """What one try showed: a trace (n,) over time (n,) in s, the number it was judged by, the verdict.

    The trace may be thinned, its peaks kept, and ends where the motion is lost. measure is in unit
    measure_unit; words say both in one line, for a person. held: a value lasts until the next.
    """

    time: np.ndarray
    trace: np.ndarray
    label: str
    unit: str
    holds: bool
    measure: float
    measure_unit: str
    words: str
    held: bool = False


@dataclass(frozen=True)
class Line:
    """One curve (n,) of a chart: role is "theory", "measured" (points) or "other" (to compare)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    role: str = MEASURED


@dataclass(frozen=True)
class Mark:
    """A place on the chart's x axis: the boundary, or another limit worth seeing."""

    label: str
    x: float


@dataclass(frozen=True)
class Chart:
    """The failure over its knob; the first mark is the boundary, level the y at which it begins to fail.

    x is the knob in its unit unless x_label says otherwise; then there may be no mark.
    """

    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    marks: tuple[Mark, ...] = ()
    level: float | None = None
    level_label: str = ""
    log_x: bool = False
    log_y: bool = False


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


Limit = Callable[[Case], float]
Probe = Callable[[float, Case], Evidence]
Curve = Callable[[Case, Progress], Chart]


@dataclass(frozen=True)
class Failure:
    """One way in which a method fails; its file in this folder is found by the name ``FAILURE``.

    knob is what is turned, low to high all that may be tried; below limit(case) the method holds, above it
    fails, for certain from ``margin`` (a share of the limit) on: 0.01 where the boundary is sharp. The limit
    is inf where nothing fails, 0 where nothing holds. A case has one number for each of options. probe tries
    one value of the knob by the code that renders; curve measures many and draws the formula beside them.
    span: the shares of the limit worth turning to.
    """

    key: str
    title: str
    summary: str
    formula: str
    explanation: str
    knob: Parameter
    limit: Limit
    probe: Probe
    curve: Curve
    options: tuple[AnyParameter, ...] = ()
    live: Callable[[float, Case], Live] | None = None
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

    def try_at(self, value: object, options: Mapping[str, object] | None = None) -> Evidence:
        """Return what happens at one value of the knob; raise ParameterError for what cannot be tried."""
        case = self.case(options)
        return self.probe(self.knob.check(value), case)


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


@dataclass(frozen=True)
class Try:
    """One value of the knob, and what it showed."""

    value: float
    evidence: Evidence


@dataclass(frozen=True)
class Shown:
    """A failure in one case: its limit, a try that should hold and one that should fail, the chart if any."""

    failure: Failure
    case: Case
    limit: float
    inside: Try
    outside: Try
    chart: Chart | None = None

    @property
    def as_theory_says(self) -> bool:
        """Say whether the inner try holds and the outer one fails."""
        return self.inside.evidence.holds and not self.outside.evidence.holds


def show(
    failure: Failure,
    options: Mapping[str, object] | None = None,
    *,
    chart: bool = True,
    progress: Progress = no_progress,
) -> Shown:
    """Return a failure tried on both sides of its limit; raise ParameterError for options without a limit."""
    case = failure.case(options)
    if not 0.0 < failure.limit(case) < math.inf:
        what = "fails" if failure.limit(case) else "holds"
        raise ParameterError(f"{failure.title}: nothing {what} with these options, change one of them.")
    values = failure.inside(case), failure.outside(case)
    inside, outside = (Try(value, failure.probe(value, case)) for value in values)
    curve = failure.curve(case, progress) if chart else None
    return Shown(failure, case, failure.limit(case), inside, outside, curve)


def as_json(shown: Shown, traces: bool = False) -> dict[str, Any]:
    """Return a failure shown as one object, SI units; traces: with what moved, and the chart's lines."""
    failure, chart = shown.failure, shown.chart
    pairs = [(p, shown.case[p.key]) for p in failure.options]
    found = {
        "key": failure.key,
        "title": failure.title,
        "formula": failure.formula,
        "knob": failure.knob.key,
        "knob_unit": failure.knob.unit,
        "options": {p.key: p.text(n) if p.discrete else n for p, n in pairs},
        "limit": shown.limit,
        "margin": failure.margin,
        "inside": try_json(shown.inside, traces),
        "outside": try_json(shown.outside, traces),
        "as_theory_says": shown.as_theory_says,
    }
    if traces:
        keys = ("x_label", "y_label", "level", "lines", "marks")
        found["chart"] = {key: getattr(chart, key) for key in keys} if chart else None
    return plain(found)


def try_json(one: Try, traces: bool = False) -> dict[str, Any]:
    """Return one try as an object; a measure that is not finite is None."""
    found = one.evidence
    keys = ("holds", "measure", "measure_unit", "words", *(("time", "trace") if traces else ()))
    labels = {"trace_label": found.label, "trace_unit": found.unit} if traces else {}
    return plain({"value": one.value, **{key: getattr(found, key) for key in keys}, **labels})


# What several failures do alike: sweep, render, judge a motion, write its verdict.


def swept(
    xs: np.ndarray, measure: Callable[[float], float | Sequence[float]], progress: Progress
) -> np.ndarray:
    """Return measure(x) of each x (n,) as (n,) or (n, k), and tell the progress."""
    found = []
    for done, x in enumerate(xs, 1):
        found.append(measure(float(x)))
        progress(done, len(xs))
    return np.array(found)


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
    time: np.ndarray, x: np.ndarray, rate: float, label: str = "position", unit: str = "mm", more: str = ""
) -> Evidence:
    """Return the evidence of a motion x (n,) that grows by rate in 1/s; it holds where that is below 0."""
    time, x = thinned(time, x)
    words = f"{'decays' if rate < 0.0 else 'grows'} by {with_unit(abs(rate), '1/s')}{more}"
    return Evidence(time, x, label, unit, rate < 0.0, rate, "1/s", words)


def growth_chart(
    x_label: str, lines: tuple[Line, ...], marks: tuple[Mark, ...], log_x: bool = False
) -> Chart:
    """Return the chart of a growth in 1/s, which must stay below 0."""
    return Chart(x_label, "growth, 1/s", lines, marks, 0.0, "neither grows nor decays", log_x)


# Points of a trace: a pixel has two of them, its lowest and its highest.
POINTS = 2400


def before_lost(x: np.ndarray, most: float) -> int:
    """Return how many samples of x (n,) come before the first beyond ``most`` or not finite."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.abs(x) <= most)
    return int(np.argmax(lost)) if lost.any() else len(x)


def alive(size: np.ndarray, least: float) -> int:
    """Return how many samples of size (n,) there are up to the last that is ``least`` or more."""
    big = np.flatnonzero(size >= least)
    return int(big[-1]) + 1 if len(big) else 0


def thinned(time: np.ndarray, x: np.ndarray, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Return (time, x) of at most about ``points``: of each piece the lowest and the highest, in order."""
    if len(x) <= points:
        return time, x
    size = -(-2 * len(x) // points)
    count = len(x) // size
    pieces = x[: count * size].reshape(count, size)
    first = size * np.arange(count)
    lowest, highest = first + pieces.argmin(axis=1), first + pieces.argmax(axis=1)
    chosen = np.unique(np.r_[lowest, highest, len(x) - 1])
    return time[chosen], x[chosen]


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

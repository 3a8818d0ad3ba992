"""What a failure is: where a method stops working, why, how to try and chart it, how to feel it live."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hapkit_studio import environments
from hapkit_studio.analysis.sweeps import Progress, no_progress
from hapkit_studio.errors import ParameterError
from hapkit_studio.formatting import json_number
from hapkit_studio.haptics.settings_writer import RATE
from hapkit_studio.parameters import AnyParameter, Choice, Parameter, resolve

__all__ = ["Case", "Chart", "Choice", "Evidence", "Failure", "Line", "Live", "Mark", "Parameter"]
__all__ += [
    "Progress",
    "Shown",
    "Try",
    "as_json",
    "live_rate",
    "no_progress",
    "short",
    "show",
    "try_json",
    "within",
]

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
    failure = shown.failure
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
    return {**found, "chart": _chart_json(shown.chart) if shown.chart else None} if traces else found


def try_json(one: Try, traces: bool = False) -> dict[str, Any]:
    """Return one try as an object; a measure that is not finite is None."""
    found = one.evidence
    made = {
        "value": one.value,
        "holds": found.holds,
        "measure": json_number(found.measure),
        "measure_unit": found.measure_unit,
        "words": found.words,
    }
    if not traces:
        return made
    trace = [json_number(y) for y in found.trace]
    labels = {"trace_label": found.label, "trace_unit": found.unit}
    return {**made, "time": [float(t) for t in found.time], "trace": trace, **labels}


def _chart_json(chart: Chart) -> dict[str, Any]:
    lines = [
        {
            "label": one.label,
            "role": one.role,
            "x": list(map(json_number, one.x)),
            "y": list(map(json_number, one.y)),
        }
        for one in chart.lines
    ]
    return {
        "x_label": chart.x_label,
        "y_label": chart.y_label,
        "level": chart.level,
        "lines": lines,
        "marks": [{"label": mark.label, "x": mark.x} for mark in chart.marks],
    }

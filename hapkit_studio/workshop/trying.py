"""Try an environment: read, check and compile it, and call its functions at extreme values.

A law is called at the corners of its parameter ranges and over the range of positions and speeds.
"""

import math
import random
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hapkit_studio.dynamics import nominal
from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.errors import LawError
from hapkit_studio.haptics import arrays
from hapkit_studio.parameters import AnyParameter, Choice
from hapkit_studio.workshop import functions, own, reading
from hapkit_studio.workshop.source import Source

CALLS = 10_000
# processor time in s after which a slow law is called no more: a trial must end before its time-out
CALLING_SECONDS = 2.0
PERIODS = (1e-3, 1e-4, 1e-2)
FAR, FAST, QUANTUM = 0.06, 3.0, nominal.QUANTUM
POSITIONS = (0.005, -0.005, 0.03, -0.03, FAR, -FAR)
SPEEDS = (0.0, 0.1, -0.1, FAST, -FAST)
_RESTING, _STEPS, _WANDER = 5, 8, 100
_MOST_BY_CHANCE = 400

Values = dict[str, float]


@dataclass(frozen=True)
class Problem:
    """A problem that prevents an environment from running: its text, and its line or 0 if it is unknown."""

    line: int
    text: str

    def __str__(self) -> str:
        return f"Line {self.line}: {self.text}." if self.line else f"{self.text[:1].upper()}{self.text[1:]}."


@dataclass(frozen=True)
class TrialResult:
    """The outcome of a trial; if there are no problems, the environment may run in the loop.

    ``warnings`` concern the whole law, and ``remarks`` single lines. ``ns_per_call`` and ``calls`` are 0 if
    the law was not called.
    """

    problems: tuple[Problem, ...] = ()
    warnings: tuple[str, ...] = ()
    ns_per_call: float = 0.0
    calls: int = 0
    remarks: tuple[Problem, ...] = ()

    @property
    def ok(self) -> bool:
        return not self.problems

    @classmethod
    def from_json(cls, found: dict) -> "TrialResult":
        """Return the outcome from a dict made by ``asdict``.

        Raise ValueError, TypeError or KeyError for any other dict.
        """
        problems, remarks = (
            tuple(Problem(int(p["line"]), str(p["text"])) for p in found[key])
            for key in ("problems", "remarks")
        )
        warnings = tuple(str(w) for w in found["warnings"])
        return cls(problems, warnings, float(found["ns_per_call"]), int(found["calls"]), remarks)


def failed(text: str, line: int = 0) -> TrialResult:
    """Return the outcome with one problem."""
    return TrialResult((Problem(line, text),))


@dataclass(frozen=True)
class Sequence:
    """Consecutive calls with one state: parameters by key, x in m and v in m/s (n,), period in s."""

    values: Values
    x: np.ndarray
    v: np.ndarray
    dt: float


def sequences(environment: Environment) -> Iterator[Sequence]:
    """Yield sequences with at least CALLS calls in total; sequences near the defaults come first.

    Combinations of values that the environment itself rejects are left out.
    """
    parameters, calls = environment.parameters, 0
    for values in filter(lambda v: not environment.check(v), near(parameters)):
        for dt in PERIODS:
            x, v = visits(places(parameters, values), dt)
            yield Sequence(values, x, v, dt)
            calls += len(x)
    chance = random.Random(1)
    for turn in range(_MOST_BY_CHANCE):
        values = {p.key: chance.choice([*_ends(p), p.default]) for p in parameters}
        if calls < CALLS and not environment.check(values):
            dt = PERIODS[turn % len(PERIODS)]
            x, v = wander(chance, dt)
            yield Sequence(values, x, v, dt)
            calls += len(x)


def near(parameters: tuple[AnyParameter, ...]) -> Iterator[Values]:
    """Yield the defaults, then each parameter at its limits, then all at their lower and upper limits."""
    start = {p.key: p.default for p in parameters}
    yield start
    for p in parameters:
        yield from ({**start, p.key: value} for value in _ends(p) if value != p.default)
    if len(parameters) > 1:
        yield {p.key: p.low for p in parameters}
        yield {p.key: p.high for p in parameters}


def places(parameters: tuple[AnyParameter, ...], values: Values) -> list[float]:
    """Return test positions in m, which include parameters that are lengths."""
    own = [sign * values[p.key] for p in parameters if p.unit == "m" for sign in (1.0, -1.0)]
    return list(dict.fromkeys([*(x for x in own if abs(x) <= FAR), *POSITIONS]))


def visits(at: list[float], dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return positions x in m and speeds v in m/s (n,) for calls of a law.

    The handle is at rest, then at each position with each speed. It then moves past each position by single
    sensor steps, and is at rest again.
    """
    x, v = [0.0] * _RESTING, [0.0] * _RESTING
    for place in at:
        x += [place] * len(SPEEDS)
        v += SPEEDS
    for place in at:
        x += [place + QUANTUM * (i - _STEPS // 2) for i in range(_STEPS)]
        v += [QUANTUM / dt] * _STEPS
    return np.array(x + [x[-1]] * _RESTING), np.array(v + [0.0] * _RESTING)


def wander(chance: random.Random, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x in m and v in m/s (n,) of a random motion in whole sensor counts."""
    swing, rate, phase = chance.uniform(0.001, FAR), chance.uniform(0.5, 8.0), chance.uniform(0.0, math.tau)
    t = dt * np.arange(_WANDER)
    x = QUANTUM * np.floor(swing * np.sin(math.tau * rate * t + phase) / QUANTUM)
    return x, np.clip(np.diff(x, prepend=x[0]) / dt, -FAST, FAST)


def _ends(p: AnyParameter) -> list[float]:
    return [float(i) for i in range(len(p.options))] if isinstance(p, Choice) else [p.low, p.high]


# a slower law gets a warning: this is 5 % of the shortest period, which is 100 µs
SLOW_NS = 5_000.0
ALONG = np.linspace(-FAR, FAR, 25)
_SAID = {
    arrays.LAW_INDEX: (
        "the index is outside the state or table",
        "keep it between 0 and the number of values minus 1",
    ),
    arrays.LAW_FUEL: ("the law takes too long", "let its loops run fewer times"),
    arrays.LAW_DIVISION: (
        "a division by zero",
        "test the divisor first, or set the parameter's lower limit above 0",
    ),
    arrays.NOT_A_NUMBER: (
        "the result is not a finite number",
        "test for it first, or narrow the parameter's limits",
    ),
}
# arguments of the functions other than the law, in addition to the parameter values
_ARGUMENTS = {"warnings": (Conditions(),), "over_position": (ALONG,), "over_velocity": (ALONG,)}


def try_out(source: Source, report: Callable[[str, int], object] = lambda name, line: None) -> TrialResult:
    """Return the verdict on a text; ``report`` is called with name and line before each function."""
    try:
        return _try(reading.execute(source), source.path, report)
    except LawError as error:
        return failed(reading.without_line(error), error.line)


def _try(environment: Environment, path: Path, report: Callable[[str, int], object]) -> TrialResult:
    """Compile the law and call all functions; raise LawError with its line."""
    law_line = environment.force.function.__code__.co_firstlineno
    try:
        environment.force.compiled()
        for name in functions.overridden(environment):
            report(name, _first_line(getattr(environment, name)))
            _try_function(environment, name)
        return _try_law(environment)
    except LawError as error:
        raise LawError(reading.without_line(error), error.line or law_line) from None
    except (Exception, SystemExit) as error:  # a user's functions or a compiler may raise anything
        raise reading.law_error(error, str(path), law_line) from None


def _try_function(environment: Environment, name: str) -> None:
    """Call a function of the environment at extreme values; raise LawError for an invalid result."""
    function, (convert, _, wanted) = getattr(environment, name), functions.GIVES[name]
    if complaint := environment.check({p.key: p.default for p in environment.parameters}):
        raise LawError(f"the defaults contradict each other: {complaint}", _first_line(environment.check))
    for values in near(environment.parameters):
        if name != "check" and environment.check(values):
            continue
        found = function(values, *_ARGUMENTS.get(name, ()))
        try:
            shape = np.shape(convert(found))
        except (TypeError, ValueError):
            line = _first_line(function)
            raise LawError(f"this function must return {wanted}, not {found!r:.60}", line) from None
        if name.startswith("over_") and shape[-1:] != ALONG.shape:
            raise LawError(
                "a curve must return one value for each position that it is given", _first_line(function)
            )


def _first_line(function: Callable) -> int:
    return getattr(getattr(function, "__code__", None), "co_firstlineno", 0)


def _try_law(environment: Environment) -> TrialResult:
    """Call the law at extreme values for up to CALLING_SECONDS; raise LawError if it returns no force."""
    law, costs, calls, pushes = environment.force.compiled(), [], 0, False
    start = time.process_time()
    for sequence in sequences(environment):
        p = np.array([sequence.values[q.key] for q in environment.parameters] + [0.0])
        state, fault = own.law_memory(law)
        force = np.zeros(len(sequence.x))
        begin = time.perf_counter_ns()
        wrong = own.call_law(law.address, p, state, sequence.x, sequence.v, sequence.dt, fault, force)
        costs.append((time.perf_counter_ns() - begin) / len(force))
        if wrong != own.NO_FAULT:
            raise LawError(_text(environment, sequence, wrong, int(fault[0])), int(fault[1]))
        calls += len(force)
        pushes = pushes or bool(force.any())
        if time.process_time() - start > CALLING_SECONDS:
            break
    cost = float(np.median(costs))  # the median is robust against other load on the computer
    return TrialResult((), tuple(_warnings(environment, cost, pushes)), cost, calls, remarks(environment))


def remarks(environment: Environment) -> tuple[Problem, ...]:
    """Return the advice on single lines of a law."""
    return tuple(Problem(r.line, r.text) for r in environment.force.remarks)


def _text(environment: Environment, sequence: Sequence, call: int, code: int) -> str:
    """Return the message about a failed call: fault, arguments, remedy."""
    at = [f"x = {1e3 * sequence.x[call]:.6g} mm", f"v = {sequence.v[call]:.6g} m/s"]
    changed = [p for p in environment.parameters if sequence.values[p.key] != p.default]
    at += [f"{p.key} = {p.text(sequence.values[p.key])}" for p in changed]
    what, to_do = _SAID[code]
    return f"{what} at {', '.join(at).replace('-', '−')}: {to_do}"


def _warnings(environment: Environment, cost: float, pushes: bool) -> Iterator[str]:
    """Yield warnings that do not prevent the environment from running."""
    if cost > SLOW_NS:
        yield f"One call of the law takes {cost / 1000:,.0f} µs: the loop may be too slow for 10 kHz."
    if not pushes:
        yield "The law has no effect: the force was 0 N each time that it was tried."
    used = set(re.findall(r"\bp\[(\d+)\]", environment.force.source.partition("\ndef law(")[2]))
    for i, p in enumerate(environment.parameters):
        if str(i) not in used:
            yield f"{p.label} has no effect: the law does not use p.{p.key}."

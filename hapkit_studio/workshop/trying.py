"""Tries out an environment's text: read, checked, compiled, called at its corners."""

import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.errors import LawError
from hapkit_studio.haptics import arrays
from hapkit_studio.workshop import calls, corners, functions, reading, words
from hapkit_studio.workshop.source import Source
from hapkit_studio.workshop.verdict import Verdict, failed

# what a law may take of the shortest period, 100 µs, before it is said
SLOW_NS = 5_000.0
ALONG = np.linspace(-corners.FAR, corners.FAR, 25)
_WHAT = {
    arrays.LAW_INDEX: "the index lies beyond the state",
    arrays.LAW_FUEL: "this does not come to an end",
    arrays.LAW_DIVISION: "a division by zero",
}
_DO = {
    arrays.LAW_INDEX: "keep it from 0 to below the number of values",
    arrays.LAW_FUEL: "use fewer turns",
    arrays.LAW_DIVISION: "test the divisor first, or begin the parameter's limits above 0",
}
_NO_NUMBER, _DO_NUMBER = "this gives no finite number", "test for it first, or narrow the parameter's limits"


# what the other functions are given beside the values, and what they return
_MORE = {"warnings": (Conditions(),), "over_position": (ALONG,), "over_velocity": (ALONG,)}
_RETURNS = {
    "check": "text",
    "warnings": "a list of text",
    "unused": "text by the names of parameters",
    "impedance": "(stiffness, damping)",
    "over_position": "numbers",
    "over_velocity": "numbers",
}


@dataclass
class _Tally:
    """The calls so far, the ns of a call in each sequence, and whether any force was not 0."""

    calls: int = 0
    costs: list[float] = field(default_factory=list)
    pushes: bool = False

    @property
    def cost(self) -> float:
        """Return the median: what else the machine does meanwhile is none of the law's."""
        return float(np.median(self.costs))


def try_out(source: Source, tell: Callable[[str, int], object] = lambda name, line: None) -> Verdict:
    """Return the verdict on a text; tell each function's name and line before it is called."""
    try:
        environment = reading.execute(source)
        tally = _try(environment, source.path, tell)
    except LawError as error:
        return failed(words.plain(error), error.line)
    return Verdict((), _remarks(environment, tally), tally.cost, tally.calls)


def _try(environment: Environment, path: Path, tell: Callable[[str, int], object]) -> _Tally:
    """Compile the law, call it and the environment's other functions; raise LawError with its line."""
    law_line = environment.force.function.__code__.co_firstlineno
    try:
        environment.force.compiled()
        for name in functions.brought(environment):
            tell(name, _first_line(getattr(environment, name)))
            _try_function(environment, name)
        return _try_law(environment)
    except LawError as error:
        raise LawError(words.plain(error), error.line or law_line) from None
    except (Exception, SystemExit) as error:  # whatever a person's functions, or a compiler, raise
        raise words.of_exception(error, str(path), law_line) from None


def _try_function(environment: Environment, name: str) -> None:
    """Call one of the environment's own functions at its corners; raise LawError for nonsense."""
    function, (convert, _) = getattr(environment, name), functions.GIVES[name]
    if complaint := environment.check({p.key: p.default for p in environment.parameters}):
        raise LawError(f"the defaults do not go together: {complaint}", _first_line(environment.check))
    for values in corners.near(environment.parameters):
        if name != "check" and environment.check(values):
            continue
        found = function(values, *_MORE.get(name, ()))
        try:
            shape = np.shape(convert(found))
        except (TypeError, ValueError):
            line = _first_line(function)
            raise LawError(f"this function returns {_RETURNS[name]}, not {found!r:.60}", line) from None
        if convert is functions.numbers and shape[-1:] != ALONG.shape:
            raise LawError("a curve has one value for each place it is asked at", _first_line(function))


def _first_line(function: Callable) -> int:
    code = getattr(function, "__code__", None)
    return code.co_firstlineno if code else 0


def _try_law(environment: Environment) -> _Tally:
    """Call the law at its corners; raise LawError where it gives no force."""
    law, tally = environment.force.compiled(), _Tally()
    for sequence in corners.sequences(environment):
        p = np.array([sequence.values[q.key] for q in environment.parameters] + [0.0])
        state, fault = calls.memory(law)
        force = np.zeros(len(sequence.x))
        begin = time.perf_counter_ns()
        wrong = calls.run(law.address, p, state, sequence.x, sequence.v, sequence.dt, fault, force)
        spent = time.perf_counter_ns() - begin
        if wrong != calls.ALL:
            raise LawError(_words(environment, sequence, wrong, int(fault[0])), int(fault[1]))
        tally.costs.append(spent / len(force))
        tally.calls += len(force)
        tally.pushes = tally.pushes or bool(force.any())
    return tally


def _words(environment: Environment, sequence: corners.Sequence, call: int, code: int) -> str:
    """Return what happened, at which arguments, and what to do."""
    at = [f"x = {1e3 * sequence.x[call]:.6g} mm", f"v = {sequence.v[call]:.6g} m/s"]
    changed = [p for p in environment.parameters if sequence.values[p.key] != p.default]
    at += [f"{p.key} = {p.text(sequence.values[p.key])}" for p in changed]
    where = ", ".join(at).replace("-", "−")
    return f"{_WHAT.get(code, _NO_NUMBER)} at {where}: {_DO.get(code, _DO_NUMBER)}"


def _remarks(environment: Environment, tally: _Tally) -> tuple[str, ...]:
    """Return what is no problem, but worth a look."""
    found = []
    if tally.cost > SLOW_NS:
        found.append(f"One call of the law takes {tally.cost / 1000:.0f} µs: the loop may not keep 10 kHz.")
    if not tally.pushes:
        found.append("The law never pushed: its force was 0 N in every call.")
    used = set(re.findall(r"\bp\[(\d+)\]", environment.force.source.partition("\ndef law(")[2]))
    for i, p in enumerate(environment.parameters):
        if str(i) not in used:
            found.append(f"{p.label} changes nothing: the law does not use p.{p.key}.")
    return tuple(found)

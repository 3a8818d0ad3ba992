"""Tries out an environment's text: read, checked, compiled, called at its corners."""

import re
import time
from pathlib import Path

import numpy as np

from hapkit_studio.environments.base import Conditions, Environment
from hapkit_studio.errors import LawError
from hapkit_studio.haptics import rig
from hapkit_studio.workshop import calls, corners, reading, tried, trust, words
from hapkit_studio.workshop.verdict import Verdict, failed

# what a law may take of the shortest period, 100 µs, before it is said
SLOW_NS = 5_000.0
_AT = {
    rig.LAW_INDEX: "the index lies beyond the state",
    rig.LAW_FUEL: "this does not come to an end",
    rig.LAW_DIVISION: "a division by zero",
}
_DO = {
    rig.LAW_INDEX: "keep it from 0 to below the number of values",
    rig.LAW_FUEL: "use fewer turns",
    rig.LAW_DIVISION: "test the divisor first, or begin the parameter's limits above 0",
}
_NO_NUMBER, _DO_NUMBER = "this gives no finite number", "test for it first, or narrow the parameter's limits"


def try_file(path: Path, wanted: str = "") -> Verdict:
    """Return the verdict on a file; one without problems is remembered as tried.

    Where a wanted digest is given, a file of another text is not executed.
    """
    digest = ""
    try:
        text = reading.text_of(path)
        digest = trust.digest(text)
        if wanted not in ("", digest):
            raise LawError("the file has changed meanwhile: try again")
        environment = reading.execute(text, path)
        verdict = _try(environment, path, digest)
    except LawError as error:
        return failed(words.plain(error), error.line, digest)
    if verdict.ok:
        tried.passed(text, path, environment)
    return verdict


def _try(environment: Environment, path: Path, digest: str) -> Verdict:
    law_line = environment.force.function.__code__.co_firstlineno
    try:
        environment.force.compiled()
    except LawError as error:
        return failed(words.plain(error), error.line or law_line, digest)
    except (RecursionError, MemoryError):
        return failed("the law is too long to be compiled", law_line, digest)
    try:
        _try_functions(environment)
        problem, cost, count, pushes = _call(environment)
    except (Exception, SystemExit) as error:  # whatever a person's functions raise
        wrong = words.of_exception(error, str(path))
        return failed(words.plain(wrong), wrong.line, digest)
    if problem:
        return failed(problem[1], problem[0] or law_line, digest)
    return Verdict((), _remarks(environment, cost, pushes), cost, count, digest)


def _try_functions(environment: Environment) -> None:
    """Call the environment's own functions at its corners; raise what they raise, LawError for nonsense."""
    start = {p.key: p.default for p in environment.parameters}
    along = np.linspace(-corners.FAR, corners.FAR, 25)
    complaint = environment.check(start)
    if complaint:
        raise LawError(f"the defaults do not go together: {complaint}")
    for values in corners.near(environment.parameters):
        if environment.check(values):
            continue
        list(environment.warnings(values, Conditions()))
        if environment.impedance and environment.impedance(values) is not None:
            stiffness, damping = environment.impedance(values)
            float(stiffness), float(damping)
        for curve in filter(None, (environment.over_position, environment.over_velocity)):
            if np.asarray(curve(values, along), dtype=float).shape[-1:] != along.shape:
                raise LawError("a curve has one value for every position or velocity it is asked at")


def _call(environment: Environment) -> tuple[tuple[int, str] | None, float, int, bool]:
    """Call the law at its corners; return (problem, ns a call, calls, whether it ever pushed)."""
    law = environment.force.compiled()
    count, spent, pushes = 0, 0, False
    for sequence in corners.sequences(environment):
        p = np.array([sequence.values[q.key] for q in environment.parameters] + [0.0])
        state, fault = calls.memory(law.initial_state)
        force = np.zeros(len(sequence.x))
        begin = time.perf_counter_ns()
        wrong = calls.run(law.address, p, state, sequence.x, sequence.v, sequence.dt, fault, force)
        # the first sequence pays for calling the compiled loop at all
        spent += time.perf_counter_ns() - begin if count else 0
        count += len(force)
        if wrong != calls.ALL:
            return (int(fault[1]), _words(environment, sequence, wrong, int(fault[0]))), 0.0, count, pushes
        pushes = pushes or bool(force.any())
    return None, spent / max(count - len(sequence.x), 1), count, pushes


def _words(environment: Environment, sequence: corners.Sequence, call: int, code: int) -> str:
    """Return what happened, at which arguments, and what to do."""
    at = [f"x = {_plain(1e3 * sequence.x[call])} mm", f"v = {_plain(sequence.v[call])} m/s"]
    at += [
        f"{p.key} = {_plain_text(p.text(sequence.values[p.key]))}"
        for p in environment.parameters
        if sequence.values[p.key] != p.default
    ]
    return f"{_AT.get(code, _NO_NUMBER)} at {', '.join(at)}: {_DO.get(code, _DO_NUMBER)}"


def _remarks(environment: Environment, cost: float, pushes: bool) -> tuple[str, ...]:
    """Return what is no problem, but worth a look."""
    found = []
    if cost > SLOW_NS:
        found.append(f"One call of the law takes {cost / 1000:.0f} µs: the loop may not keep 10 kHz.")
    if not pushes:
        found.append("The law never pushed: its force was 0 N in every call.")
    used = set(re.findall(r"\bp\[(\d+)\]", environment.force.source.partition("\ndef law(")[2]))
    for i, p in enumerate(environment.parameters):
        if str(i) not in used:
            found.append(f"{p.label} changes nothing: the law does not use p.{p.key}.")
    return tuple(found)


def _plain(number: float) -> str:
    return _plain_text(f"{number:.6g}")


def _plain_text(text: str) -> str:
    return text.replace("-", "−")

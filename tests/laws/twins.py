"""Comparison of a law on the board's machine, built for this computer, with the law in double precision."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from hapkit_studio.laws import native
from hapkit_studio.laws.board import Program
from hapkit_studio.laws.law import Law, _Option, _Values
from hapkit_studio.laws.machine import Refusal
from hapkit_studio.parameters import Choice
from tests.laws.error_analysis import Analysis, Fault, Unclear, single
from tests.laws.machine_pc import Machine


class NoNumber(Exception):
    """Raised where plain Python fails and compiled code continues with inf or NaN."""


class Compiled:
    """The law as numba has compiled it for the loop."""

    def __init__(self, law: Law, values: Mapping[str, float], period: float):
        self._law, self.period = law.compiled(), period
        self._function = native.Function(self._law.address)
        self._p = np.array([values[p.key] for p in law.parameters] + [0.0])
        self._s = np.append(law.initial_state, 0.0)
        self._fault = np.zeros(native.FAULT_WORDS, np.int64)

    @property
    def state(self) -> list[float]:
        return self._s[:-1].tolist()

    def set_state(self, values) -> None:
        self._s[:-1] = values

    def call(self, x: float, v: float) -> float:
        """Return the force in N, or NaN if the law latches a fault."""
        self._fault[:] = 0
        force = self._function(
            self._p.ctypes.data, self._s.ctypes.data, x, v, self.period, self._fault.ctypes.data
        )
        return math.nan if self._fault[0] else force


class Plain:
    """The law as the plain Python function."""

    def __init__(self, law: Law, values: Mapping[str, float], period: float):
        self._law, self.period = law, period
        named = {
            p.key: _Option(values[p.key], p) if isinstance(p, Choice) else values[p.key]
            for p in law.parameters
        }
        self._p = SimpleNamespace(**named)
        self.set_state(law.initial_state.tolist())

    @property
    def state(self) -> list[float]:
        found: list[float] = []
        for key in self._law.state:
            value = getattr(self._s, key)
            found += map(float, value) if isinstance(value, list) else [float(value)]
        return found

    def set_state(self, values) -> None:
        self._s, left = SimpleNamespace(), list(values)
        for key, start in self._law.state.items():
            size = len(start) if isinstance(start, tuple) else 0
            setattr(self._s, key, _Values(left[:size]) if size else left[0])
            left = left[size or 1 :]

    def call(self, x: float, v: float) -> float:
        """Return the force in N, or NaN if the law latches a fault.

        Raise NoNumber if plain Python fails where compiled code continues with inf or NaN.
        """
        try:
            force = float(self._law.function(self._p, self._s, x, v, self.period))
        except ZeroDivisionError as error:
            if "power" in str(error):
                raise NoNumber from error
            return math.nan
        except IndexError:
            return math.nan
        # examples are sqrt(-1), exp(1000) and (-1) ** 0.5 < 1
        except (ValueError, OverflowError, TypeError) as error:
            raise NoNumber from error
        return force if math.isfinite(force) else math.nan


@dataclass
class Found:
    """Results of a comparison: numbers of rows, compared rows, faults and restarts; largest error in N."""

    rows: int = 0
    compared: int = 0
    faults: int = 0
    worst: float = 0.0
    restarts: int = 0
    forces: list[float] = field(default_factory=list)


@dataclass
class _Row:
    """The law's result in one call, and the board's error bound; ``clear`` means that both are comparable."""

    force: float
    bound: float
    state: list[float]
    bounds: list[float]
    clear: bool = True


class Apart(AssertionError):
    """Raised if board and law differ by more than rounding errors."""


def compare(
    machine: Machine, program: Program, truth: Compiled | Plain, rows, useful: Callable[[float], float]
) -> Found:
    """Run the machine and the law on the same rows of position and velocity; raise Apart if they differ.

    ``program`` has unrounded constants. A row is compared if rounding cannot change any of the law's
    decisions and the force's error bound is at most useful(force) in N. After other rows, and if errors have
    grown, both restart with the same state.
    """
    given = [single(g) for g in program.given]
    loaded = machine.load(program.states, given, program.slots, program.code)
    assert loaded.refusal == Refusal.NONE, loaded
    assert loaded.cycles == program.most
    analysis, found = Analysis(program), Found()
    rows = np.asarray(rows, np.float32).astype(float).tolist()
    first = [single(s) for s in truth.state]
    at, state = 0, first
    while at < len(rows):
        truth.set_state(state)
        analysis.set_state(state)
        for i, value in enumerate(state):
            machine.set(2 + i, value)
        expected = _until_unclear(analysis, truth, rows[at:], useful)
        forces, states = machine.run(rows[at : at + len(expected)])
        assert machine.counted <= len(expected) * program.most
        for k, (row, force, after) in enumerate(zip(expected, forces.tolist(), states.tolist(), strict=True)):
            if row.clear:
                _hold(row, force, after, (at + k, rows[at + k]))
                found.compared += 1
                found.faults += math.isnan(row.force)
                found.worst = max(found.worst, 0.0 if math.isnan(row.force) else abs(force - row.force))
                found.forces.append(row.force)
        at += len(expected)
        found.restarts += 1
        state = [single(s) for s in truth.state]
        if not all(math.isfinite(s) and abs(s) < 1e30 for s in state):
            state = first
    found.rows = len(rows)
    return found


def _until_unclear(analysis: Analysis, truth, rows, useful) -> list[_Row]:
    """Return the analysed rows up to the next restart."""
    found: list[_Row] = []
    for x, v in rows:
        before = truth.state
        try:
            force = truth.call(x, v)
        except NoNumber:
            return [*found, _Row(math.nan, 0.0, [], [], False)]
        try:
            value, bound = analysis.call(x, v)
        except Unclear:
            return [*found, _Row(force, 0.0, [], [], False)]
        except Fault:
            return [*found, _Row(math.nan, 0.0, [], [])] if math.isnan(force) else _missed(force, x, v)
        if not math.isfinite(value):
            if math.isfinite(force):
                _missed(force, x, v)
            return [*found, _Row(math.nan, 0.0, [], [])]
        state, bounds = truth.state, [e for _, e in analysis.state]
        mine = [value, *(s for s, _ in analysis.state)]
        if not all(map(_same, mine, [force, *state], [bound, *bounds])):
            if analysis.zero_sign or _is_uncertain(truth, before, x, v, [force, *state]):
                return [*found, _Row(force, 0.0, [], [], False)]
            raise Apart(f"the code has force and state {mine} at {x!r}, {v!r}, the law {[force, *state]}")
        found.append(_Row(force, bound, state, bounds, bound <= useful(force)))
        grown = any(e > 1e-3 * (1.0 + abs(s)) for s, e in zip(state, bounds, strict=True))
        if grown or bound > 0.5 * useful(force) or not all(map(math.isfinite, state)):
            return found
    return found


def _same(mine: float, wanted: float, bound: float) -> bool:
    """Return True if two numbers differ at most by double-precision rounding in a different order."""
    if not math.isfinite(wanted):
        return not math.isfinite(mine)
    return abs(mine - wanted) <= 1e-6 * bound + 1e-12 * abs(wanted)


def _is_uncertain(truth, before, x, v, wanted) -> bool:
    """Return True if changing the law's input in its last places changes the result."""
    after, period = truth.state, truth.period
    moved = False
    for factor in (1.0 + k * 2e-16 for k in (-9, -5, -4, -2, -1, 1, 2, 4, 5, 9)):
        truth.set_state([factor * s for s in before])
        truth.period = factor * period
        try:
            found = [truth.call(factor * x, factor * v), *truth.state]
        except NoNumber:
            moved = True
            break
        moved = moved or not all(map(_same, found, wanted, [0.0] * len(wanted)))
    truth.set_state(after)
    truth.period = period
    return moved


def _missed(force: float, x: float, v: float):
    raise Apart(f"the code has no force, the law has {force!r} N at {x!r}, {v!r}")


def _hold(row: _Row, force: float, state, where) -> None:
    if math.isnan(row.force):
        if math.isfinite(force):
            raise Apart(f"row {where}: the board has {force!r} N where the law has none")
        return
    if not abs(force - row.force) <= 1.001 * row.bound + 1e-12 * abs(row.force):
        raise Apart(f"row {where}: the board has {force!r} N, the law {row.force!r} N, bound {row.bound!r}")
    for i, (mine, wanted, bound) in enumerate(zip(state, row.state, row.bounds, strict=True)):
        same = mine == wanted or (math.isnan(mine) and math.isnan(wanted))
        if not same and not abs(mine - wanted) <= 1.001 * bound + 1e-12 * abs(wanted):
            raise Apart(
                f"row {where}: state {i} is {mine!r} on the board, {wanted!r} in the law, bound {bound!r}"
            )

"""An environment that a person wrote: its law only ever runs compiled, its words can raise nothing."""

import ctypes
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

import numpy as np

from hapkit_studio import environments
from hapkit_studio.environments.base import Environment, Values
from hapkit_studio.laws import Law, native

_DOUBLES = ctypes.POINTER(ctypes.c_double)
_FORCE = ctypes.CFUNCTYPE(
    ctypes.c_double,
    _DOUBLES,
    _DOUBLES,
    ctypes.c_double,
    ctypes.c_double,
    ctypes.c_double,
    ctypes.POINTER(ctypes.c_int64),
)
_DT = 1e-3


@dataclass(frozen=True, kw_only=True)
class OwnEnvironment(Environment):
    """An environment read from a person's file: the file, and the text it had."""

    file: Path
    text: str

    def curve(self, values: Values, position: np.ndarray, velocity: float = 0.0) -> np.ndarray:
        """Return the compiled law's force (n,) in N at rest, its state at the start; nan where it faults."""
        force = caller(self.force)
        p = np.array([values[q.key] for q in self.parameters] + [0.0])
        return np.array([force(p, x, velocity) for x in map(float, position)])


@cache
def built_in() -> Mapping[str, Environment]:
    """Return the studio's own environments by key, without those of other packages."""
    here = environments.__name__ + "."
    return {k: e for k, e in environments.discover().items() if e.force.function.__module__.startswith(here)}


def owned(environment: Environment, file: Path, text: str) -> OwnEnvironment:
    """Return an environment marked as a person's own; it has no shortcut."""
    given = {f.name: getattr(environment, f.name) for f in fields(Environment) if f.init}
    given |= {"parameters": tuple(environment.parameters), "shortcut": ""}
    for name, otherwise in (("impedance", None), ("check", ""), ("warnings", ())):
        given[name] = given[name] and _quiet(given[name], otherwise)
    for name in ("over_position", "over_velocity"):
        given[name] = given[name] and _quiet_curve(given[name])
    return OwnEnvironment(**given, file=file, text=text)


def caller(law: Law) -> Callable[[np.ndarray, float, float], float]:
    """Return the compiled law as a function (parameters, x m, v m/s) -> N, its state at the start."""
    compiled = law.compiled()
    if native.INTERPRETED:

        def interpreted(p: np.ndarray, x: float, v: float) -> float:
            state, fault = np.append(compiled.initial_state, 0.0), np.zeros(2, dtype=np.int64)
            force = native.call(compiled.address, p, state, x, v, _DT, fault)
            return math.nan if fault[0] else float(force)

        return interpreted
    function = _FORCE(compiled.address)

    def force(p: np.ndarray, x: float, v: float) -> float:
        state, fault = np.append(compiled.initial_state, 0.0), (ctypes.c_int64 * 2)()
        found = function(p.ctypes.data_as(_DOUBLES), state.ctypes.data_as(_DOUBLES), x, v, _DT, fault)
        return math.nan if fault[0] else found

    return force


def _quiet(function: Callable, otherwise: object) -> Callable:
    """Return a function that answers something harmless where the person's own raises."""

    def guarded(*args):
        try:
            return function(*args)
        except Exception:  # whatever a person's function raises
            return otherwise

    return guarded


def _quiet_curve(function: Callable) -> Callable:
    def guarded(values: Values, along: np.ndarray) -> np.ndarray:
        try:
            return np.asarray(function(values, along), dtype=float)
        except Exception:  # whatever a person's function raises
            return np.full(len(along), math.nan)

    return guarded

"""An environment that a person wrote: its law only ever runs compiled, its functions in another process.

A compiled law is called many times in a row from compiled code, or once without compiling anything.
"""

import ast
import inspect
import math
import pkgutil
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import cache, partial
from typing import Any

import numpy as np

from hapkit_studio import environments, resources
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.environments.base import Conditions, Environment, Values
from hapkit_studio.laws import native
from hapkit_studio.laws.law import CompiledLaw
from hapkit_studio.laws.native import FAULT_WORDS
from hapkit_studio.workshop.functions import Functions, overridden
from hapkit_studio.workshop.source import Source

# what `call_law` returns where every call gave a force
NO_FAULT = -1
_DT = 1e-3
CURVE_SECONDS = 0.5
"""s of processor time for a curve: the window waits for it."""


@compiled
def call_law(address, p, s, x, v, dt, fault, force):
    """Call a law at every x (n,) m and v (n,) m/s into force (n,) N; return the call that failed.

    NO_FAULT where none did. fault holds FAULT_WORDS words, the code being 0 where there is none.
    """
    for i in range(len(x)):
        force[i] = native.call(address, p, s, x[i], v[i], dt, fault)
        if fault[0] != 0:
            return i
    return NO_FAULT


def law_memory(law: CompiledLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return a law's state at its start, with a spare value where it has none, and its fault words."""
    return np.append(law.initial_state, 0.0), np.zeros(FAULT_WORDS, dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class OwnEnvironment(Environment):
    """An environment read from a person's file, and that file as it was read."""

    source: Source
    functions: Functions | None = None

    def curve(self, values: Values, position: np.ndarray, velocity: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the compiled law's force (n,) in N, its state at the start.

        NaN where it faults, and for the rest once CURVE_SECONDS have passed.
        """
        law = self.force.compiled()
        p = np.array([values[q.key] for q in self.parameters] + [0.0])
        state, fault = law_memory(law)
        start = state.copy()
        if native.INTERPRETED:
            call = partial(native.call, law.address, p, state)
            words: Any = fault
        else:
            call = partial(native.Function(law.address), p.ctypes.data, state.ctypes.data)
            words = fault.ctypes.data
        points = np.broadcast_arrays(position, velocity)
        forces = np.full(points[0].shape, math.nan)
        end = time.thread_time() + CURVE_SECONDS
        for i, (x, v) in enumerate(zip(*(a.tolist() for a in points), strict=True)):
            if time.thread_time() > end:
                break
            state[:], fault[0] = start, 0
            force = call(x, v, _DT, words)
            forces[i] = math.nan if fault[0] else force
        return forces


@cache
def built_in() -> Mapping[str, Environment]:
    """Return the studio's own environments by key, without those of other packages."""
    here = environments.__name__ + "."
    return {k: e for k, e in environments.discover().items() if e.force.function.__module__.startswith(here)}


def taken_keys() -> set[str]:
    """Return the keys of the studio's own environments: the names of their files, none of them loaded."""
    return {module.name for module in pkgutil.iter_modules(environments.__path__)}


def owned(environment: Environment, source: Source) -> OwnEnvironment:
    """Return an environment marked as a person's own; it has no shortcut."""
    given = {f.name: getattr(environment, f.name) for f in fields(Environment) if f.init}
    given |= {"parameters": tuple(environment.parameters), "shortcut": "", "terms": None}
    given["formula"] = _own_formula(environment.formula, source.text)
    names = overridden(environment)
    functions = Functions(source) if names else None
    if functions:
        given |= {name: partial(functions.call, name) for name in names}
        given["warnings"] = partial(_warnings, functions, given["warnings"])
    return OwnEnvironment(**given, source=source, functions=functions)


def _own_formula(formula: str, text: str) -> str:
    """Return a file's formula; "" if it is that of a template or of the library, whose law is different."""
    begun = [path.read_text(encoding="utf-8") for path in resources.path("templates").glob("*.py")]
    theirs = [other for other in begun if f'formula="{formula}"' in other]
    theirs += [
        inspect.getsource(sys.modules[e.force.function.__module__])
        for e in built_in().values()
        if e.formula == formula
    ]
    law = _code(text)
    return formula if not theirs or any(_code(other) == law for other in theirs) else ""


def _code(text: str) -> list[str]:
    """Return what a file's law consists of: its statements without imports, words and ENVIRONMENT."""
    words = ast.Import, ast.ImportFrom, ast.Expr
    return [
        ast.dump(node)
        for node in ast.parse(text).body
        if not isinstance(node, words)
        and not (isinstance(node, ast.Assign) and "Environment(" in ast.unparse(node))
    ]


def switched_off(environment: Environment) -> list[str]:
    """Return the line that says which function of a person's file was switched off, if one was."""
    functions = environment.functions if isinstance(environment, OwnEnvironment) else None
    return [functions.off] if functions and functions.off else []


def _warnings(
    functions: Functions, theirs: Callable, values: Values, conditions: Conditions
) -> tuple[str, ...]:
    """Return a person's own warnings, and which function was switched off."""
    found = theirs(values, conditions)
    return (*found, functions.off) if functions.off else tuple(found)

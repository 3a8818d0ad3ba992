"""A user's environment: its law is always compiled, and its other functions run in another process.

Compiled loops and Python can call the compiled law; a call from Python needs no further compilation.
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

# result of ``call_law`` if every call returned a force
NO_FAULT = -1
_DT = 1e-3
CURVE_SECONDS = 0.5
"""Maximum processor time in s for computing a curve, because the window waits for the curve."""


@compiled
def call_law(address, p, s, x, v, dt, fault, force):
    """Call a law at every x (n,) in m and v (n,) in m/s; write its forces in N to ``force`` (n,).

    Stop at the first call that fails, and return its index; return NO_FAULT if no call fails. ``fault`` has
    FAULT_WORDS words; the first word is the fault code, 0 without a fault.
    """
    for i in range(len(x)):
        force[i] = native.call(address, p, s, x[i], v[i], dt, fault)
        if fault[0] != 0:
            return i
    return NO_FAULT


def law_memory(law: CompiledLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return a law's initial state, padded to at least one value, and its fault words."""
    return np.append(law.initial_state, 0.0), np.zeros(FAULT_WORDS, dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class OwnEnvironment(Environment):
    """An environment that was read from a user's file, with the content of the file."""

    source: Source
    functions: Functions | None = None

    def curve(self, values: Values, position: np.ndarray, velocity: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the compiled law's force (n,) in N in its initial state.

        The force is NaN at a fault. If the computation takes longer than CURVE_SECONDS, it is also NaN at the
        remaining points.
        """
        law = self.force.compiled()
        p = np.array([values[q.key] for q in self.parameters] + [0.0])
        state, fault = law_memory(law)
        start = state.copy()
        if native.INTERPRETED:
            call = partial(native.call, law.address, p, state)
            given: Any = fault
        else:
            call = partial(native.Function(law.address), p.ctypes.data, state.ctypes.data)
            given = fault.ctypes.data
        points = np.broadcast_arrays(position, velocity)
        forces = np.full(points[0].shape, math.nan)
        end = time.thread_time() + CURVE_SECONDS
        for i, (x, v) in enumerate(zip(*(a.tolist() for a in points), strict=True)):
            if time.thread_time() > end:
                break
            state[:], fault[0] = start, 0
            force = call(x, v, _DT, given)
            forces[i] = math.nan if fault[0] else force
        return forces


@cache
def built_in() -> Mapping[str, Environment]:
    """Return the studio's environments by key, without those of other packages."""
    here = environments.__name__ + "."
    return {k: e for k, e in environments.discover().items() if e.force.function.__module__.startswith(here)}


def taken_keys() -> set[str]:
    """Return the keys of the studio's environments from their file names, without loading the files."""
    return {module.name for module in pkgutil.iter_modules(environments.__path__)}


def owned(environment: Environment, source: Source) -> OwnEnvironment:
    """Return an environment that is marked as a user's; it has no keyboard shortcut."""
    given = {f.name: getattr(environment, f.name) for f in fields(Environment) if f.init}
    given |= {"parameters": tuple(environment.parameters), "shortcut": "", "terms": None}
    if not _own_formula(environment.formula, source.text):
        given |= {"formula": "", "symbols": ""}
    names = overridden(environment)
    functions = Functions(source) if names else None
    if functions:
        given |= {name: partial(functions.call, name) for name in names}
        given["warnings"] = partial(_warnings, functions, given["warnings"])
    return OwnEnvironment(**given, source=source, functions=functions)


def _own_formula(formula: str, text: str) -> str:
    """Return a file's formula; "" if it was copied from a template or environment whose law is different."""
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
    """Return a file's statements without imports, docstrings and ENVIRONMENT, for a comparison."""
    ignored = ast.Import, ast.ImportFrom, ast.Expr
    return [
        ast.dump(node)
        for node in ast.parse(text).body
        if not isinstance(node, ignored)
        and not (isinstance(node, ast.Assign) and "Environment(" in ast.unparse(node))
    ]


def switched_off(environment: Environment) -> list[str]:
    """Return a list with one line that names the disabled function of a user's file, or an empty list."""
    functions = environment.functions if isinstance(environment, OwnEnvironment) else None
    return [functions.off] if functions and functions.off else []


def _warnings(
    functions: Functions, theirs: Callable, values: Values, conditions: Conditions
) -> tuple[str, ...]:
    """Return the warnings of a user's environment, and one that names a disabled function."""
    found = theirs(values, conditions)
    return (*found, functions.off) if functions.off else tuple(found)

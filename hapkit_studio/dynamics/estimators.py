"""Velocity from sampled positions: one entry a method, designed in Python, stepped in compiled code.

To add a method: a `_design` that fills 8 coefficients, a code and its branch in ``step``, an entry below.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Parameter, resolve

MEMORY = 48
COEFFICIENTS = 8

_DIFFERENCE, _IIR = 0, 1
_POSITION, _VELOCITY = 0, 1

Spec = str | tuple[str, dict[str, float]]


@dataclass(frozen=True)
class Estimator:
    """One method.

    ``design(rate, quantum, **options)`` returns its coefficients, float64[8]; ``response(coefs, period, z)``
    its transfer function from position to velocity at complex z, None where the method is not linear.
    """

    key: str
    label: str
    code: int
    parameters: tuple[Parameter, ...]
    design: Callable[..., np.ndarray]
    response: Callable[[np.ndarray, float, np.ndarray], np.ndarray] | None = None


def _design_difference(rate: float, quantum: float) -> np.ndarray:
    return np.zeros(COEFFICIENTS)


def _difference_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return (z - 1.0) / (period * z)


def _design_iir(rate: float, quantum: float, cutoff: float) -> np.ndarray:
    """alpha = 1 - exp(-2 pi f_c T), the exact discrete pole of a first-order low-pass."""
    coefs = np.zeros(COEFFICIENTS)
    coefs[0] = -math.expm1(-2.0 * math.pi * cutoff / rate)
    return coefs


def _iir_response(coefs: np.ndarray, period: float, z: np.ndarray) -> np.ndarray:
    return coefs[0] * (z - 1.0) / (period * (z - (1.0 - coefs[0])))


ESTIMATORS: dict[str, Estimator] = {
    e.key: e
    for e in (
        Estimator(
            "difference", "Backward difference", _DIFFERENCE, (), _design_difference, _difference_response
        ),
        Estimator(
            "iir",
            "Low-pass filtered difference",
            _IIR,
            (
                Parameter(
                    "cutoff", "Cutoff", "Hz", 35.5, 1.0, 2000.0, "Corner of the first-order low-pass", "f_c"
                ),
            ),
            _design_iir,
            _iir_response,
        ),
    )
}


def parse(spec: Spec) -> tuple[Estimator, dict[str, float]]:
    """Return the method and its checked options for "iir" or ("iir", {"cutoff": 20.0}).

    Raise ParameterError for an unknown method or option, or an option out of range.
    """
    pair = (spec, {}) if isinstance(spec, str) else spec
    if not (isinstance(pair, tuple | list) and len(pair) == 2 and isinstance(pair[1], Mapping)):
        raise ParameterError(f"The velocity estimator is a name or (name, {{option: value}}), not {spec!r}.")
    key, options = pair
    estimator = ESTIMATORS.get(key) if isinstance(key, str) else None
    if estimator is None:
        raise ParameterError(f"The velocity estimator is one of {', '.join(ESTIMATORS)}, not {key!r}.")
    numbers = resolve(estimator.parameters, options, estimator.label)
    return estimator, {p.key: n for p, n in zip(estimator.parameters, numbers, strict=True)}


def design(spec: Spec, rate: float, quantum: float = 0.0) -> tuple[int, np.ndarray]:
    """Return (code, float64[8]) for ``step`` at `rate` Hz and a sensor of `quantum` m.

    Raise ParameterError as ``parse``, and for a rate that is no positive number.
    """
    if not isinstance(rate, int | float | np.number):
        raise ParameterError(f"The rate takes a number in Hz, not {rate!r}.")
    if not (math.isfinite(rate) and rate > 0.0):
        raise ParameterError(f"The rate must be more than 0 Hz, not {rate:g} Hz.")
    estimator, options = parse(spec)
    return estimator.code, estimator.design(rate, quantum, **options)


@compiled
def reset(memory, position):
    """Start as if the handle had rested at `position`."""
    memory[:] = 0.0
    memory[_POSITION] = position


@compiled
def resume(memory, position, velocity):
    """Start as if the handle had come to `position` at `velocity`: a change of method makes no jump."""
    reset(memory, position)
    memory[_VELOCITY] = velocity


@compiled
def step(code, coefs, memory, position, period):
    """Take one measured position, `period` s after the last; return the velocity estimate in m/s."""
    velocity = (position - memory[_POSITION]) / period
    memory[_POSITION] = position
    if code == _IIR:
        velocity = memory[_VELOCITY] + coefs[0] * (velocity - memory[_VELOCITY])
    memory[_VELOCITY] = velocity
    return velocity


@compiled
def _run(code, coefs, memory, position, period, velocity):
    reset(memory, position[0])
    for k in range(position.size):
        velocity[k] = step(code, coefs, memory, position[k], period)


def estimate_velocity(
    position: np.ndarray, rate: float, estimator: Spec = "difference", quantum: float = 20.7e-6
) -> np.ndarray:
    """Return the velocity (n,) in m/s of positions (n,) in m sampled at `rate` Hz, its first value 0.

    `quantum` is the resolution the positions were measured with; they are not rounded again.
    """
    try:
        samples = np.ascontiguousarray(position, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("The positions must be numbers of m; they are not.") from None
    if samples.ndim != 1:
        raise ParameterError(f"The positions must be one row of numbers, not of shape {samples.shape}.")
    code, coefs = design(estimator, rate, quantum)
    velocity = np.zeros(samples.size)
    if samples.size:
        _run(code, coefs, np.zeros(MEMORY), samples, 1.0 / rate, velocity)
    return velocity

"""Velocity from sampled positions: one entry a method, designed in Python, stepped in compiled code.

To add one: its coefficients in ``filter_design``, a code and a branch in ``filters.step``, an entry here.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hapkit_studio.dynamics import filter_design, filters
from hapkit_studio.dynamics.filters import COEFFICIENTS, MEMORY, reset, resume, step
from hapkit_studio.dynamics.jit import compiled
from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Parameter, check_number, resolve

__all__ = ["COEFFICIENTS", "ESTIMATORS", "MEMORY", "Estimator", "Spec", "design", "estimate_velocity"]
__all__ += ["parse", "reset", "resume", "step"]

Spec = str | tuple[str, dict[str, float]]

# What a person's loop starts with: the cheapest whose error stays small in every motion (``accuracy``).
USUAL = "kalman"


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


def _cutoff(default: float, help: str) -> Parameter:
    return Parameter("cutoff", "Cutoff", "Hz", default, 1.0, 2000.0, help, "f_c")


_METHODS = (
    Estimator(
        "difference",
        "Backward difference",
        filters.DIFFERENCE,
        (),
        filter_design.difference,
        filter_design.difference_response,
    ),
    Estimator(
        "iir",
        "Low-pass filtered difference",
        filters.IIR,
        (_cutoff(35.5, "Corner of the first-order low-pass"),),
        filter_design.iir,
        filter_design.iir_response,
    ),
    Estimator(
        "butterworth",
        "Butterworth filtered difference",
        filters.BUTTERWORTH,
        (_cutoff(60.0, "Corner of the second-order low-pass, taken as 45 % of the rate at most"),),
        filter_design.butterworth,
        filter_design.butterworth_response,
    ),
    Estimator(
        "foaw",
        "First-order adaptive windowing",
        filters.FOAW,
        (
            Parameter(
                "window",
                "Window",
                "",
                filters.LONGEST,
                2.0,
                filters.LONGEST,
                "Periods in the longest line",
                "N",
            ),
            Parameter(
                "noise", "Noise", "counts", 0.5, 0.1, 5.0, "How far a sample may lie off its line", "d"
            ),
        ),
        filter_design.foaw,
    ),
    Estimator(
        "kalman",
        "Steady Kalman filter",
        filters.KALMAN,
        (
            Parameter(
                "q", "Agility", "m²/s³", 1e-2, 1e-3, 1.0, "Density of the acceleration that it expects", "q"
            ),
        ),
        filter_design.kalman,
        filter_design.kalman_response,
    ),
)
ESTIMATORS: dict[str, Estimator] = {method.key: method for method in _METHODS}


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

    Raise ParameterError as ``parse``, for a rate that is no positive number and a quantum below 0.
    """
    check_number(rate, "rate", "Hz", above=True)
    check_number(quantum, "quantum", "m")
    estimator, options = parse(spec)
    return estimator.code, estimator.design(rate, quantum, **options)


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

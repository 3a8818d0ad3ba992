"""Validation of arguments: single numbers, delays, and rows of numbers."""

from collections.abc import Callable, Sequence

import numpy as np

from hapkit_studio.errors import ParameterError
from hapkit_studio.parameters import Parameter

# largest valid argument: larger than any value of a device, and without overflow in computations
MOST = 1e9
STIFFNESS = Parameter("stiffness", "The stiffness", "N/m", 0.0, 0.0, MOST)
DAMPING = Parameter("damping", "The virtual damping", "N·s/m", 0.0, 0.0, MOST)


def checked_row(values: Sequence[float] | np.ndarray | float, what: Parameter) -> np.ndarray:
    """Return numbers as one row (n,); raise ParameterError if a number is outside the limits of ``what``."""
    try:
        found = np.atleast_1d(np.asarray(values))
    except ValueError:
        found = np.empty((0, 0))
    if found.ndim != 1 or (found.size and found.dtype.kind not in "iuf"):
        raise ParameterError(f"{what.label} must be one row of numbers in {what.unit}, not {_shown(values)}.")
    bad = found[~((found >= what.low) & (found <= what.high))]
    if bad.size:
        what.check(bad[0])
    return found.astype(float)


def whole_number(value: object, name: str, least: int) -> int:
    """Return ``value`` as an integer; raise ParameterError if it is not an integer of at least ``least``."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ParameterError(f"{name} must be a whole number, {least} or more, not {_shown(value)}.")
    return int(value)


def _shown(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "…"


def bisected(holds: Callable[[float], bool], low: float, high: float, halvings: int) -> tuple[float, float]:
    """Bisect a condition that is true at ``low`` and false at ``high``; return the final interval."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return float(low), float(high)

"""Round ends for the axes of a map of damping and stiffness; loads at once, the window starts with it."""

import math
from collections.abc import Callable

import numpy as np

_ROUND = (1, 1.5, 2, 3, 4, 5, 8, 10)
WIDTHS = (1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_SHARE = 0.7
# The boundary leaves through the upper edge within this share of the width.
_LEAVES = 0.6
_LOOKS = 31
# The height as a multiple of the limit at the dot; and at most, to show a boundary's highest point.
_OVER, _WHOLE = 1.5, 2.2


def nice_top(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 4, 5, 8 × 10ⁿ at or above a value."""
    if value <= 0.0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in _ROUND if m * power >= value * (1 - 1e-9))


def nice_width(damping: float, least: float = WIDTHS[0]) -> float:
    """Return a round width in N·s/m, at least so much, in which a damping stands clear of the right edge."""
    return next((w for w in WIDTHS if w >= least and damping <= _SHARE * w), nice_top(damping / _SHARE))


def height(stiffness: float, limit: float, highest: float) -> float:
    """Return a round height in N/m: room above dot and limit, the whole boundary if that is low."""
    limit = limit if math.isfinite(limit) else 0.0
    around = max(_OVER * limit, 1.4 * stiffness, 1.0)
    whole = 1.1 * highest
    seen = whole if 0.0 < whole <= max(_WHOLE * limit, around) else around
    return nice_top(max(seen, 1.1 * stiffness, 1.0))


def round_axes(
    boundary: Callable[[np.ndarray], np.ndarray], stiffness: float, damping: float, limit: float
) -> tuple[float, float]:
    """Return a round width in N·s/m and height in N/m around a dot and the limit at its damping, N/m.

    boundary gives the limits (n,) at dampings (n,): the narrowest width is taken in which it is seen to turn
    down, or to leave through the upper edge.
    """
    wide = nice_width(damping)
    top = height(stiffness, limit, math.inf)
    for wide in (w for w in WIDTHS if w >= nice_width(damping)):
        across = np.linspace(0.0, wide, _LOOKS)
        limits = boundary(across)
        top = height(stiffness, limit, float(limits.max()))
        leaves = (limits > top) & (across <= _LEAVES * wide)
        if leaves.any() or int(limits.argmax()) < _LOOKS - 1:
            break
    return wide, top

"""Round ends for the axes of the map of damping and stiffness."""

import math

_ROUND = (1, 1.5, 2, 3, 4, 5, 8, 10)
WIDTHS = (4.0, 8.0, 12.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_SHARE = 0.7


def nice_top(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 4, 5, 8 × 10ⁿ at or above a value."""
    if value <= 0.0 or not math.isfinite(value):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in _ROUND if m * power >= value * (1 - 1e-9))


def nice_width(damping: float, least: float = WIDTHS[0], share: float = _SHARE) -> float:
    """Return a round width in N·s/m, at least so much, of which a damping takes no more than a share."""
    wide = (w for w in WIDTHS if w >= least and damping <= share * w)
    return next(wide, nice_top(damping / share))


def height(stiffness: float, limit: float, highest: float) -> float:
    """Return a round height in N/m: room above dot and limit, the whole boundary if that is low."""
    limit = limit if math.isfinite(limit) else 0.0
    around = max(2.2 * limit, 1.4 * stiffness, 1.0)
    whole = 1.1 * highest if math.isfinite(highest) and highest > 0.0 else around
    return nice_top(max(min(around, whole), 1.1 * stiffness, 1.0))

"""Where a name fits into a chart's region, clear of its borders and of what else is written there."""

from collections.abc import Sequence

import numpy as np

Box = tuple[float, float, float, float]

_TRIES = 41
_LEVELS = 7
_STEPS = 60
# Places across, so that even a short word has some under it.
_FINE = 121
# Height that a place in the middle is worth, a share of the frame for one of the way to the side.
_OFF = 0.2


def room(
    low: np.ndarray, high: np.ndarray, size: tuple[float, float], taken: Sequence[Box] = ()
) -> Box | None:
    """Return a roomy box (left, bottom, right, top) of a size between two curves; None without room.

    Everything is a share of the frame: low and high are (n,) heights at n even places across, size is
    (width, height), taken are boxes to stay clear of.
    """
    places = np.linspace(0.0, 1.0, max(len(low), _FINE))
    low, high = (np.interp(places, np.linspace(0.0, 1.0, len(curve)), curve) for curve in (low, high))
    best, most = None, -np.inf
    for left in np.linspace(0.0, 1.0 - size[0], _TRIES):
        over = (places >= left - 0.02) & (places <= left + size[0] + 0.02)
        floor, ceiling = float(low[over].max()), float(high[over].min())
        gap = ceiling - floor - size[1]
        liked = gap - _OFF * abs(left + 0.5 * size[0] - 0.5)
        if gap <= 0.0 or liked <= most:
            continue
        for share in _from_the_middle():
            bottom = floor + share * gap
            box = (float(left), bottom, float(left) + size[0], bottom + size[1])
            if not any(_meet(box, other) for other in taken):
                best, most = box, liked
                break
    return best


def crosses(start: tuple[float, float], end: tuple[float, float], box: Box) -> bool:
    """Return whether a straight line goes through a box; all in shares of the frame."""
    parts = np.linspace(0.0, 1.0, _STEPS)
    x, y = (a + parts * (b - a) for a, b in zip(start, end, strict=True))
    return bool(((x > box[0]) & (x < box[2]) & (y > box[1]) & (y < box[3])).any())


def _from_the_middle() -> list[float]:
    shares = np.linspace(0.1, 0.9, _LEVELS)
    return sorted(shares.tolist(), key=lambda share: abs(share - 0.5))


def _meet(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]

"""Where ticks stand, and how an axis widens: at once, and never by itself back."""

import math

import numpy as np

from hapkit_studio.gui.theme import number

_EDGE, _MARGIN = 0.04, 0.12  # of the range: so near is on the frame; what is left free beyond the data
_LOOSE = 1.15  # a fitted range, as a multiple of the data's


def step(low: float, high: float, most: int = 5, gaps: float = math.inf) -> float:
    """Return the least step of 1, 2, 5 × 10ⁿ that puts at most so many ticks into [low, high].

    gaps: how many steps may lie side by side there, so that labels keep their distance.
    """
    least = max(high - low, 1e-12) / gaps
    raw = max(max(high - low, 1e-12) / max(most, 1), least)
    power = 10.0 ** math.floor(math.log10(raw))
    sizes = [factor * power for factor in (1.0, 2.0, 5.0, 10.0, 20.0) if factor * power >= least]
    return next((size for size in sizes if len(_within(low, high, size)) <= most), sizes[-1])


def _within(low: float, high: float, size: float) -> np.ndarray:
    slack = 1e-9 * size
    return np.arange(math.ceil((low - slack) / size), math.floor((high + slack) / size) + 1)


def ticks(low: float, high: float, most: int = 5, gaps: float = math.inf) -> list[float]:
    """Return the tick values inside [low, high]; most and gaps as in ``step``."""
    size = step(low, high, most, gaps)
    return [float(k * size) for k in _within(low, high, size)]


def labels(values: list[float]) -> list[str]:
    """Write tick values with as many decimals as their distance needs."""
    size = min(np.diff(values)) if len(values) > 1 else abs(values[0]) if values else 1.0
    decimals = max(0, -math.floor(math.log10(size) + 1e-9)) if size > 0 else 0
    return [number(value, decimals) for value in values]


def widened(shown: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Return the range that shows [low, high] too, with a margin wherever it had to grow.

    It grows before a line lies on the frame.
    """
    if not (math.isfinite(low) and math.isfinite(high)):
        return shown
    edge = _EDGE * (shown[1] - shown[0])
    margin = _MARGIN * (max(high, shown[1]) - min(low, shown[0]))
    bottom = low - margin if low < shown[0] + edge else shown[0]
    top = high + margin if high > shown[1] - edge else shown[1]
    return bottom, top


def fitted(low: float, high: float, least: float) -> tuple[float, float]:
    """Return the range that shows [low, high] with a margin, at least so much to each side of its middle."""
    middle, half = (low + high) / 2, max((high - low) / 2 * _LOOSE, least)
    return middle - half, middle + half

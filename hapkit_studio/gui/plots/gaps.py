"""Stretches without data: the device was gone, or its sensor silent. Hatched and named, never bridged."""

import math

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QBrush, QFontMetrics, QPainter

from hapkit_studio.gui.theme import number, theme

LEAST = 0.25
"""s without data from which on it is marked."""
_BESIDE = 6


def gaps(x: np.ndarray, before: float = math.nan) -> list[tuple[float, float]]:
    """Return the stretches (start, stop) in s, long enough to be a device's, around the NaN in times.

    before: when the last sample came that lies left of them.
    """
    x = x[1:] if len(x) and math.isnan(x[0]) else x
    lost = np.flatnonzero(np.isnan(x))
    lost = lost[(lost > 0) & (lost < len(x) - 1)]
    starts, stops = [before, *x[lost - 1]], [*x[:1], *x[lost + 1]]
    pairs = zip(starts, stops, strict=False)
    return [(float(a), float(b)) for a, b in pairs if b - a > LEAST]


def hatch(painter: QPainter, box: QRectF, seen: list[tuple[float, float, float]]) -> None:
    """Hatch gaps given as left and right in pixels and length in s."""
    brush = QBrush(theme.color("line"), Qt.BrushStyle.BDiagPattern)
    for left, right, _ in seen:
        painter.fillRect(QRectF(left, box.top(), right - left, box.height()), brush)


def lengths(seen: list[tuple[float, float, float]], metrics: QFontMetrics) -> list[tuple[float, str]]:
    """Return where to say how long each gap was, in pixels, and what; nothing where there is no room."""
    said = [(left + _BESIDE, right, f"No data for {number(s, 1)} s") for left, right, s in seen]
    return [(x, words) for x, right, words in said if x + metrics.horizontalAdvance(words) + _BESIDE < right]

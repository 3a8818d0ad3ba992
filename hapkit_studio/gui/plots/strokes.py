"""Lines of many points, painted fast: as loose segments, which Qt strokes 20 times faster than a path."""

import numpy as np
from pyqtgraph.Qt import internals
from PySide6.QtCore import QLineF, QPointF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from hapkit_studio.gui.theme import theme

ON, PERIOD = 5.0, 8.5  # px
_NOISE = 12.0  # a line this many times longer than wide is noise


def pen(color: QColor, width: float, dash: list[float] | None = None, flat: bool = False) -> QPen:
    """Return a pen that Qt strokes fast; square ends close the joints between segments, dashes are flat."""
    cap = Qt.PenCapStyle.FlatCap if dash or flat else Qt.PenCapStyle.SquareCap
    result = QPen(color, width, Qt.PenStyle.SolidLine, cap)
    if dash:
        result.setDashPattern(dash)
    return result


def segments(painter: QPainter, ends: np.ndarray) -> None:
    """Draw loose segments (n, 4): x1, y1, x2, y2 in pixels, with the painter's pen."""
    if len(ends):
        store = internals.PrimitiveArray(QLineF, 4)
        store.resize(len(ends))
        store.ndarray()[:] = ends
        painter.drawLines(*store.drawargs())


def trace(painter: QPainter, x: np.ndarray, y: np.ndarray) -> None:
    """Draw a line with the painter's pen, smooth unless it is noise, where that shows nothing."""
    ends = joined(x, y)
    noisy = np.abs(ends[:, 3] - ends[:, 1]).sum() > _NOISE * max(np.nanmax(x) - np.nanmin(x), 1.0)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, not noisy)
    segments(painter, ends)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)


def joined(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the segments (n, 4) between neighbours, none over a NaN."""
    ends = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
    return ends[np.isfinite(ends).all(axis=1)]


def dashed(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the dashes (n, 4) along a line, 5 on and 3.5 off; each run after a NaN starts with a dash."""
    good = np.isfinite(x) & np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.view(np.int8), [0]])))
    runs = [_dashes(x[a:b], y[a:b]) for a, b in edges.reshape(-1, 2) if b - a > 1]
    return np.concatenate(runs) if runs else np.empty((0, 4))


def _dashes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
    if length[-1] > _NOISE * max(np.ptp(x), 1.0):  # dashes along noise would be a haze
        return joined(x, y)
    start = np.arange(0.0, length[-1], PERIOD)
    stop = np.minimum(start + ON, length[-1])
    return np.column_stack([np.interp(s, length, c) for s in (start, stop) for c in (x, y)])


def mark(painter: QPainter, at: QPointF, token: str, radius: float = 4.0) -> None:
    """Draw a dot in a token's colour with a rim of the card's."""
    painter.setPen(QPen(theme.color("surface"), 1.5))
    painter.setBrush(theme.color(token))
    painter.drawEllipse(at, radius, radius)
    painter.setBrush(Qt.BrushStyle.NoBrush)

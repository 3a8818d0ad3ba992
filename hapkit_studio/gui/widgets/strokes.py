"""Fast painting of long lines; Qt draws separate segments 20 times faster than a path."""

import numpy as np
from pyqtgraph.Qt import internals
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from hapkit_studio.gui.widgets.theme import theme

ON, PERIOD = 5.0, 8.5  # px: length of a dash, and distance from one dash to the next
_LEAST_STEP = 0.8  # px: points closer than this to the previous point are omitted
_FINE = 1.4  # square joints are visible at this device pixel ratio and above
# px²: a turn is visible if the product of its rise and fall exceeds this; a line is noise if the fraction of
# such turns exceeds the second number
_TREMOR, _NOISY = 0.25, 0.2
_LONG = 5.0  # px: noise with a larger mean vertical step is painted without antialiasing
_DENSE = 2.5  # a patterned line is solid if its length exceeds this multiple of its horizontal extent
_ARROWS_APART = 12.0  # px: minimum distance between arrow heads
_HEAD = 8.0  # px: length of an arrow head
_HAZE = 40.0  # a dashed line is drawn solid if its length exceeds this multiple of its horizontal extent


def pen(color: QColor, width: float, dash: list[float] | None = None) -> QPen:
    """Return a pen with flat ends; dashes are in units of its width, and widths follow the theme's scale."""
    result = QPen(color, width * theme.scale, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
    if dash:
        result.setDashPattern(dash)
    return result


def level(painter: QPainter, box: QRectF, y: float, token: str, dash: list[float]) -> None:
    """Draw a horizontal dashed line across a frame in a token's colour."""
    painter.setPen(pen(theme.color(token), 1.6, dash))
    painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))


def segments(painter: QPainter, ends: np.ndarray) -> None:
    """Draw separate segments (n, 4), given as x1, y1, x2, y2 in pixels, with the painter's pen."""
    if len(ends):
        store = internals.PrimitiveArray(QLineF, 4)
        store.resize(len(ends))
        store.ndarray()[:] = ends
        painter.drawLines(*store.drawargs())


def trace(painter: QPainter, x: np.ndarray, y: np.ndarray, color: QColor, width: float = 2.0) -> None:
    """Draw a line, without antialiasing if it is dense noise; joints are round on high-resolution screens."""
    rise = np.diff(y)
    noise = np.count_nonzero(rise[1:] * rise[:-1] < -_TREMOR) > _NOISY * len(rise)
    haze = noise and np.nansum(np.abs(rise)) > _LONG * len(rise)
    coarse = noise or painter.device().devicePixelRatio() < _FINE
    cap = Qt.PenCapStyle.SquareCap if coarse else Qt.PenCapStyle.RoundCap
    painter.setPen(QPen(color, width * theme.scale, Qt.PenStyle.SolidLine, cap))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, not haze)
    segments(painter, joined(x, y) if noise else joined(*thinned(x, y)))
    painter.setRenderHint(QPainter.RenderHint.Antialiasing, True)


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a line with at most one point per _LEAST_STEP px along the line, and its last point."""
    steps = np.nan_to_num(np.hypot(np.diff(x), np.diff(y)), nan=10.0 * _LEAST_STEP)
    whole = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) / _LEAST_STEP)
    kept = np.concatenate([[True], np.diff(whole) > 0])
    kept[-1:] = True
    return x[kept], y[kept]


def joined(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the segments (n, 4) between neighbouring points; there are gaps at NaN."""
    ends = np.column_stack([x[:-1], y[:-1], x[1:], y[1:]])
    return ends[np.isfinite(ends).all(axis=1)]


def patterned(x: np.ndarray, y: np.ndarray, dash: tuple[float, ...]) -> np.ndarray:
    """Return the dashes (n, 4) along a line; ``dash`` contains the lengths in pixels of dash and gap.

    A line whose samples are dense is drawn without gaps.
    """
    along = np.nansum(np.hypot(np.diff(x), np.diff(y)))
    if len(x) > 1 and along > _DENSE * max(np.nanmax(x) - np.nanmin(x), 1.0):
        return joined(x, y)
    begins = np.cumsum((0.0, *dash))
    parts = [dashed(x, y, on, begins[-1], begin) for on, begin in zip(dash[::2], begins[:-1:2], strict=True)]
    return np.concatenate(parts)


def dashed(
    x: np.ndarray, y: np.ndarray, on: float = ON, period: float = PERIOD, lead: float = 0.0
) -> np.ndarray:
    """Return the dashes (n, 4) along a line; by default a dash has 5 px and a gap has 3.5 px.

    The first dash starts after ``lead`` px. The pattern restarts after each NaN.
    """
    good = np.isfinite(x) & np.isfinite(y)
    edges = np.flatnonzero(np.diff(good.astype(np.int8), prepend=0, append=0)).reshape(-1, 2)
    edges = edges[edges[:, 1] - edges[:, 0] > 1]
    along = np.concatenate([[0.0], np.nancumsum(np.hypot(np.diff(x), np.diff(y)))])
    if not len(edges) or along[-1] > _HAZE * max(np.nanmax(x) - np.nanmin(x), 1.0):
        return joined(x, y)
    lengths = along[edges[:, 1] - 1] - along[edges[:, 0]]
    # each part between two NaN starts at a multiple of the period in the concatenated line
    ends = np.cumsum(np.ceil(lengths / period) * period)
    begins = np.concatenate([[0.0], ends[:-1]])
    start = np.arange(0.0, ends[-1] - 0.5 * period, period)
    run = np.searchsorted(ends, start, side="right")
    full = begins[run] + lengths[run]
    start = np.minimum(start + lead, full)
    stop = np.minimum(start + on, full)
    which = np.repeat(np.arange(len(edges)), edges[:, 1] - edges[:, 0])
    points = np.concatenate([np.arange(a, b) for a, b in edges])
    place = along[points] - along[edges[which, 0]] + begins[which]
    return np.column_stack([np.interp(s, place, c[points]) for s in (start, stop) for c in (x, y)])


def arrows(painter: QPainter, box: QRectF, x: np.ndarray, y: np.ndarray, color: QColor) -> None:
    """Draw arrow heads where a line (n,) in px leaves a frame, with a minimum distance between them."""
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(color)
    for edge, beyond, inwards in ((box.top(), y < box.top(), 1.0), (box.bottom(), y > box.bottom(), -1.0)):
        last = -np.inf
        for column in x[beyond & ~np.concatenate([[False], beyond[:-1]])].tolist():
            if column - last >= _ARROWS_APART:
                last = column
                foot = edge + inwards * _HEAD
                corners = (column, edge), (column - 0.6 * _HEAD, foot), (column + 0.6 * _HEAD, foot)
                painter.drawPolygon([QPointF(*corner) for corner in corners])
    painter.setBrush(Qt.BrushStyle.NoBrush)


def mark(painter: QPainter, at: QPointF, token: str, radius: float = 4.0, shape: str = "dot") -> None:
    """Draw a dot or a diamond in a token's colour; its rim has the colour of the card."""
    radius *= theme.scale
    painter.setPen(QPen(theme.color("surface"), 1.5))
    painter.setBrush(theme.color(token))
    if shape == "diamond":
        r = 1.25 * radius
        corners = [QPointF(0.0, -r), QPointF(r, 0.0), QPointF(0.0, r), QPointF(-r, 0.0)]
        painter.drawPolygon([at + corner for corner in corners])
    else:
        painter.drawEllipse(at, radius, radius)
    painter.setBrush(Qt.BrushStyle.NoBrush)

"""One trace over time; an oscillation too fast to be seen is drawn as the area that it fills."""

import math

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPen, QPolygonF

from hapkit_studio.gui.plots import strokes
from hapkit_studio.gui.tabs import marks
from hapkit_studio.gui.tabs.chart import Chart, power
from hapkit_studio.gui.theme import theme

_PALE = 0.35
_SHORT = 0.5  # s: shorter traces are drawn over ms
_ROOM = 1.1
_SMALL = 0.01  # numbers below this would need labels too long for the axis
_COLUMN = 3.0  # px
_DENSE, _FEW = 1.5, 50  # turns a column from which on they fill an area; points shown one by one
_FILL = 0.22


class TraceChart(Chart):
    """Green where it holds, red where it fails, paler where it is old; across in s or ms."""

    def __init__(self) -> None:
        super().__init__("", "", unit="s")
        self.ground.setContentsMargins(0, 16, 30, 2)
        self.left.setWidth(46)
        self.setMinimumSize(180, 64)
        self._x, self._y = np.zeros(0), np.zeros(0)
        self._name, self._token, self._old = "", "ok", False
        self.over.append(self._paint_trace)
        self.marks.append(self._write_name)

    def show_trace(self, time: np.ndarray, y: np.ndarray, name: str, holds: bool, old: bool) -> None:
        """Show a trace (n,) over time (n,) in s; name says what runs up."""
        good = np.isfinite(time) & np.isfinite(y)
        time, y = np.asarray(time, float)[good], np.asarray(y, float)[good]
        self._token, self._old = "ok" if holds else "danger", old
        factor, power = scaled(y)
        y, self._name = factor * y, f"{name} × {power}" if power else name
        short = len(time) > 0 and time[-1] < _SHORT
        self.bottom.unit = "ms" if short else "s"
        self._x, self._y = (1e3 * time if short else time), y
        if len(time):
            low, high = min(float(y.min()), 0.0), max(float(y.max()), 0.0)
            middle, half = 0.5 * (low + high), max(0.5 * _ROOM * (high - low), 1e-12)
            self.set_range((0.0, max(float(self._x[-1]), 1e-9)), (middle - half, middle + half))
        self.redraw()

    def clear_trace(self) -> None:
        """Show an empty frame."""
        self.show_trace(np.zeros(0), np.zeros(0), "", holds=True, old=False)

    def _paint_trace(self, painter: QPainter, _chart: Chart) -> None:
        if len(self._x) < 2:
            return
        painter.setOpacity(_PALE if self._old else 1.0)
        x, y = self.to_pixels(self._x, self._y)
        if dense(x, y):
            self._paint_area(painter, *envelope(x, y))
        else:
            strokes.trace(painter, x, y, theme.color(self._token), 1.8)
        if len(x) < _FEW:
            for place in zip(x.tolist(), y.tolist(), strict=True):
                marks.marker(painter, "circle", QPointF(*place), self._token, 3.2)

    def _write_name(self, painter: QPainter, _chart: Chart) -> None:
        """Say what runs up, above the frame, where nothing is drawn."""
        at = QPointF(self.frame().left(), self.frame().top() - 5)
        marks.write(painter, at, self._name, "axis", "hint")

    def _paint_area(self, painter: QPainter, x: np.ndarray, least: np.ndarray, most: np.ndarray) -> None:
        upper = [QPointF(*p) for p in zip(x.tolist(), least.tolist(), strict=True)]
        lower = [QPointF(*p) for p in zip(x.tolist(), most.tolist(), strict=True)]
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(theme.color(self._token, _FILL))
        painter.drawPolygon(QPolygonF(upper + lower[::-1]))
        painter.setPen(QPen(theme.color(self._token), 1.8))
        for edge in (upper, lower):
            painter.drawPolyline(QPolygonF(edge))


def scaled(y: np.ndarray) -> tuple[float, str]:
    """Return what very small numbers are to be multiplied by to be readable, and its words: "10⁻⁶" or ""."""
    most = float(np.abs(y).max()) if len(y) else 0.0
    if not 0.0 < most < _SMALL:
        return 1.0, ""
    exponent = -3 * math.floor(math.log10(most) / 3.0)
    return 10.0**exponent, power(-exponent)


def envelope(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the middle of each column of pixels that holds points, the least and the greatest y in it."""
    column = np.floor((x - x[0]) / _COLUMN).astype(int)
    first = np.flatnonzero(np.diff(column, prepend=-1))
    middle = x[0] + (column[first] + 0.5) * _COLUMN
    return middle, np.minimum.reduceat(y, first), np.maximum.reduceat(y, first)


def dense(x: np.ndarray, y: np.ndarray) -> bool:
    """Say whether it turns round more often than there are columns of pixels to show it."""
    rise = np.diff(y)
    turns = np.count_nonzero(rise[1:] * rise[:-1] < 0.0)
    return bool(turns > _DENSE * max(x[-1] - x[0], _COLUMN) / _COLUMN)

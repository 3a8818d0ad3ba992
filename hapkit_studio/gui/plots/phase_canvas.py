"""Force over something: theory as a band, the last ten seconds over it, paler the older, a dot for now.

Each second is painted once, into its own layer, as its samples arrive; a frame only adds its few new ones.
"""

import math
from collections import deque

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QImage, QPainter, QPen, QPolygonF

from hapkit_studio.gui.history import CHANNELS, History, Window
from hapkit_studio.gui.plots import strokes
from hapkit_studio.gui.plots.canvas import Canvas
from hapkit_studio.gui.plots.declared import PhasePlot
from hapkit_studio.gui.plots.ticks import widened
from hapkit_studio.gui.theme import number, theme

SECONDS = 10
_GRID = 401
_AGES = (1.0, 1.0, 0.55, 0.55, 0.40, 0.40, 0.30, 0.30, 0.25, 0.25, 0.25)  # by whole seconds
_LEAST_STEP = 0.7  # px
_LEAST_FORCE = 0.5


class PhaseCanvas(Canvas):
    """Paints one PhasePlot of a history."""

    def __init__(self, plot: PhasePlot):
        super().__init__(True)
        self.max_force = math.inf
        self.paused = False
        self._history = History(seconds=1.0, rate=1.0)
        self._layers: deque[tuple[int, QImage]] = deque(maxlen=SECONDS + 1)
        self._drawn, self._key = 0, None
        self._theory: tuple[np.ndarray, np.ndarray] | None = None
        self._pointed: dict[str, float] | None = None
        self._tail = np.empty((2, 0))
        self.bottom.setHeight(38)
        self.set_plot(plot)

    def set_plot(self, plot: PhasePlot) -> None:
        """Show another plot."""
        self.plot_of = plot
        self.setAccessibleName(f"Force in N over {plot.label}")
        self.bottom.setLabel(plot.label)
        self.recolor()
        self._start_over()

    def recolor(self) -> None:
        """Take the theme's colours and fonts."""
        super().recolor()
        self.bottom.label.setFont(theme.font("tick"))
        self.bottom.label.setDefaultTextColor(theme.color("ink3"))

    def set_history(self, history: History) -> None:
        """Plot another history."""
        self._history = history
        self._start_over()

    # axes ---------------------------------------------------------------------------------------

    def theory_grid(self, plot: PhasePlot) -> np.ndarray:
        """Return where theory is computed, SI: three times the plot's reach."""
        return np.linspace(-3.0, 3.0, _GRID) * plot.reach / plot.scale

    def set_theory(self, x: np.ndarray, force: np.ndarray | None) -> None:
        """Take the law's force (n,) in N over x (n,), SI; None: no band."""
        self._theory = None if force is None else (x * self.plot_of.scale, np.asarray(force))
        self.viewport().update()

    def fit_theory(self) -> None:
        """Show the plot's reach, and of the theory what the motor can give."""
        reach, low, high = self.plot_of.reach, -_LEAST_FORCE, _LEAST_FORCE
        if self._theory is not None:
            x, force = self._theory
            force = force[np.abs(x) <= reach]
            low, high = min(low, float(force.min())), max(high, float(force.max()))
        most = 1.35 * self.max_force
        low, high = max(low, -most), min(high, most)
        margin = 0.12 * (high - low)
        self.view.setRange(xRange=(-reach, reach), yRange=(low - margin, high + margin), padding=0)

    def fit(self) -> None:
        """Narrow the axes to the last seconds."""
        x, y = self._points(self._recent())
        if x.size:
            ranges = []
            for values, least in ((x, self.plot_of.reach / 8), (y, 0.2)):
                low, high = float(np.nanmin(values)), float(np.nanmax(values))
                half = max((high - low) / 2 * 1.15, least)
                ranges.append(((low + high) / 2 - half, (low + high) / 2 + half))
            self.view.setRange(xRange=ranges[0], yRange=ranges[1], padding=0)

    def _recent(self) -> Window:
        return self._history.between(self._history.now - SECONDS, math.inf)

    def _points(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return window.y[self.plot_of.channel] * self.plot_of.scale, window.y["applied"]

    def _widen(self, x: np.ndarray, y: np.ndarray) -> None:
        across, down = self.view.viewRange()
        wanted_x = widened(tuple(across), float(np.nanmin(x)), float(np.nanmax(x)))
        wanted_y = widened(tuple(down), float(np.nanmin(y)), float(np.nanmax(y)))
        if list(wanted_x) != across or list(wanted_y) != down:
            self.view.setRange(xRange=wanted_x, yRange=wanted_y, padding=0)

    # layers -------------------------------------------------------------------------------------

    def refresh(self) -> None:
        """Add the samples that came since the last frame."""
        if not self.paused and not math.isnan(self._history.now):
            self._add_new()
        self.viewport().update()

    def point(self, time: float | None) -> None:
        """Mark the sample at a time in s; None: no mark."""
        self._pointed = None if time is None else self._history.at(time)

    def _start_over(self) -> None:
        self._key = None

    def _state(self) -> tuple:
        """Return what the layers depend on; when it changes they are painted anew."""
        (x0, x1), (y0, y1) = self.view.viewRange()
        return x0, x1, y0, y1, self.frame().getRect(), theme.name, self.devicePixelRatioF()

    def _add_new(self) -> None:
        if self._key is None or self._drawn > self._history.total:
            new = self._recent()
        else:
            new = self._history.since(self._drawn)
        if len(new.x):
            self._widen(*self._points(new))
        if self._key != self._state():
            self._key = self._state()
            self._layers.clear()
            self._tail = np.empty((2, 0))
            new = self._recent()
        self._drawn = self._history.total
        seconds = np.floor(np.fmax.accumulate(new.x)) if len(new.x) else new.x
        line = np.stack(self.to_pixels(*self._points(new)))
        for second in np.unique(seconds[np.isfinite(seconds)]).astype(int):
            self._paint_second(int(second), line[:, seconds == second])

    def _paint_second(self, second: int, points: np.ndarray) -> None:
        if not self._layers or self._layers[-1][0] != second:
            self._layers.append((second, self._blank()))
        line = np.concatenate([self._tail, points], axis=1)
        self._tail = line[:, -1:]
        painter = QPainter(self._layers[-1][1])
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(-self.frame().topLeft())
        painter.setPen(strokes.pen(theme.color("applied"), 2.0))
        strokes.segments(painter, strokes.joined(*_thinned(line)))
        painter.end()

    def _blank(self) -> QImage:
        box, ratio = self.frame(), self.devicePixelRatioF()
        size = (max(math.ceil(box.width() * ratio), 1), max(math.ceil(box.height() * ratio), 1))
        image = QImage(*size, QImage.Format.Format_ARGB32_Premultiplied)
        image.setDevicePixelRatio(ratio)
        image.fill(Qt.GlobalColor.transparent)
        return image

    # painting -----------------------------------------------------------------------------------

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint theory, limits, and the layers from old to new."""
        if self._theory is not None:
            self._band(painter)
        self._limits(painter, box)
        newest = self._layers[-1][0] if self._layers else 0
        for second, image in self._layers:
            age = newest - second
            if age < len(_AGES):
                painter.setOpacity(_AGES[age])
                painter.drawImage(box.topLeft(), image)

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dots for now and for the pointer's time."""
        if not math.isnan(self._history.now):
            self._dot(painter, {c: self._history.last(c) for c in CHANNELS}, 5.0)
        if self._pointed is not None:
            self._dot(painter, self._pointed, 3.5)

    def _band(self, painter: QPainter) -> None:
        x, y = self.to_pixels(*self._theory)  # type: ignore[misc]
        y = np.clip(y, -1e4, 1e4)
        line = QPolygonF([QPointF(a, b) for a, b in zip(x, y, strict=True)])
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            painter.setPen(QPen(theme.color(token), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
            painter.drawPolyline(line)

    def _limits(self, painter: QPainter, box: QRectF) -> None:
        if not math.isfinite(self.max_force):
            return
        for sign in (1, -1):
            y = float(self.to_pixels(0.0, sign * self.max_force)[1])
            painter.setPen(strokes.pen(theme.color("danger"), 1.6, [1.2, 2.6]))
            painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
            text = f"limit {number(sign * self.max_force, 1)} N"
            self.note(painter, box.left() + 6, y - 5, text, theme.color("danger"))

    def _dot(self, painter: QPainter, at: dict[str, float], radius: float) -> None:
        x, y = self.to_pixels(at[self.plot_of.channel] * self.plot_of.scale, at["applied"])
        strokes.mark_now(painter, float(x), float(y), theme.color("applied"), theme.color("surface"), radius)


def _thinned(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a line (2, n) without the points that lie closer than a step behind the last one kept."""
    steps = np.nan_to_num(np.hypot(*np.diff(line, axis=1)), nan=10.0 * _LEAST_STEP)
    whole = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) / _LEAST_STEP)
    kept = np.concatenate([np.diff(whole) > 0, [True]])
    kept[0] = True
    return line[0, kept], line[1, kept]

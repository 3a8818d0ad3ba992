"""Force over something: theory as a band, the last ten seconds over it, paler the older, a dot for now."""

import math

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPen, QPixmap, QPolygonF

from hapkit_studio.gui.history import History, Window
from hapkit_studio.gui.plots import strokes
from hapkit_studio.gui.plots.canvas import Canvas
from hapkit_studio.gui.plots.declared import PhasePlot
from hapkit_studio.gui.plots.layers import SECONDS, Layers
from hapkit_studio.gui.plots.ticks import widened
from hapkit_studio.gui.theme import number, theme

_GRID = 401
_LEAST_FORCE = 0.5
_FAR = 1e4  # px


class PhaseCanvas(Canvas):
    """Paints one PhasePlot of a history."""

    def __init__(self, plot: PhasePlot):
        super().__init__(True)
        self.max_force = math.inf
        self._live = self._history = History(seconds=1.0, rate=1.0)
        self._layers: Layers | None = None
        self._key: tuple | None = None
        self._drawn = 0
        self._begin = -math.inf
        self._under: QPixmap | None = None
        self._theory: tuple[np.ndarray, np.ndarray] | None = None
        self._pointed: dict[str, float] | None = None
        self._fitted = False
        self.bottom.setHeight(38)
        self.bottom.label.setCacheMode(self.bottom.cacheMode())
        self.set_plot(plot)

    def set_plot(self, plot: PhasePlot) -> None:
        """Show another plot."""
        self.plot_of = plot
        self.setAccessibleName(f"Force in N over {plot.label}")
        self.bottom.setLabel(plot.label)
        self.recolor()
        self._key = None

    def recolor(self) -> None:
        """Take the theme's colours and fonts."""
        super().recolor()
        self.bottom.label.setFont(theme.font("tick"))
        self.bottom.label.setDefaultTextColor(theme.color("ink3"))

    def set_history(self, history: History) -> None:
        """Plot another history."""
        self._live = self._history = history
        self._begin, self._key = -math.inf, None

    def begin_here(self) -> None:
        """Leave out what is older than now: it belongs to another environment."""
        self._begin, self._key = float(np.nan_to_num(self._live.now, nan=-math.inf)), None

    def set_paused(self, paused: bool) -> None:
        """Freeze what is shown; the live history goes on."""
        self._history = self._live.copy() if paused else self._live

    # axes ---------------------------------------------------------------------------------------

    def theory_grid(self, plot: PhasePlot) -> np.ndarray:
        """Return where theory is computed, SI: three times the plot's reach."""
        return np.linspace(-3.0, 3.0, _GRID) * plot.reach / plot.scale

    def set_theory(self, x: np.ndarray, force: np.ndarray | None, max_force: float) -> None:
        """Take the law's force in N over x (n,), SI, one row a branch (None: no band), and its limit in N."""
        self._theory = None if force is None else (x * self.plot_of.scale, np.asarray(force))
        self.max_force, self._under = max_force, None
        self.viewport().update()

    def fit_theory(self) -> None:
        """Show the plot's reach, and of the theory what the motor can give."""
        reach = self.plot_of.reach
        self.view.setRange(xRange=(-reach, reach), yRange=self._theory_range(), padding=0)
        self._fitted = False

    def widen_theory(self) -> None:
        """Make room for a changed theory at once, unless a person has fitted the axes to the data."""
        low, high = self._theory_range()
        bottom, top = self.view.viewRange()[1]
        if not self._fitted and (low < bottom or high > top):
            self.view.setYRange(min(low, bottom), max(high, top), padding=0)

    def _theory_range(self) -> tuple[float, float]:
        """Return the forces in N to show of the theory within the plot's reach, with a margin."""
        reach, low, high = self.plot_of.reach, -_LEAST_FORCE, _LEAST_FORCE
        if self._theory is not None:
            x, force = self._theory
            seen = force[:, np.abs(x) <= reach]
            seen = seen[np.isfinite(seen)]
            low, high = min(low, seen.min(initial=low)), max(high, seen.max(initial=high))
        most = 1.35 * self.max_force
        low, high = max(low, -most), min(high, most)
        margin = 0.12 * (high - low)
        return low - margin, high + margin

    def fit(self) -> None:
        """Narrow the axes to the last seconds."""
        x, y = self._points(self._recent())
        if not x.size:
            return
        ranges = []
        for values, least in ((x, self.plot_of.reach / 8), (y, 0.2)):
            low, high = float(np.nanmin(values)), float(np.nanmax(values))
            half = max((high - low) / 2 * 1.15, least)
            ranges.append(((low + high) / 2 - half, (low + high) / 2 + half))
        self.view.setRange(xRange=ranges[0], yRange=ranges[1], padding=0)
        self._fitted = True

    def _widen(self, x: np.ndarray, y: np.ndarray) -> None:
        across, up = self.view.viewRange()
        wanted_x = widened(tuple(across), float(np.nanmin(x)), float(np.nanmax(x)))
        wanted_y = widened(tuple(up), float(np.nanmin(y)), float(np.nanmax(y)))
        if list(wanted_x) != across or list(wanted_y) != up:
            self.view.setRange(xRange=wanted_x, yRange=wanted_y, padding=0)

    # data ---------------------------------------------------------------------------------------

    def _recent(self) -> Window:
        return self._history.between(max(self._history.now - SECONDS, self._begin), math.inf)

    def _points(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return window.y[self.plot_of.channel] * self.plot_of.scale, window.y["applied"]

    def _state(self) -> tuple:
        """Return what the layers depend on; when it changes they are painted anew."""
        (x0, x1), (y0, y1) = self.view.viewRange()
        box = self.frame().getRect()
        return x0, x1, y0, y1, box, theme.name, self.devicePixelRatioF(), self._history.epoch

    def refresh(self) -> None:
        """Add the samples that came since the last frame."""
        if not math.isnan(self._history.now):
            self._add_new()
        self.viewport().update()

    def _add_new(self) -> None:
        afresh = self._key is None or self._key[-1] != self._history.epoch
        new = self._recent() if afresh else self._history.since(self._drawn)
        if len(new.x):
            self._widen(*self._points(new))
        self._drawn = self._history.total
        self.measure()
        if self._layers is None or self._key != self._state():
            self._key, self._under = self._state(), None
            self._layers = Layers(self.frame(), self.devicePixelRatioF(), theme.color("applied"))
            self._layers.begin(*self._line(self._recent()))
        elif self._layers.add(*self._line(new)):
            self._under = None

    def _line(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return window.x, np.stack(self.to_pixels(*self._points(window)))

    def point(self, time: float | None) -> None:
        """Mark the sample at a time in s; None: no mark."""
        self._pointed = None if time is None else self._history.at(time)

    # painting -----------------------------------------------------------------------------------

    def drawBackground(self, painter: QPainter, rect: QRectF) -> None:
        """Paint everything but the newest second, from one picture."""
        if self._under is None or self._key != self._state():
            self._under = self._paint_old(self.measure())
        painter.drawPixmap(0, 0, self._under)

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint the newest second."""
        if self._layers is not None:
            self._layers.paint_newest(painter)

    def _paint_old(self, box: QRectF) -> QPixmap:
        """Return ground, theory, limits, and the layers from old to new."""
        ratio = self.devicePixelRatioF()
        under = QPixmap(self.viewport().size() * ratio)
        under.setDevicePixelRatio(ratio)
        painter = QPainter(under)
        self.paint_ground(painter, QRectF(self.viewport().rect()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setClipRect(box)
        if self._theory is not None:
            self._band(painter)
        if math.isfinite(self.max_force):
            self._limits(painter, box)
        if self._layers is not None:
            self._layers.paint_old(painter)
        painter.end()
        return under

    def _band(self, painter: QPainter) -> None:
        x, branches = self._theory  # type: ignore[misc]
        lines = [line for force in branches for line in self._unbroken(x, force)]
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            painter.setPen(QPen(theme.color(token), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
            for line in lines:
                painter.drawPolyline(line)

    def _unbroken(self, x: np.ndarray, force: np.ndarray) -> list[QPolygonF]:
        """Return a branch as lines in pixels, cut where it has no value."""
        across, up = self.to_pixels(x, force)
        cuts = np.flatnonzero(np.diff(np.isfinite(force))) + 1
        pieces = zip(np.split(across, cuts), np.split(np.clip(up, -_FAR, _FAR), cuts), strict=True)
        return [QPolygonF(list(map(QPointF, a, b))) for a, b in pieces if np.isfinite(b[0])]

    def _limits(self, painter: QPainter, box: QRectF) -> None:
        for sign in (1, -1):
            y = self.pixel(0.0, sign * self.max_force).y()
            if box.top() < y < box.bottom():
                painter.setPen(strokes.pen(theme.color("danger"), 1.6, [1.2, 2.6]))
                painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y))
                text = f"limit {number(sign * self.max_force, 1)} N"
                self.note(painter, box.left() + 6, y - 5, text, "danger")

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dots for now and for the pointer's time."""
        if not math.isnan(self._history.now):
            self._dot(painter, self._history.latest(), 5.0)
        if self._pointed is not None:
            self._dot(painter, self._pointed, 3.5)

    def _dot(self, painter: QPainter, at: dict[str, float], radius: float) -> None:
        place = self.pixel(at[self.plot_of.channel] * self.plot_of.scale, at["applied"])
        strokes.mark(painter, place, "applied", radius)

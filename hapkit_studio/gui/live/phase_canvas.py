"""Force over something: theory as a band, the last ten seconds over it, paler the older, a dot for now."""

import math

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF
from PySide6.QtGui import QPainter, QPixmap

from hapkit_studio.gui.live import strokes
from hapkit_studio.gui.live.canvas import Canvas, fitted, widened
from hapkit_studio.gui.live.history import History, Window
from hapkit_studio.gui.live.past_trace import EnvironmentStart, PastTrace, name_size, paint_name, paint_past
from hapkit_studio.gui.live.phase_layers import SECONDS, Band, Layers, Place
from hapkit_studio.gui.live.plots.declared import PhasePlot
from hapkit_studio.gui.widgets.theme import number, theme

_MARGIN = 6.0
"""px that words keep from the frame."""
_STILL = 10.0
"""px: a past that went no farther is hardly seen, and has no name."""
_LIMIT_WORDS = 14.0
"""px that a limit's name stands out above its line."""
_NO_BAND = Band(np.empty(0), np.empty((0, 0)))


def emptiest_corner(box: QRectF, size: QSizeF, across: np.ndarray, down: np.ndarray) -> QRectF:
    """Return where words of a size in px stand: in the corner with the fewest points (n,) in px."""
    left, top = box.left() + _MARGIN, box.top() + _MARGIN
    right = max(box.right() - _MARGIN - size.width(), left)
    bottom = box.bottom() - _MARGIN - size.height()
    corners = [QRectF(QPointF(x, y), size) for y in (top, bottom) for x in (right, left)]
    return min(corners, key=lambda corner: _inside(corner, across, down))


def _inside(corner: QRectF, across: np.ndarray, down: np.ndarray) -> int:
    near = corner.adjusted(-_MARGIN, -_MARGIN, _MARGIN, _MARGIN)
    beside = (near.left() <= across) & (across <= near.right())
    return int(np.count_nonzero(beside & (near.top() <= down) & (down <= near.bottom())))


class PhaseCanvas(Canvas):
    """Paints one PhasePlot of a history."""

    def __init__(self, plot: PhasePlot):
        super().__init__(True)
        self.max_force = math.inf
        self._live = self._history = History(seconds=1.0, rate=1.0)
        self._layers = Layers()
        self._key: tuple | None = None
        self._drawn = 0
        self._begin = EnvironmentStart()
        self._under: QPixmap | None = None
        self.band = _NO_BAND
        self._pointed: dict[str, float] | None = None
        self._fitted = False
        self._past: PastTrace | None = None
        self.bottom.setHeight(38)
        self.bottom.label.setCacheMode(self.bottom.cacheMode())
        self.set_plot(plot)

    def set_plot(self, plot: PhasePlot) -> None:
        """Show another plot."""
        self.plot_of = plot
        self.setAccessibleName(f"Force in N over {plot.label}")
        self.bottom.setLabel(plot.label)
        self.recolor()
        self._forget()

    def recolor(self) -> None:
        """Take the theme's colours and fonts."""
        super().recolor()
        self.bottom.label.setFont(theme.font("tick"))
        self.bottom.label.setDefaultTextColor(theme.color("ink3"))

    def set_history(self, history: History) -> None:
        """Plot another history."""
        self._live = self._history = history
        self._begin = EnvironmentStart()
        self._forget()

    def begin_here(self) -> None:
        """Leave out what is older than now: it belongs to another environment."""
        self._begin.set_now(self._live)
        self._forget()

    def set_past(self, past: PastTrace | None) -> None:
        """Show a past stretch under the curve, or none any more."""
        self._past, self._under = past, None
        if past is not None:
            self._widen(past.values[self.plot_of.channel] * self.plot_of.scale, past.values["applied"])
        self.viewport().update()

    def _forget(self) -> None:
        self._layers, self._key, self._under = Layers(), None, None

    def set_paused(self, paused: bool) -> None:
        """Freeze what is shown; the live history goes on."""
        self._history = self._live.copy() if paused else self._live

    # axes ---------------------------------------------------------------------------------------

    def set_theory(self, x: np.ndarray, force: np.ndarray | None, max_force: float) -> None:
        """Take the law's force in N over x (n,), SI, one row a branch (None: no band), and its limit in N."""
        self.band = _NO_BAND if force is None else Band(x * self.plot_of.scale, np.asarray(force))
        self.max_force, self._under = max_force, None
        self.viewport().update()

    def fit_theory(self) -> None:
        """Show where the theory has something to show, and of its force what the motor can give."""
        self._show(*self._theory_ranges())
        self._fitted = False

    def widen_theory(self) -> None:
        """Make room for a changed theory at once, unless a person has fitted the axes to the data."""
        if not self._fitted:
            pairs = zip(self.view.viewRange(), self._theory_ranges(), strict=True)
            self._show(*((min(a[0], b[0]), max(a[1], b[1])) for a, b in pairs))

    def _theory_ranges(self) -> tuple[tuple[float, float], tuple[float, float]]:
        reach = self.band.reach(self.plot_of.reach, self.plot_of.most, self.max_force)
        return (-reach, reach), self.band.forces(reach, self.max_force)

    def fit(self) -> None:
        """Narrow the axes to the last seconds."""
        x, y = self._points(self._recent())
        if not x.size:
            return
        pairs = ((x, self.plot_of.reach / 8), (y, 0.2))
        self._show(*(fitted(float(np.nanmin(v)), float(np.nanmax(v)), least) for v, least in pairs))
        self._fitted = True

    def _widen(self, *points: np.ndarray) -> None:
        pairs = zip(self.view.viewRange(), points, strict=True)
        self._show(*(widened(tuple(r), float(np.nanmin(v)), float(np.nanmax(v))) for r, v in pairs))

    def _show(self, across: tuple[float, float], up: tuple[float, float]) -> None:
        if [list(across), list(up)] != self.view.viewRange():
            self.view.setRange(xRange=across, yRange=up, padding=0)

    # data ---------------------------------------------------------------------------------------

    def _recent(self) -> Window:
        return self._history.between(max(self._history.now - SECONDS, self._first()), math.inf)

    def _first(self) -> float:
        return self._begin.time_in(self._history)

    def _points(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        return window.y[self.plot_of.channel] * self.plot_of.scale, window.y["applied"]

    def _state(self) -> tuple:
        """Return what the layers depend on; when it changes they are painted anew."""
        (x0, x1), (y0, y1) = self.view.viewRange()
        box = self.frame().getRect()
        return x0, x1, y0, y1, box, theme.name, self.devicePixelRatioF(), self._history.epoch

    def refresh(self) -> None:
        """Add the samples that came since the last frame."""
        if self._history.now >= self._first():
            self._add_new()
        self.viewport().update()

    def _add_new(self) -> None:
        if self._key is not None and self._key[-1] != self._history.epoch:
            self._forget()
        new = self._recent() if self._key is None else self._history.since(self._drawn)
        if len(new.x):
            self._widen(*self._points(new))
        self._drawn = self._history.total
        state = self._state()
        if self._key != state:
            self._key, self._under = state, None
            ink = self.devicePixelRatioF(), theme.color("applied")
            self._layers.begin(self._place(), *ink, *self._line(self._recent()))
        elif self._layers.add(*self._line(new)):
            self._under = None

    def _place(self) -> Place:
        return Place(self.measure(), *self._map)

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
        self._layers.paint_newest(painter, self._place())

    def _paint_old(self, box: QRectF) -> QPixmap:
        """Return ground, theory, limits, and the layers from old to new."""
        ratio = self.devicePixelRatioF()
        under = QPixmap(self.viewport().size() * ratio)
        under.setDevicePixelRatio(ratio)
        painter = QPainter(under)
        self.paint_ground(painter, QRectF(self.viewport().rect()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setClipRect(box)
        self.band.paint(painter, self.to_pixels)
        if math.isfinite(self.max_force):
            self._limits(painter, box)
        self._paint_past(painter, box)
        self._layers.paint_old(painter, self._place())
        painter.end()
        return under

    def _paint_past(self, painter: QPainter, box: QRectF) -> None:
        """Paint the past and, if it moved, its name where that covers neither it nor theory nor a limit."""
        if self._past is None:
            return
        x = self._past.values[self.plot_of.channel] * self.plot_of.scale
        past = self.to_pixels(x, self._past.values["applied"])
        paint_past(painter, *strokes.thinned(*past))
        if np.ptp(past[0]) + np.ptp(past[1]) < _STILL:
            return
        ends, level = self.to_pixels(
            *np.meshgrid(self.view.viewRange()[0], (-self.max_force, self.max_force))
        )
        theory = [self.to_pixels(self.band.x, force) for force in self.band.force]
        drawn = past, (ends, level), (ends, level - _LIMIT_WORDS), *theory
        across, down = (np.concatenate([part[axis].ravel() for part in drawn]) for axis in (0, 1))
        place = emptiest_corner(box, name_size(self._past.words), across, down)
        paint_name(painter, place.topLeft(), self._past.words, self.devicePixelRatioF())

    def _limits(self, painter: QPainter, box: QRectF) -> None:
        for sign in (1, -1):
            y = self.pixel(0.0, sign * self.max_force).y()
            if box.top() < y < box.bottom():
                strokes.level(painter, box, y, "danger", [1.2, 2.6])
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

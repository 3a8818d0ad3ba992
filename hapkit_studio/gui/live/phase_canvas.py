"""The plot of force over position or velocity: theory as a band, the last 10 s, and the newest sample."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QPainter, QPixmap, QPolygonF

from hapkit_studio.analysis.felt import Cycle, as_felt, last_cycle
from hapkit_studio.analysis.statistics import Line
from hapkit_studio.analysis.theory import Curve, sampled
from hapkit_studio.gui.live.history import Window
from hapkit_studio.gui.live.kept_curves import KeptCurve, paint_kept_curve
from hapkit_studio.gui.live.plots.declared import PhasePlot, landmarks
from hapkit_studio.gui.live.time_view import TimeView
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.gui.widgets.canvas import Canvas, fitted, widened, with_nearest
from hapkit_studio.gui.widgets.theme import number, theme

_FAR = 1e4  # px: coordinates are clipped to this range
_LEAST_FORCE = 0.5  # N: minimum range of the force axis
_OVER_LIMIT = 1.35  # forces beyond this multiple of the force limit are not shown
_BESIDE = 0.12  # margin beyond the largest force, as a fraction of the force range
_BENT = 1e-6  # a bend is a rounding error if it is smaller than this fraction of the force's span
# turning points shown per side of a periodic curve: the edge of the central well and two further wells
_TURNS = 5
_BEYOND = 1.1  # the axis extends to this multiple of a bend's position, so that the bend is not on the border
_WORDS = 14  # px: height of a label below a line
# maximum number of points per polyline: Qt is seven times slower for one long line that crosses itself
_PIECE = 32
_MORE_SIGHT = 0.02  # margin that keeps the band's ends out of view, as a fraction of the axis
_MOST_A_SECOND = 1000  # maximum number of curve points that are drawn for each second
LEAST_CYCLE = 0.5e-3  # m, peak to peak: a smaller motion is noise

Range = tuple[float, float]
Mapping = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
SECONDS = 10
# opacity of the samples by their age in whole seconds
_AGES = (1.0, 1.0, 0.55, 0.55, 0.40, 0.40, 0.30, 0.30, 0.25, 0.25, 0.25)


@dataclass(frozen=True)
class Band:
    """The law's force in N, one row per branch (m, n), over x (n,) in the plot's unit; NaN if undefined.

    ``even`` is the mask of the evenly spaced points, in which bends are searched; the other points refine
    bends and jumps.
    """

    x: np.ndarray
    force: np.ndarray
    even: np.ndarray | None = None

    @cached_property
    def steps(self) -> "Band":
        """Return the evenly spaced points of the band."""
        return self if self.even is None else Band(self.x[self.even], self.force[:, self.even])

    def forces(self, reach: float, max_force: float) -> Range:
        """Return the range of forces in N to show within ±reach, with a margin, for the force limit in N."""
        seen = self.force[:, np.abs(self.x) <= reach]
        seen = seen[np.isfinite(seen)]
        low, high = seen.min(initial=-_LEAST_FORCE), seen.max(initial=_LEAST_FORCE)
        most = _OVER_LIMIT * max_force
        low, high = max(low, -most), min(high, most)
        margin = _BESIDE * (high - low)
        return low - margin, high + margin

    def around(self, x: np.ndarray, force: np.ndarray, max_force: float) -> tuple[Range, Range]:
        """Return axis ranges that contain points (n,), the nearest landmark and the curve between them."""
        low, high = with_nearest(*_ends(x), landmarks(self.steps.x, self.steps.force))
        most = _OVER_LIMIT * max_force
        seen = np.clip(self.force[:, (self.x >= low) & (self.x <= high)], -most, most)
        return (low, high), _ends(np.append(seen, force))

    def reach(self, least: float, most: float, max_force: float) -> float:
        """Return the plot's initial half width: ``least`` to ``most``, rounded up to quarters of ``least``.

        The plot shows the last bend that the motor can render or, for a periodic curve, a few turning points.
        """
        sides = [(side, row) for row in self.steps.force for side in (1.0, -1.0)]
        far = max((self._last(row, side, most, max_force) for side, row in sides), default=0.0)
        part = least / 4.0
        return min(max(math.ceil(_BEYOND * far / part - 1e-9) * part, least), most)

    def _last(self, row: np.ndarray, side: float, most: float, max_force: float) -> float:
        """Return the distance of a branch's last bend or turning point on one side; 0 for a straight line."""
        x = side * self.steps.x
        out = np.argsort(x)
        out = out[(x[out] >= 0.0) & (x[out] <= most)]
        distance, force = x[out], row[out]
        least = _BENT * np.fmax.reduce(np.abs(force), initial=0.0)
        rise = np.diff(force)
        rise[np.abs(rise) <= least] = 0.0
        shown = np.abs(force) < _OVER_LIMIT * max_force
        bent = np.abs(np.diff(rise)) > least
        bends = np.flatnonzero(bent & shown[:-2] & shown[2:]) + 1
        if not len(bends):
            return 0.0
        going = np.flatnonzero(np.nan_to_num(rise))
        turns = going[1:][rise[going[1:]] * rise[going[:-1]] < 0.0][:_TURNS]
        last = min(bends[-1], turns[-1]) if len(turns) == _TURNS else bends[-1]
        return float(distance[last])

    def side(self, force: float) -> float:
        """Return the side on which the curve exceeds a force in N: < 0 left, > 0 right, 0 neither or both."""
        _, beyond = np.nonzero(np.copysign(1.0, force) * self.steps.force >= abs(force))
        return float(np.sign(self.steps.x[beyond]).sum())

    def paint(self, painter: QPainter, to_pixels: Mapping) -> None:
        """Paint the outlines of all branches, then the band."""
        lines = [line for force in self.force for line in self._unbroken(force, to_pixels)]
        for token, width in (("edge", 8.8), ("theory", 6.4)):
            painter.setPen(strokes.pen(theme.color(token), width))
            for line in lines:
                painter.drawPolyline(line)

    def _unbroken(self, force: np.ndarray, to_pixels: Mapping) -> list[QPolygonF]:
        """Return a branch as pixel polylines that are cut at NaN.

        Long lines are split into overlapping pieces.
        """
        across, up = to_pixels(self.x, force)
        cuts = np.flatnonzero(np.diff(np.isfinite(force))) + 1
        pieces = zip(np.split(across, cuts), np.split(np.clip(up, -_FAR, _FAR), cuts), strict=True)
        points = [list(map(QPointF, a, b)) for a, b in pieces if np.isfinite(b[0])]
        return [QPolygonF(p[i : i + _PIECE + 2]) for p in points for i in range(0, len(p), _PIECE)]


def _ends(values: np.ndarray) -> Range:
    """Return minimum and maximum, ignoring NaN."""
    return float(np.nanmin(values)), float(np.nanmax(values))


_NO_BAND = Band(np.empty(0), np.empty((0, 0)))


class PhaseCanvas(Canvas):
    """Paints one PhasePlot from a history."""

    below = 38

    def __init__(self, plot: PhasePlot, view: TimeView):
        super().__init__(True)
        self.max_force = math.inf
        self._seen = view
        view.changed.connect(self._repaint)
        self._key: tuple | None = None
        self._under: QPixmap | None = None
        self._curve: Curve | None = None
        self._sight: tuple[tuple[float, float, int], Band] | None = None
        self.band = _NO_BAND
        self._pointed: dict[str, float] | None = None
        self._fitted = False
        self._kept_curves: tuple[KeptCurve, ...] = ()
        self._line: Line | None = None
        self.delay: float | None = None
        self._delay_since = -math.inf
        self.felt = False
        self.bottom.label.setCacheMode(self.bottom.cacheMode())
        self.set_plot(plot)

    def set_plot(self, plot: PhasePlot) -> None:
        """Show another plot."""
        self.plot_of = plot
        self.setAccessibleName(f"Force in N over {plot.label}")
        self.bottom.setLabel(plot.label)
        self.recolor()
        self._under = None

    def set_kept_curves(self, curves: tuple[KeptCurve, ...]) -> None:
        """Show these kept curves behind the live data."""
        self._kept_curves = curves
        for curve in curves:
            self._widen(*self._kept_points(curve))
        self._repaint()

    def set_felt(self, felt: bool, delay: float | None) -> None:
        """If ``felt``, draw each force at the position at which it acted, ``delay`` s after its sample.

        Without ``felt``, or if the delay is unknown, each force is drawn at the position of its sample.
        """
        if (felt, delay) != (self.felt, self.delay):
            if delay != self.delay and self.delay is not None:
                self._delay_since = self._seen.live.now
            self.felt, self.delay = felt, delay
            self._repaint()

    def cycle(self) -> Cycle | None:
        """Return the newest complete cycle of the last seconds.

        Return None without a cycle, or if the delay is unknown.
        """
        window = self._recent()
        if self.delay is None or window.dense:
            return None
        return last_cycle(window.x, window.y["position"], window.y["applied_force"], self.delay, LEAST_CYCLE)

    def show_line(self, line: Line | None) -> None:
        """Draw the line that was fitted to force over position (SI); None removes the line."""
        self._line = line
        self.viewport().update()

    def _repaint(self) -> None:
        self._under = None
        self.viewport().update()

    # axes ---------------------------------------------------------------------------------------

    def set_theory(self, curve: Curve | None, max_force: float) -> None:
        """Set the law's force over x in SI (None shows no band) and the force limit in N."""
        self._curve, self._sight, self.max_force = curve, None, max_force
        self.band = self._band_of(curve)
        self._repaint()

    @property
    def has_theory(self) -> bool:
        """Return True if a band is shown."""
        return self._curve is not None

    def _band_of(self, curve: Curve | None) -> Band:
        return _NO_BAND if curve is None else Band(curve.x * self.plot_of.scale, curve.force, curve.even)

    def _band_in_sight(self, box: QRectF) -> Band:
        """Return the band within the axes and a small margin, with at least two points per pixel."""
        if self._curve is None:
            return _NO_BAND
        low, high = (end / self.plot_of.scale for end in self.view.viewRange()[0])
        more = _MORE_SIGHT * (high - low)
        seen = low - more, high + more, math.ceil((1.0 + 2.0 * _MORE_SIGHT) * box.width())
        if self._sight is None or self._sight[0] != seen:
            self._sight = seen, self._band_of(sampled(self._curve.force_at, *seen))
        return self._sight[1]

    def fit_theory(self) -> None:
        """Set the axes to the initial range of the theory, limited to the motor's force."""
        self._show(*self._theory_ranges())
        self._fitted = False

    def widen_theory(self) -> None:
        """Extend the axes for a changed theory, unless the user has fitted them to the data."""
        if not (self._fitted or self._seen.locked):
            pairs = zip(self.view.viewRange(), self._theory_ranges(), strict=True)
            self._show(*((min(a[0], b[0]), max(a[1], b[1])) for a, b in pairs))

    def _theory_ranges(self) -> tuple[Range, Range]:
        reach = self.band.reach(self.plot_of.reach, self.plot_of.most, self.max_force)
        return (-reach, reach), self.band.forces(reach, self.max_force)

    def fit(self) -> None:
        """Fit the axes to the last seconds and the nearest landmark, such as a wall."""
        x, y = self._points(self._recent())
        if not x.size:
            return
        across, up = self.band.around(x, y, self.max_force)
        self._show(fitted(*across, self.plot_of.reach / 8), fitted(*up, 0.2))
        self._fitted = True

    def _widen(self, *points: np.ndarray) -> None:
        if self._seen.locked:
            return
        pairs = zip(self.view.viewRange(), points, strict=True)
        self._show(*(widened(tuple(r), *_ends(v)) for r, v in pairs))

    def _show(self, across: Range, up: Range) -> None:
        if [list(across), list(up)] != self.view.viewRange():
            self.view.setRange(xRange=across, yRange=up, padding=0)

    # data ---------------------------------------------------------------------------------------

    def _first(self) -> float:
        """Return the time in s of the first shown sample.

        All shown samples belong to the same environment; if they are drawn as felt, they have the same delay.
        """
        first = max(self._seen.history.begin, self._seen.live.begin)
        return max(first, self._delay_since) if self._shows_felt and self._delay_since <= self._now else first

    @property
    def _now(self) -> float:
        """Return the time in s of the last shown sample; NaN without samples."""
        return self._seen.stretch[1]

    def _since(self, start: float) -> Window:
        """Return the shown samples from a time in s on."""
        return self._seen.history.drawn(max(start, self._first()), math.nextafter(self._now, math.inf))

    def _recent(self) -> Window:
        return self._since(self._now - SECONDS)

    @property
    def _shows_felt(self) -> bool:
        return self.felt and self.delay is not None and self.plot_of.channel == "position"

    def _points(self, window: Window) -> tuple[np.ndarray, np.ndarray]:
        """Return the points of a window: one point per sample, or two per sample if drawn as felt."""
        x, force = window.y[self.plot_of.channel], window.y["applied_force"]
        if self._shows_felt and self.delay is not None and not window.dense:
            x, force = as_felt(window.x, x, force, self.delay)
        return x * self.plot_of.scale, force

    def _kept_points(self, curve: KeptCurve) -> tuple[np.ndarray, np.ndarray]:
        """Return the points of a kept curve."""
        if self._shows_felt and curve.felt is not None:
            return curve.felt[0] * self.plot_of.scale, curve.felt[1]
        return curve.values[self.plot_of.channel] * self.plot_of.scale, curve.values["applied_force"]

    def _state(self) -> tuple:
        """Return the cache key of the picture with the older seconds."""
        now, (x, y) = self._now, self.view.viewRange()
        second = None if math.isnan(now) else math.floor(now)
        appearance = self.measure().getRect(), theme.name, self.devicePixelRatioF()
        return *x, *y, *appearance, self._first(), second, self._seen.history.complete

    def refresh(self) -> None:
        """Extend the axes to show the last seconds, and repaint."""
        recent = self._recent()
        if len(recent.x):
            self._widen(*self._points(recent))
        self.viewport().update()

    def point(self, time: float | None) -> None:
        """Mark the sample at a time in s; None removes the mark."""
        self._pointed = None if time is None else self._seen.history.at(time)

    # painting -----------------------------------------------------------------------------------

    def drawBackground(self, painter: QPainter, rect: QRectF) -> None:
        """Paint everything except the newest second from a cached picture."""
        state = self._state()
        if self._under is None or self._key != state:
            self._under, self._key = self._paint_old(self.measure()), state
        painter.drawPixmap(0, 0, self._under)

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint the newest second."""
        if not math.isnan(self._now):
            self._paint_curve(painter, self._since(math.floor(self._now)))
        if self._line is not None and self.plot_of.channel == "position":
            x, y = self.to_pixels(self._line.x * self.plot_of.scale, self._line.y)
            painter.setPen(strokes.pen(theme.color("accent"), 2.0, [4.0, 2.0]))
            painter.drawLine(QPointF(x[0], y[0]), QPointF(x[1], y[1]))

    def _paint_curve(self, painter: QPainter, window: Window, part: slice = slice(None)) -> None:
        x, y = self._points(window)
        each = len(x) // max(len(window.x), 1)
        part = slice(*(None if end is None else each * end for end in (part.start, part.stop)))
        x, y = (values[part] for values in self.to_pixels(x, y))
        step = max(len(x) // _MOST_A_SECOND, 1)
        if len(x):
            strokes.trace(painter, x[::step], y[::step], theme.color("applied"))
            strokes.arrows(painter, self.measure(), x, y, theme.color("applied"))

    def _paint_older(self, painter: QPainter) -> None:
        """Paint all but the newest second, fading with age; a gap (NaN) belongs to the second before it."""
        window = self._recent()
        seconds = np.floor(np.fmax.accumulate(window.x)) if len(window.x) else np.empty(0)
        for age in range(SECONDS, 0, -1):
            found = np.flatnonzero(seconds == math.floor(self._now) - age)
            if len(found):
                painter.setOpacity(_AGES[age])
                self._paint_curve(painter, window, slice(found[0], found[-1] + 2))
        painter.setOpacity(1.0)

    def _paint_old(self, box: QRectF) -> QPixmap:
        """Return the cached picture with background, theory, limits, kept curves and the older seconds."""
        ratio = self.devicePixelRatioF()
        under = QPixmap(self.viewport().size() * ratio)
        under.setDevicePixelRatio(ratio)
        painter = QPainter(under)
        super().drawBackground(painter, QRectF(self.viewport().rect()))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setClipRect(box)
        self._band_in_sight(box).paint(painter, self.to_pixels)
        for limit in (self.max_force, -self.max_force):
            self._paint_limit(painter, box, limit)
        for curve in self._kept_curves:
            paint_kept_curve(painter, *self.to_pixels(*self._kept_points(curve)), curve.style)
        if not math.isnan(self._now):
            self._paint_older(painter)
        painter.end()
        return under

    def _paint_limit(self, painter: QPainter, box: QRectF, limit: float) -> None:
        """Paint a labelled line at a force in N; the label avoids the curve."""
        y = self.pixel(0.0, limit).y()
        if not box.top() < y < box.bottom():
            return
        strokes.level(painter, box, y, "danger", [1.2, 2.6])
        # the label is on the side on which the curve does not reach the limit
        right = self.band.side(limit) < 0.0
        end = box.right() - 6 if right else box.left() + 6
        above, below = y - 5, y + _WORDS
        beyond = above - _WORDS > box.top() if limit > 0.0 else below + 4 < box.bottom()
        row = above if beyond == (limit > 0.0) else below
        self.note(painter, end, row, f"force limit {number(limit, 1)} N", "danger", right=right)

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dots at the newest sample and at the pointer's time."""
        newest = self._seen.history.at(self._now)
        if newest is not None:
            self._dot(painter, box, newest, 5.0)
        if self._pointed is not None:
            self._dot(painter, box, self._pointed, 3.5)

    def _dot(self, painter: QPainter, box: QRectF, at: dict[str, float], radius: float) -> None:
        """Paint a dot if it is within the axes; locked axes may exclude it."""
        place = self.pixel(at[self.plot_of.channel] * self.plot_of.scale, at["applied_force"])
        if box.contains(place):
            strokes.mark(painter, place, "applied", radius)

"""The live time plots: position, velocity and force over a common time axis; gaps are marked."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from PySide6.QtCore import QElapsedTimer, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QBrush, QFontMetricsF, QMouseEvent, QPainter, QPen, QWheelEvent
from PySide6.QtWidgets import QWidget

from hapkit_studio.analysis.oscillation import Oscillation
from hapkit_studio.environments.base import Environment
from hapkit_studio.formatting import hertz, on_screen
from hapkit_studio.gui.live.cursors import NAMES, Cursors
from hapkit_studio.gui.live.history import Window
from hapkit_studio.gui.live.kept_curves import KeptCurve, paint_kept_curve
from hapkit_studio.gui.live.plot_header import HEIGHT, Header
from hapkit_studio.gui.live.plots.declared import OBJECT, TimePlot, landmarks, phase_plots, time_plots
from hapkit_studio.gui.live.time_view import SPANS, TimeView
from hapkit_studio.gui.widgets import strokes
from hapkit_studio.gui.widgets.canvas import Canvas, fitted, widened, with_nearest
from hapkit_studio.gui.widgets.parts import vbox
from hapkit_studio.gui.widgets.theme import number, theme

FEWEST = 2
"""Number of plots shown on a projector."""
LEAST = 0.25
"""s: a gap in the data is marked if it is at least this long."""
_BESIDE = 6  # px: distance of a label from its line
_EVALUATED = "used for the check"
_ROW, _LETTERS = 16, 10  # px: base line of a label below the frame's top, and height of its letters
_GROUND = 0.85  # opacity of a divider label's background
_PALE = 0.45  # opacity of a trace while the device is disconnected
_SAME = 0.3  # px: where two lines are closer than this, the line behind is not drawn
_ROOMY = 1.5  # hysteresis: an axis narrows when its range is this many times the needed range
_MOST_ASKED = 2.0  # a requested force beyond this multiple of the force limit is cut off at the frame
_WIDTH, _UNIT_WIDTH = 44.0, 60.0  # px: width of the value axis, without a unit and with one
_EMPTY = Window(np.empty(0), {}, False)
_READOUT_MS = 100
_AXIS = 22
# px: size of a cursor's tag, and pointer distance at which a cursor's line can be grabbed
_TAG, _REACH = 15, 6
_ZOOMED = 1.0025  # zoom factor per eighth of a degree of wheel rotation, as in pyqtgraph
_LEAST_HEIGHT = 54  # px: minimum height of a plot; if there is less, one plot is folded


def gaps(x: np.ndarray, before: float = math.nan) -> list[tuple[float, float]]:
    """Return the gaps (start, stop) in s between the times x; only gaps of at least LEAST are returned.

    ``before`` is the time of the last sample to the left of x.
    """
    x = x[1:] if len(x) and math.isnan(x[0]) else x
    lost = np.flatnonzero(np.isnan(x))
    lost = lost[(lost > 0) & (lost < len(x) - 1)]
    starts, stops = [before, *x[lost - 1]], [*x[:1], *x[lost + 1]]
    pairs = zip(starts, stops, strict=False)
    return [(float(a), float(b)) for a, b in pairs if b - a > LEAST]


@dataclass
class PlotState:
    """The state that all time plots share in one frame; times are in s relative to the zero of the axis.

    Exception: the times in ``window`` are those of the history's clock.
    """

    view: TimeView
    window: Window = _EMPTY
    zero: float = 0.0
    contact: list[tuple[float, float]] = field(default_factory=list)
    gaps: list[tuple[float, float]] = field(default_factory=list)
    evaluated: tuple[float, float] | None = None
    dividers: list[tuple[float, str]] = field(default_factory=list)
    now: dict[str, float] | None = None
    surface: float | None = None
    max_force: float = np.inf
    stale: bool = False
    kept_curves: tuple[KeptCurve, ...] = ()
    pointer: float | None = None
    pointed: dict[str, float] | None = None
    cursors: list[float] = field(default_factory=list)


class TraceCanvas(Canvas):
    """Paints the traces of one TimePlot from the common PlotState.

    When the user drags a cursor, the canvas emits its new position.
    """

    cursor_dragged = Signal(int, float)

    def __init__(self, plot: TimePlot, shown: PlotState, bottom: bool, first: bool):
        self.plot_of, self.shown, self.first, self.last = plot, shown, first, bottom
        super().__init__(bottom, "s" if bottom else "", left_width=_UNIT_WIDTH if plot.beside else _WIDTH)
        if plot.beside:  # such a plot has no header that shows the unit
            self.left.unit = plot.unit
        self.setAccessibleName(f"{plot.title} over time, in {plot.unit}")
        self._dragged: int | None = None
        self.reset_range()
        self.show_range(*self._opened)

    def show_range(self, low: float, high: float) -> None:
        """Set the value axis to this range."""
        self.view.setYRange(low, high, padding=0)

    def reset_range(self) -> None:
        """Return the value axis to its initial range as soon as the visible data fit into that range."""
        self._opened = -self.plot_of.reach, self.plot_of.reach

    def extent(self) -> tuple[float, float]:
        """Return the minimum and maximum of the window and the kept curves; NaN without data."""
        window, traces = self.shown.window, self.plot_of.traces
        parts = [window.y[trace.channel] for trace in traces if len(window.x)]
        channel = traces[-1].channel
        parts += [curve.values[channel] for curve in self.shown.kept_curves if channel in curve.values]
        if not parts:
            return np.nan, np.nan
        low, high = np.fmin.reduce(np.concatenate(parts)), np.fmax.reduce(np.concatenate(parts))
        most = _MOST_ASKED * self.shown.max_force if self.plot_of.limits else np.inf
        return (
            float(np.clip(low * self.plot_of.scale, -most, most)),
            float(np.clip(high * self.plot_of.scale, -most, most)),
        )

    def fit_values(self) -> None:
        """Extend the value axis if visible data need it; narrow it if a much smaller range is enough.

        The axis narrows only while the view follows the newest sample. A locked axis does not change.
        """
        view = self.shown.view
        if view.locked:
            return
        shown, seen = tuple(self.view.viewRange()[1]), self.extent()
        wanted, least = widened(shown, *seen), widened(self._opened, *seen)
        if view.follows and wanted[1] - wanted[0] > _ROOMY * (least[1] - least[0]):
            wanted = least
        if wanted != shown:
            self.show_range(*wanted)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom the time axis; with Ctrl, or over the value axis, zoom the value axis and lock it."""
        box, place = self.measure(), event.position()
        if place.x() >= box.left() and not event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            super().wheelEvent(event)
            return
        low, high = self.view.viewRange()[1]
        about = high - (high - low) * (place.y() - box.top()) / box.height()
        factor = _ZOOMED ** -event.angleDelta().y()
        self.show_range(about + (low - about) * factor, about + (high - about) * factor)
        self.shown.view.set_locked(True)

    def fit(self, places: np.ndarray) -> None:
        """Fit the value axis to the data and the nearest of ``places`` (n,) in SI, with a minimum range."""
        low, high = self.extent()
        if np.isfinite(low):
            low, high = with_nearest(low, high, places * self.plot_of.scale)
            self._opened = fitted(low, high, self.plot_of.reach / 8)
            self.show_range(*self._opened)

    def paint_under(self, painter: QPainter, box: QRectF) -> None:
        """Shade contacts and the interval that a lesson evaluated, and hatch gaps in the data."""
        hatched = QBrush(theme.color("line"), Qt.BrushStyle.BDiagPattern)
        for brush, stretches in ((theme.color("contact"), self.shown.contact), (hatched, self.shown.gaps)):
            for start, stop in stretches:
                left, right = self.pixel(start, 0.0).x(), self.pixel(stop, 0.0).x()
                painter.fillRect(QRectF(left, box.top(), right - left, box.height()), brush)
        if self.shown.evaluated is not None:
            left, right = (self.pixel(time, 0.0).x() for time in self.shown.evaluated)
            painter.fillRect(QRectF(left, box.top(), right - left, box.height()), theme.color("accentsoft"))
            painter.setPen(QPen(theme.color("accent"), 1.5))
            for x in (left, right):
                painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))

    def paint_over(self, painter: QPainter, box: QRectF) -> None:
        """Paint limit, surface, trigger level, dividers and kept curves, then the live traces on top."""
        levels: list[tuple[float, str, list[float]]] = []
        if self.plot_of.limits and np.isfinite(self.shown.max_force):
            levels += [(s * self.shown.max_force, "danger", [1.2, 2.6]) for s in (1, -1)]
        if self.plot_of.surface and self.shown.surface is not None:
            levels.append((self.shown.surface * self.plot_of.scale, "matline", [3.5, 2.5]))
        if self.shown.view.level is not None and self.shown.view.level[0] == self.plot_of.traces[-1].channel:
            levels.append((self.shown.view.level[1] * self.plot_of.scale, "accent", [6.0, 2.0]))
        for level, token, dash in levels:
            strokes.level(painter, box, self.pixel(0.0, level).y(), token, dash)
        painter.setPen(strokes.pen(theme.color("ink3"), 1.0, [3.0, 3.0]))
        for time, _ in self.shown.dividers:
            # paint on a pixel's centre to get one sharp column of pixels instead of two paler ones
            x = math.floor(self.pixel(time, 0.0).x()) + 0.5
            painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        self._paint_kept_curves(painter)
        if len(self.shown.window.x):
            self._traces(painter, box)
        painter.setPen(QPen(theme.color("ink2"), 1))
        for time in self.shown.cursors:
            x = math.floor(self.pixel(time, 0.0).x()) + 0.5
            painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))

    def paint_marks(self, painter: QPainter, box: QRectF) -> None:
        """Paint the dot at the newest sample, and the values at the pointer."""
        trace = self.plot_of.traces[-1]
        now = self.shown.now[trace.channel] * self.plot_of.scale if self.shown.now else np.nan
        if np.isfinite(now):
            strokes.mark(painter, self.pixel(0.0, now), trace.color, shape=self.plot_of.marker)
        labels: list[QRectF] = []
        if self.first:
            labels = self._labels(painter, box)
            self._tags(painter, box)
        elif self.last and self.shown.evaluated is not None:
            self._label_evaluated(painter, box, self.shown.evaluated)
        self._pointer(painter, box, labels)

    def _label_evaluated(self, painter: QPainter, box: QRectF, evaluated: tuple[float, float]) -> None:
        """Label the interval that a lesson evaluated, if there is space for the label.

        The first plot has no such label, because it shows the dividers' labels.
        """
        start, stop = (self.pixel(time, 0.0).x() for time in evaluated)
        left, row = max(start, box.left()) + theme.px(_BESIDE), box.top() + theme.px(_ROW)
        if left + _wide(_EVALUATED) + theme.px(_BESIDE) < min(stop, box.right()):
            painter.fillRect(_label_box(left, row, _EVALUATED) & box, theme.color("accentsoft", _GROUND))
            self.note(painter, left, row, _EVALUATED, "accent")

    def _labels(self, painter: QPainter, box: QRectF) -> list[QRectF]:
        """Label gaps and dividers; return the boxes of these labels.

        A gap's label is in its middle; a divider's label covers neither the trace nor a cursor's tag.
        """
        beside, below = theme.px(_BESIDE), theme.px(_ROW)
        right, taken = box.right() - beside, []
        for start, stop in self.shown.gaps:
            left = max(self.pixel(start, 0.0).x(), box.left()) + beside
            text = f"No data for {number(stop - start, 1)} s"
            if left + _wide(text) + beside < min(self.pixel(stop, 0.0).x(), box.right()):
                self.note(painter, left, box.center().y(), text, "warn")
                taken.append(_label_box(left, box.center().y(), text))
        lowest = box.bottom() - below + theme.px(_LETTERS)
        newest, ends = True, dict.fromkeys((box.top() + below, lowest), right)
        for time, text in reversed(self.shown.dividers):
            x, wide = self.pixel(time, 0.0).x(), _wide(text)
            left = min(x + beside, right - wide) if newest else x + beside
            hidden = {r: self._hidden(r, left, left + wide) for r, end in ends.items() if left <= end - wide}
            for tag in self._tag_boxes(box).values():
                hidden |= {r: math.inf for r in hidden if tag.intersects(_label_box(left, r, text))}
            row = min(hidden, key=hidden.__getitem__, default=0.0)
            # skip an older label that would overlap a newer one, a tag or the trace
            if box.left() < x <= box.right() and hidden and (newest or not hidden[row]):
                ends[row] = min(left, x) - beside
                ground = _label_box(left, row, text)
                painter.fillRect(ground & box, theme.color("plot", _GROUND))
                self.note(painter, left, row, text, "ink2")
                taken.append(ground)
            newest = False
        return taken

    def _hidden(self, row: float, left: float, right: float) -> float:
        """Return how many points of the trace a label between two columns would cover."""
        window, channel = self.shown.window, self.plot_of.traces[-1].channel
        x, y = self.to_pixels(window.x - self.shown.zero, window.y[channel] * self.plot_of.scale)
        top, bottom = row - theme.px(_ROW), row + theme.px(_BESIDE)
        return int(np.count_nonzero((x > left) & (x < right) & (y > top) & (y < bottom)))

    def _tags(self, painter: QPainter, box: QRectF) -> None:
        """Paint the cursors' names on top of their lines."""
        painter.setFont(theme.font("label"))
        for name, tag in self._tag_boxes(box).items():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(theme.color("ink2"))
            painter.drawRoundedRect(tag, 3, 3)
            painter.setPen(theme.color("plot"))
            painter.drawText(tag, Qt.AlignmentFlag.AlignCenter, name)

    def _tag_boxes(self, box: QRectF) -> dict[str, QRectF]:
        """Return the boxes of the visible cursors' names."""
        size = theme.px(_TAG)
        places = (
            (name, self.pixel(time, 0.0).x()) for name, time in zip(NAMES, self.shown.cursors, strict=False)
        )
        return {
            name: QRectF(x - size / 2, box.top(), size, size)
            for name, x in places
            if box.left() <= x <= box.right()
        }

    def _cursor_near(self, x: float) -> int | None:
        """Return the index of the cursor near a pixel column (0: A); None if no cursor is near."""
        places = [abs(self.pixel(time, 0.0).x() - x) for time in self.shown.cursors]
        nearest = min(range(len(places)), key=places.__getitem__, default=None)
        return nearest if nearest is not None and places[nearest] <= theme.px(_REACH) else None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Grab a cursor if one is near."""
        self.measure()
        self._dragged = self._cursor_near(event.position().x())
        if self._dragged is None:
            super().mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Drag the grabbed cursor, otherwise report the pointer's position."""
        x = event.position().x()
        if self._dragged is not None:
            self.cursor_dragged.emit(self._dragged, self.to_x(x))
            return
        super().mouseMoveEvent(event)
        near = self._cursor_near(x) is not None
        self.viewport().setCursor(Qt.CursorShape.SplitHCursor if near else Qt.CursorShape.ArrowCursor)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if self._dragged is None:
            super().mouseReleaseEvent(event)
        self._dragged = None

    def _paint_kept_curves(self, painter: QPainter) -> None:
        channel = self.plot_of.traces[-1].channel
        for curve in self.shown.kept_curves:
            if channel in curve.values:
                # while the view follows the newest sample, a pinned trace ends there
                ends = curve.time[-1] if self.shown.view.follows else 0.0
                time = curve.time - (ends if curve.pinned else self.shown.zero)
                line = self.to_pixels(time, curve.values[channel] * self.plot_of.scale)
                paint_kept_curve(painter, *line, curve.style)

    def _traces(self, painter: QPainter, box: QRectF) -> None:
        x, y = self.shown.window.x - self.shown.zero, self.shown.window.y
        there = [t for t in self.plot_of.traces if t.label or np.isfinite(y[t.channel]).any()]
        lines = [self.to_pixels(x, y[trace.channel] * self.plot_of.scale) for trace in there]
        for trace, (across, up) in zip(there, lines, strict=True):
            color = theme.paler(trace.color, "plot", _PALE if self.shown.stale else 1.0)
            strokes.arrows(painter, box, across, up, color)
            painter.setPen(strokes.pen(color, 2.0))
            if trace.dash:
                strokes.segments(painter, strokes.patterned(across, up, trace.dash))
            elif trace.dashed:
                strokes.segments(painter, strokes.dashed(across, _where_visible(up, lines[-1][1])))
            else:
                strokes.trace(painter, across, up, color)

    def _pointer(self, painter: QPainter, box: QRectF, labels: list[QRectF]) -> None:
        """Paint a line, a dot and the values at the pointer; the values cover no label."""
        if self.shown.pointer is None or self.shown.pointed is None:
            return
        trace = self.plot_of.traces[-1]
        value = self.shown.pointed[trace.channel] * self.plot_of.scale
        if not np.isfinite(value):
            return
        place = self.pixel(self.shown.pointer, value)
        x = place.x()
        painter.setPen(QPen(theme.color("ink3"), 1))
        painter.drawLine(QPointF(x, box.top()), QPointF(x, box.bottom()))
        strokes.mark(painter, place, trace.color, 3.0)
        text = f"{number(value, self.plot_of.decimals, sign=True)} {self.plot_of.unit}"
        if self.first:
            text = f"{number(self.shown.pointer, 3)} s   {text}"
        left = x > box.center().x()
        beside = x - 8 - _wide(text) if left else x + 8
        rows = box.bottom() - 6, box.center().y() + theme.px(_LETTERS) / 2, box.top() + theme.px(_ROW)
        free = (row for row in rows if not any(_label_box(beside, row, text).intersects(b) for b in labels))
        self.note(painter, beside, next(free, rows[0]), text, trace.color)


def _wide(text: str) -> float:
    """Return the width in px of a label inside a plot."""
    return QFontMetricsF(theme.font("label")).horizontalAdvance(text)


def _label_box(left: float, row: float, text: str) -> QRectF:
    """Return the box of a label; ``left`` is its left edge and ``row`` its base line, in px."""
    high = theme.px(_LETTERS)
    return QRectF(left, row - high, _wide(text), high).adjusted(-3, -3, 3, 4)


def _where_visible(line: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Return a line with NaN at points that another line hides.

    At each end of a visible part, one hidden point is kept, so that the part joins the other line.
    """
    apart = np.abs(line - above) > _SAME
    near = apart.copy()
    near[1:] |= apart[:-1]
    near[:-1] |= apart[1:]
    return np.where(near, line, np.nan)


class TimePlots(QWidget):
    """The plots, which can be panned and zoomed in time; ``back_pressed``: the user wants live data again."""

    pointed = Signal(object)
    back_pressed = Signal()

    def __init__(self, view: TimeView | None = None, plots: list[TimePlot] | None = None):
        super().__init__()
        self.plots = time_plots() if plots is None else plots
        self.view = TimeView(self) if view is None else view
        self.shown, self.cursors = PlotState(self.view), Cursors(self.view, self)
        self._always_folded = False
        self._shades = False
        self._environment: Environment | None = None
        self._values: Mapping[str, float] = {}
        self._watch = QElapsedTimer()
        self._watch.start()
        self._column = vbox(into=self, margins=(14, 2, 0, 6))
        self.headers = [Header(plot) for plot in self.plots]
        last = len(self.plots) - 1
        self.canvases = [
            TraceCanvas(plot, self.shown, index == last, index == 0) for index, plot in enumerate(self.plots)
        ]
        for header, canvas in zip(self.headers, self.canvases, strict=True):
            self._column.addWidget(header)
            self._column.addWidget(canvas)
            canvas.fit_wanted.connect(self.fit)
            canvas.pointed.connect(self._point)
            canvas.cursor_dragged.connect(lambda index, x: self.cursors.move(index, self.shown.zero + x))
            canvas.view.setMouseEnabled(True, False)
            canvas.view.setLimits(minXRange=0.005, maxXRange=SPANS[-1])
            canvas.view.sigXRangeChanged.connect(lambda _view, ends: self.view.move(*ends))
            header.back.clicked.connect(self.back_pressed)
            header.unlock.clicked.connect(lambda: self.view.set_locked(False))
        self.view.changed.connect(self._follow_view)
        self.cursors.changed.connect(self._read_cursors)
        self._follow_view()

    # setters ------------------------------------------------------------------------------------

    def set_environment(self, environment, values: Mapping[str, float], max_force: float) -> None:
        """Set the environment and the force limit in N.

        The environment determines the contact shading and the surface line. After a change of environment,
        the value axes return to their initial ranges once older data have left the view.
        """
        if environment is not self._environment:
            for canvas in self.canvases:
                canvas.reset_range()
        self._environment, self._values = environment, values
        self._shades = bool(environment.shades)
        self.shown.surface = values.get("position") if self._shades else None
        self.shown.max_force = self.cursors.max_force = max_force
        for header in self.headers:
            name = "" if self.shown.surface is None else environment.title.lower()
            header.show_part(header.surface, name)

    def set_kept_curves(self, curves: tuple[KeptCurve, ...]) -> None:
        """Show these kept curves below the live traces."""
        self.shown.kept_curves = curves
        self.refresh()

    def show_oscillation(self, found: Oscillation | None) -> None:
        """Show an oscillation's amplitude and frequency beside the position, unless cursors are shown."""
        header = next(header for header in self.headers if header.plot.key == "position")
        if self.cursors.on:
            return
        if found is None:
            header.remark.set_texts()
            return
        far = f"±{on_screen(found.amplitude, 'm', 2)}"
        if math.isnan(found.frequency):
            header.remark.set_texts(f"oscillates by {far}", far)
            return
        often = hertz(found.frequency)
        header.remark.set_texts(f"oscillates by {far} at {often}", f"{far}, {often}", often)

    def _read_cursors(self) -> None:
        """Show the values at both cursors above each plot."""
        at = [values for values in self.cursors.at() if values]
        for header in self.headers:
            plot, texts = header.plot, []
            if len(at) == len(NAMES):
                a, b = (values[plot.traces[-1].channel] * plot.scale for values in at)
                apart = f"B − A {number(b - a, plot.decimals, sign=True)}"
                texts = [f"A {number(a, plot.decimals)}   B {number(b, plot.decimals)}   {apart}", apart]
            header.remark.set_texts(*texts)
        self.refresh()

    def set_stale(self, stale: bool) -> None:
        """Paint in paler colours while the device is disconnected.

        Repaint at once, because no new frame causes a repaint.
        """
        self.shown.stale = stale
        for canvas in self.canvases:
            canvas.viewport().update()

    def fit(self) -> None:
        """Fit the value axes to the shown data; the position's axis also includes the nearest landmark."""
        for canvas in self.canvases:
            canvas.fit(self._landmarks() if canvas.plot_of.surface else np.empty(0))
        self.refresh()

    def _landmarks(self) -> np.ndarray:
        """Return the positions in m at which the law's force over position bends or changes sign."""
        plot = next(plot for plot in phase_plots() if plot.channel == "position")
        curve = plot.theory_of(self._environment, self._values) if self._environment else None
        return np.empty(0) if curve is None else landmarks(curve.x[curve.even], curve.force[:, curve.even])

    def put_cursor(self, index: int) -> None:
        """Show the cursors; if the pointer is over a plot, move one of them (0: A) to the pointer."""
        self.cursors.show(True)
        if self.shown.pointer is not None:
            self.cursors.move(index, self.shown.zero + self.shown.pointer)

    def refresh(self) -> None:
        """Draw the newest data; call once per frame."""
        self.read_window()
        pointed = self.shown.pointed is not None
        self.pointed.emit(self.shown.zero + (self.shown.pointer or 0.0) if pointed else None)
        for canvas in self.canvases:
            if canvas.isVisible():
                canvas.viewport().update()
        if self._watch.elapsed() >= _READOUT_MS:
            self._watch.restart()
            self._update_headers()

    def _update_headers(self) -> None:
        """Update the live values, unless paused, and the state of the view in the headers."""
        newest = self.view.latest
        moves = self._environment.moves if self._environment is not None else None
        for header, canvas in zip(self.headers, self.canvases, strict=True):
            header.show_view(self.view.status if canvas.first else "", self.view.locked and canvas.first)
            if not self.view.live.empty:
                header.show_value(newest[header.plot.traces[-1].channel])
                text = f"{moves.name} {header.written(newest[OBJECT])}" if moves is not None else ""
                header.show_part(header.object, text)

    def read_window(self) -> None:
        """Read the window from the history and adjust the value axes."""
        shown, view, seen = self.shown, self.view, self.view.history
        columns = max(round(self.canvases[-1].measure().width() * self.devicePixelRatioF()), 2)
        width = view.span / columns
        if math.isnan(view.zero):
            shown.window, shown.contact, shown.gaps, shown.dividers, shown.now = _EMPTY, [], [], [], None
            shown.evaluated = None
            for canvas in self.canvases:
                canvas.fit_values()
            return
        # Align the columns to multiples of their width: each then contains the same samples in every frame,
        # so that peaks do not flicker.
        begin, last = (0.0, math.ceil(view.zero / width)) if view.follows else (view.zero, 0)
        shown.zero = begin + last * width
        first = last + math.floor(view.left / width + 1e-6)
        edges = begin + np.arange(first, first + columns + 2) * width
        shown.window = seen.window(edges)
        shown.now = seen.latest() if view.follows else None
        shown.contact = self._contact() if self._shades else []
        lost = gaps(shown.window.x, seen.before(edges[0]))
        shown.gaps = [(a - shown.zero, b - shown.zero) for a, b in lost]
        found = seen.evaluated
        shown.evaluated = None if found is None else (found[0] - shown.zero, found[1] - shown.zero)
        event = [(view.zero, view.happened)] if view.happened else []
        shown.dividers = [(time - shown.zero, text) for time, text in sorted([*seen.dividers, *event])]
        shown.cursors = [time - shown.zero for time in self.cursors.times or ()]
        pointer = math.inf if shown.pointer is None else shown.zero + shown.pointer
        shown.pointed = seen.at(pointer) if pointer <= seen.now + width else None
        for canvas in self.canvases:
            canvas.fit_values()

    def _contact(self) -> list[tuple[float, float]]:
        """Return the intervals (start, stop) in which this environment requested a force.

        The times are in s after the zero of the time axis.
        """
        window = self.shown.window
        touching = (np.nan_to_num(window.y["force"]) != 0.0) & (window.x >= self.view.history.begin)
        if window.dense and not np.isnan(window.x).any():
            touching = np.repeat(touching.reshape(-1, 2).any(axis=1), 2)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], touching, [False]]).astype(np.int8)))
        x = window.x - self.shown.zero
        return [(float(x[a]), float(x[b - 1])) for a, b in edges.reshape(-1, 2)]

    # view ---------------------------------------------------------------------------------------

    def _follow_view(self) -> None:
        """Apply the view's time range to all plots; keep the pointer's line at the same pixel."""
        left, right = self.canvases[-1].view.viewRange()[0]
        if self.shown.pointer is not None:
            place = (self.shown.pointer - left) / (right - left)
            self.shown.pointer = self.view.left + place * self.view.span
        for canvas in self.canvases:
            if canvas.view.viewRange()[0] != [self.view.left, self.view.right]:
                canvas.view.setXRange(self.view.left, self.view.right, padding=0)
        self._update_headers()
        self.refresh()

    def _point(self, time: float | None) -> None:
        self.shown.pointer = time
        self.refresh()

    def set_folded(self, on: bool) -> None:
        """If ``on`` (projector), fold plots until FEWEST remain; otherwise only if there is little height."""
        self._always_folded = on
        self._distribute()

    def resizeEvent(self, event) -> None:
        """Distribute the height; fold plots if there is too little height."""
        super().resizeEvent(event)
        self._distribute()

    def _distribute(self) -> None:
        margins = self._column.contentsMargins()
        room = self.height() - margins.top() - margins.bottom()
        folded = self._folded(room)
        free = room - HEIGHT * folded.count(False) - _AXIS
        whole = sum(p.share for p, away in zip(self.plots, folded, strict=True) if not away)
        for plot, header, canvas, away in zip(self.plots, self.headers, self.canvases, folded, strict=True):
            header.setVisible(not away)
            canvas.setVisible(not away)
            canvas.first = canvas is self.canvases[folded.index(False)]
            axis = _AXIS if canvas is self.canvases[-1] else 0
            self._column.setStretchFactor(canvas, max(int(free * plot.share / whole), 1) + axis)

    def _folded(self, room: int) -> list[bool]:
        """Return for each plot whether it is folded if ``room`` px of height are available."""
        shown = list(self.plots)
        for plot in sorted((p for p in self.plots if p.folds), key=lambda p: p.folds):
            needed = len(shown) * (HEIGHT + _LEAST_HEIGHT) + _AXIS
            if (self._always_folded and len(shown) > FEWEST) or room < needed:
                shown.remove(plot)
        return [plot not in shown for plot in self.plots]
